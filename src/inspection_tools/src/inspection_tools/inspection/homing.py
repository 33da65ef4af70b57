"""The way home, planned again and again, and whether the energy still takes the UAV there."""

from __future__ import annotations

import math

import numpy as np

from inspection_tools.energy import Decision, EnergyWatch, WayHome
from inspection_tools.errors import NoPathError
from inspection_tools.inspection.parameters import InspectionParameters
from inspection_tools.planning import PathPlanner


class Homing:
    """Knows the way home of one UAV.

    Attributes:
        home_m: (x, y, z) in the map's frame; None: not known yet.
        way_m: (n, 3) from where the UAV was; None: none was planned.
    """

    def __init__(
        self, planner: PathPlanner, energy: EnergyWatch | None, parameters: InspectionParameters
    ) -> None:
        self._planner, self._energy, self._p = planner, energy, parameters
        self.home_m: np.ndarray | None = None
        self.way_m: np.ndarray | None = None
        self._track_m: list[np.ndarray] = []
        self._planned_s = -math.inf

    def begin(self, home_m: np.ndarray) -> None:
        """Begin a flight. Only the first one's home counts."""
        self.home_m = home_m if self.home_m is None else self.home_m
        if self._energy is not None:
            self._energy.take_off()

    def note(self, here_m: np.ndarray) -> None:
        """Remember where the UAV (x, y, z) was: the way it came is free."""
        if not self._track_m or math.dist(here_m, self._track_m[-1]) > self._p.track_spacing:
            self._track_m.append(here_m)

    @property
    def back_m(self) -> list[np.ndarray]:
        """The way that the UAV came, back."""
        return self._track_m[::-1]

    @property
    def way(self) -> WayHome | None:
        """Length and time of the way home, as it was planned last; None: none was."""
        if self.way_m is None:
            return None
        length_m = float(np.linalg.norm(np.diff(self.way_m, axis=0), axis=1).sum())
        return WayHome(length_m / self._p.home_speed, length_m)

    def decide(self, stamp_s: float, here_m: np.ndarray) -> Decision | None:
        """Plan the way home if the last plan is old. Return what the energy allows.

        None: it does not count.
        """
        if self._energy is None or self.home_m is None:
            return None
        if stamp_s >= self._planned_s + self._p.home_period:
            self._planned_s = stamp_s
            try:
                self.way_m = self._planner.plan(here_m, self.home_m, stamp_s).points_m
            except NoPathError:
                self.way_m = np.array([here_m, *self.back_m, self.home_m])
        return self._energy.decide(stamp_s, self.way)
