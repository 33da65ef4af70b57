"""How a UAV comes home from an inspection, also where the planner knows no way or CEPA flies none."""

from __future__ import annotations

import math

import numpy as np

from exploration.energy import EnergyWatch, WayBack
from exploration.planning import PathPlanner
from flight_basics.errors import NoPathError
from inspection.flight.parameters import InspectionParameters

STUCK_M = 0.8
"""Of the way that it came, what is nearer to a UAV that does not get on is left out."""
CLOSED_M = 1.2
"""So far ahead of it a place is closed then."""


class Homing(WayBack):
    """Leads one UAV home.

    Attributes:
        is_by_track: the UAV comes back the way it came, for the planner knows none. why: its sentence.
    """

    def __init__(
        self, planner: PathPlanner, energy: EnergyWatch | None, parameters: InspectionParameters
    ) -> None:
        super().__init__(planner, energy, parameters)
        self.is_by_track, self.why = False, ""

    def begin(self, home_m: np.ndarray) -> None:
        """Begin a flight. Only the first one's home counts."""
        super().begin(home_m)
        self.is_by_track = False

    def close_ahead(self, stamp_s: float, here_m: np.ndarray, next_m: np.ndarray) -> None:
        """Close the place ahead, where CEPA does not fly, unless it is home."""
        assert self.home_m is not None
        way = next_m - here_m
        ahead_m = here_m + way * (CLOSED_M / max(float(np.linalg.norm(way)), 1e-6))
        if math.dist(ahead_m, self.home_m) > 2.0 * CLOSED_M:
            self._planner.note_held_off(here_m, next_m, stamp_s, ahead_m)

    def next_way(self, stamp_s: float, here_m: np.ndarray, is_stuck: bool) -> list[np.ndarray] | None:
        """Return the places of a way home; None: the UAV keeps to the one it came.

        is_stuck: on the way that it has. If it came that way, its nearest places are left out.
        """
        assert self.home_m is not None
        try:
            points_m = self._planner.plan(here_m, self.home_m, stamp_s).points_m
        except NoPathError as error:
            if self.is_by_track and not is_stuck:
                return None
            self.is_by_track, self.why = True, str(error)
            if is_stuck:
                self._track_m = [each for each in self._track_m if math.dist(each, here_m) > STUCK_M]
            return [*self.track_back_m, self.home_m]
        self.is_by_track = False
        return list(points_m[1:])
