"""The place of take-off: around it, what the map does not know counts as free."""

from __future__ import annotations

import numpy as np

from exploration.planning import PathPlanner
from node_tools.ending import Ending
from node_tools.restarts.kept_parameter import KeptParameter


class TakeOffPlace:
    """The first place of the UAV in this launch.

    A node that dies in flight and starts again finds it in its parameter ~take_off. The place in the air must
    not count for it: around that may be walls that the map does not know yet.

    Args:
        radius_m: what is unknown this near to it counts as free. ending: of the node.
    """

    def __init__(self, radius_m: float, ending: Ending) -> None:
        self._radius_m = radius_m
        self._kept = KeptParameter("~take_off", ending)
        place_m = self._kept.values.get("place")
        self.place_m: np.ndarray | None = None if place_m is None else np.array(place_m)

    def note(self, here_m: np.ndarray) -> None:
        """Take a place (x, y, z) of the UAV in the map's frame. The first one counts."""
        if self.place_m is None:
            self.place_m = here_m
            self._kept.keep({"place": here_m.tolist()})

    def mark_free(self, planner: PathPlanner) -> None:
        """Tell the planner."""
        if self.place_m is not None and self._radius_m > 0.0:
            planner.assume_free(self.place_m, self._radius_m)
