"""Plans the ways of an inspection: to photographs, and along given places."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from exploration.next_view.way import Way
from exploration.planning import PathPlanner
from flight_basics.errors import NoPathError
from inspection.flight.legs.leg import PhotographLeg
from inspection.flight.legs.passing import overshoot
from inspection.flight.parameters import InspectionParameters
from inspection.flight.photograph_queue import Task
from inspection.flight.places import body_place_m, place_nearby


class Legs:
    """Plans on the map of one planner. All places are (x, y, z) in the map's frame."""

    def __init__(self, planner: PathPlanner, parameters: InspectionParameters) -> None:
        self._planner, self._p = planner, parameters

    def to(
        self,
        task: Task,
        stamp_s: float,
        here_m: np.ndarray,
        tilt_rad: float,
        failures: int,
        may_pass: bool = True,
    ) -> tuple[PhotographLeg, Way]:
        """Return the leg to a photograph, and the way that is flown.

        If no way leads to its place, one to a place nearby counts. tilt_rad: of the gimbal now. failures: of
        this photograph so far. may_pass: it may be taken in passing, if others are.

        Raises:
            NoPathError: there is no way.
        """
        way_m = self._way_m(body_place_m(task.view, self._p.camera_m), stamp_s, here_m)
        length_m = float(np.linalg.norm(np.diff(way_m, axis=0), axis=1).sum())
        passes = self._p.passing_speed > 0.0 and task.number > 0 and failures == 0 and may_pass
        leg = PhotographLeg(
            task, way_m[-1], stamp_s, length_m, task.view.tilt_rad - tilt_rad, self._p, failures,
            self._overshoot(way_m, stamp_s) if passes else None,
        )  # fmt: skip
        return leg, self.along(list(way_m[1:]), stamp_s, here_m)

    def along(self, places_m: Sequence[np.ndarray], stamp_s: float, here_m: np.ndarray) -> Way:
        """Return a way along places, whose corners are cut where that is safe."""
        space = self._planner.space(stamp_s, here_m)
        return Way(places_m, space.cost_whatever_climb_m, self._p.ahead, self._p.climbs_first, here_m)

    def is_clear(self, here_m: np.ndarray, rest_m: Sequence[np.ndarray], stamp_s: float) -> bool:
        """Return whether straight legs from a place along others can be flown."""
        return self._planner.is_clear(np.array([here_m, *rest_m]), stamp_s)

    def _way_m(self, place_m: np.ndarray, stamp_s: float, here_m: np.ndarray) -> np.ndarray:
        try:
            return self._planner.plan(here_m, place_m, stamp_s).points_m
        except NoPathError as error:
            near_m = place_nearby(self._planner.space(stamp_s, here_m), place_m, self._p.nearby)
            if near_m is None:
                raise
            try:
                return self._planner.plan(here_m, near_m, stamp_s).points_m
            except NoPathError:
                raise error from None

    def _overshoot(self, way_m: np.ndarray, stamp_s: float) -> np.ndarray | None:
        """Return where the UAV aims if it flies past the way's end; None: there is no room."""
        overshoot_m = overshoot(way_m, self._p.passing_speed)
        if overshoot_m is None or not self.is_clear(way_m[-1], [overshoot_m], stamp_s):
            return None
        return overshoot_m
