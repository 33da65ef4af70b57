"""The way home, planned again and again, and whether the energy still takes the UAV there."""

from __future__ import annotations

import math
from typing import Protocol, Sequence

import numpy as np

from exploration.energy.decision import Decision, EnergyWatch, Verdict, WayHome
from exploration.energy.pace import Course, Pace, metres_by_course
from exploration.planning import PathPlanner
from exploration.planning.progress import rest_of
from flight_basics.errors import NoPathError

OVER_M, OVER_S = 0.15, 1.0
"""A UAV that stays this near to its home for so long is over it: it lands where it took off, and not on what
is beside. One that arrives and lands at once is carried on by 0.3 m."""
HELD_OFF_S = 6.0
"""A UAV that is near its home for so long gets no nearer: CEPA keeps it off something."""


class WayBackParameters(Protocol):
    """What an exploration and an inspection are both led by."""

    @property
    def arrived(self) -> float:
        """A place is reached within this distance, m."""

    @property
    def track_spacing(self) -> float:
        """Between the places that the UAV remembers, m."""

    @property
    def home_speed(self) -> float:
        """Mean speed on the way home, turns included, m/s."""

    @property
    def home_period(self) -> float:
        """The way home is planned anew so often, s."""


class WayBack:
    """Knows the way home of one UAV: by the map, and else the way it came.

    Attributes:
        home_m: (x, y, z) in the map's frame; None: not known yet.
        way_m: (n, 3) from where the UAV was; None: none was planned.
    """

    def __init__(
        self, planner: PathPlanner, energy: EnergyWatch | None, parameters: WayBackParameters
    ) -> None:
        self._planner, self._energy, self._p = planner, energy, parameters
        self.home_m: np.ndarray | None = None
        self.way_m: np.ndarray | None = None
        self._track_m: list[np.ndarray] = []
        self._planned_s, self._is_track = -math.inf, False
        self._near_s: float | None = None
        """Since when the UAV is near its home; None: it is not."""
        self._over_s: float | None = None
        """Since when it is over its home; None: it is not."""
        self._is_low = False
        self._pace = Pace(parameters.home_speed)

    def begin(self, home_m: np.ndarray) -> None:
        """Begin a flight. Only the first one's home counts."""
        self.home_m = home_m if self.home_m is None else self.home_m
        self._near_s = self._over_s = None
        self._is_low = False
        if self._energy is not None:
            self._energy.take_off()

    def near_home_s(self, stamp_s: float, here_m: np.ndarray) -> float:
        """Return for how long the UAV has been near its home, s."""
        self._near_s = self._since(self._near_s, stamp_s, here_m, 2.0 * self._p.arrived)
        return 0.0 if self._near_s is None else stamp_s - self._near_s

    def may_land(self, stamp_s: float, here_m: np.ndarray) -> bool:
        """Return whether the UAV, which comes home, is over its home, or near it and gets no nearer."""
        near_s = self.near_home_s(stamp_s, here_m)
        self._over_s = self._since(self._over_s, stamp_s, here_m, OVER_M)
        is_over = self._over_s is not None and stamp_s - self._over_s >= OVER_S
        return is_over or near_s >= HELD_OFF_S

    def _since(
        self, since_s: float | None, stamp_s: float, here_m: np.ndarray, within_m: float
    ) -> float | None:
        """Return since when the UAV is within a distance of its home; None: it is not."""
        if self.home_m is None or math.dist(here_m, self.home_m) >= within_m:
            return None
        return stamp_s if since_s is None else since_s

    def note(self, here_m: np.ndarray) -> None:
        """Remember where the UAV (x, y, z) was: the way it came is free."""
        if not self._track_m or math.dist(here_m, self._track_m[-1]) > self._p.track_spacing:
            self._track_m.append(here_m)

    @property
    def track_back_m(self) -> list[np.ndarray]:
        """The places of the way it came, back to its beginning, without loops."""
        return without_loops(self._track_m[::-1], self._planner.parameters.radius)

    @property
    def way(self) -> WayHome | None:
        """Length of the way home, as it was planned last, and its time by this flight's pace; None: none."""
        if self.way_m is None:
            return None
        metres = metres_by_course(self.way_m)
        return WayHome(
            self._pace.time_s(self.way_m), sum(metres.values()), metres[Course.UP], metres[Course.DOWN]
        )

    @property
    def way_charge(self) -> float:
        """Charge that the way home takes at the mean rate, without a margin, 0..1; NaN: not known."""
        way = self.way
        return math.nan if self._energy is None or way is None else self._energy.rate_per_s * way.time_s

    def note_pace(self, stamp_s: float, here_m: np.ndarray, rest_m: Sequence[np.ndarray]) -> None:
        """Learn from the way that the UAV (x, y, z) flies now. rest_m: its places to come; none: no way."""
        self._pace.note(stamp_s, here_m, rest_m)

    def decide(self, stamp_s: float, here_m: np.ndarray) -> Decision | None:
        """Plan the way home if the last plan is old or the map has closed it. Return what the energy allows.

        None: it does not count.
        """
        if self._energy is None or self.home_m is None:
            return None
        if stamp_s >= self._planned_s + self._p.home_period or not self._is_open(stamp_s, here_m):
            self._planned_s = stamp_s
            try:
                self.way_m, self._is_track = self._planner.plan(here_m, self.home_m, stamp_s).points_m, False
            except NoPathError:
                self._is_track = True
                self.way_m = np.array([here_m, *self.track_back_m, self.home_m])
        return self._energy.decide(stamp_s, self.way)

    def _is_open(self, stamp_s: float, here_m: np.ndarray) -> bool:
        """Return whether the way home that was planned last still leads there by the map as it is now."""
        if self.way_m is None or self._is_track or not self._planner.has_map:
            return True
        rest_m, _ = rest_of(self.way_m, here_m)
        return self._planner.is_clear(self.way_m[-len(rest_m) :], stamp_s)

    def turns_low(self, decision: Decision) -> bool:
        """Return whether the energy says so for the first time in this flight: then a pause ends."""
        was_low = self._is_low
        self._is_low = was_low or decision.verdict is not Verdict.GO_ON
        return self._is_low and not was_low


def without_loops(places_m: Sequence[np.ndarray], reach_m: float) -> list[np.ndarray]:
    """Return a way (x, y, z each) that goes on at once from where it comes back to the same place later.

    reach_m: places that are not farther apart are the same. Choose the radius that was free around each, so
    that the short cut between them was free, too.
    """
    if not places_m:
        return []
    all_m, kept = np.array(places_m), [0]
    while kept[-1] < len(all_m) - 1:
        at = kept[-1]
        apart_m = np.linalg.norm(all_m[at + 1 :] - all_m[at], axis=1)
        again = np.flatnonzero(apart_m <= reach_m)
        kept.append(at + 1 + (int(again[-1]) if again.size else 0))
    return [places_m[index] for index in kept]
