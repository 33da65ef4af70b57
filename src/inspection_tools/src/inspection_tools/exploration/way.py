"""The places that a UAV flies to one after the other."""

from __future__ import annotations

import math
from typing import Callable, Sequence

import numpy as np

NEARER_M = 0.1
"""A UAV whose way gets so much shorter makes progress."""
STAYS_M = 1.0
"""A UAV stays where it is while it is no farther from there."""
SAME_M = 0.3
"""Ways whose ends are nearer than this have the same goal."""

AIM_M = 0.25
"""Between the places on a way that a UAV may aim at: short beside the way on which it turns."""
LEVEL_M = 0.1
"""A UAV that is so near to the height of its aim flies on."""
CUT_COST = 1.1
"""A UAV cuts a corner that costs at most so much of the way round it: not near the rim of a manhole."""
NARROW_COST = 2.0
"""A leg that costs so many times its length is narrow, as one through a manhole is."""
GATE_AIMS = 1
"""So many aims before a narrow part the UAV enters it, and so many behind it leaves it."""
ENTRY_M, EXIT_M = 0.1, 0.3
"""It has entered and left it when it is so near to these aims: it enters slowly."""


class Progress:
    """Whether a UAV comes nearer to its goal, whichever way it takes."""

    def __init__(self) -> None:
        self._goal_m: np.ndarray | None = None
        self._least_m, self._nearer_s = math.inf, math.nan

    def note(self, stamp_s: float, here_m: np.ndarray, rest_m: Sequence[np.ndarray]) -> None:
        """Take a pose (x, y, z), and the places that are still to come."""
        if not rest_m:
            self._goal_m = None
            return
        way_m = sum(math.dist(a, b) for a, b in zip((here_m, *rest_m), rest_m))
        is_new = self._goal_m is None or math.dist(self._goal_m, rest_m[-1]) > SAME_M
        if is_new or way_m < self._least_m - NEARER_M:
            self._goal_m, self._least_m, self._nearer_s = rest_m[-1], way_m, stamp_s

    def is_held_off(self, stamp_s: float, time_s: float) -> bool:
        """Whether it has come no nearer for so long."""
        return self._goal_m is not None and stamp_s - self._nearer_s > time_s


class Stay:
    """For how long a UAV has stayed where it is."""

    def __init__(self) -> None:
        self._place_m: np.ndarray | None = None
        self._since_s = math.inf

    def note(self, stamp_s: float, here_m: np.ndarray) -> None:
        """Take a pose (x, y, z)."""
        if self._place_m is None or math.dist(here_m, self._place_m) > STAYS_M:
            self._place_m, self._since_s = here_m, stamp_s

    def lasts(self, stamp_s: float, time_s: float) -> bool:
        """Whether it has stayed for so long."""
        return stamp_s - self._since_s > time_s


class Way:
    """A way that one thread follows. Another one may replace it at any time, but does not change it.

    The UAV aims at a place on the way, as far ahead as a straight line there costs hardly more than the way.
    So it slows down only at corners that it cannot cut, before narrow places, and at the end.

    Args:
        places_m: (x, y, z) each, without the place where the UAV is.
        cost_m: how long a straight leg from one place to another seems, m; infinite: it may not be flown.
        ahead_m: it aims at places that are not farther than this. 0: at each of the places in turn.
        climbs_first: it climbs or sinks on the spot to the height of the aim while the level way there is not
            clear. A CEPA that sees one height only would keep it away from a manhole below or above.
        begin_m: where the UAV is, (x, y, z). If the way to the first place is narrow, it is divided, too.
    """

    def __init__(
        self,
        places_m: Sequence[np.ndarray] = (),
        cost_m: Callable[[np.ndarray, np.ndarray], float] | None = None,
        ahead_m: float = 0.0,
        climbs_first: bool = False,
        begin_m: np.ndarray | None = None,
    ) -> None:
        self._cost_m, self._ahead_m, self._climbs_first = cost_m, ahead_m, climbs_first
        first_m = [] if begin_m is None or not len(places_m) else self._narrow_first(begin_m, places_m[0])
        aims_m, corners = _divided(places_m, AIM_M if ahead_m > 0.0 else math.inf)
        self._aims_m = (*first_m, *aims_m)
        self._corners = [corner + len(first_m) for corner in corners]
        self._entries, self._exits = self._narrow_ends()
        """Aims shortly before and behind a narrow part of the way. The UAV does not aim past one before it is
        there: a fast one that turns in between would be carried towards the rim.
        """
        self._aim, self._has_arrived = 0, not self._aims_m
        self._beside_m: np.ndarray | None = None
        """The place over or under the UAV at the height of its aim, while it climbs or sinks first."""

    def follow(self, here_m: np.ndarray, arrived_m: float) -> None:
        """Aim farther ahead if the UAV (x, y, z) can, or is nearer than this to the present aim."""
        if not self._has_arrived:
            self._choose_aim(here_m, arrived_m)
        self._beside_m = self._climb_first(here_m) if self._climbs_first and self.is_left else None

    def _choose_aim(self, here_m: np.ndarray, arrived_m: float) -> None:
        farthest = self._aim
        gates = self._entries | self._exits
        while farthest not in gates and self._is_within(farthest + 1, here_m, self._ahead_m):
            farthest += 1
        for aim in range(farthest, self._aim, -1):
            if self._may_cut_to(aim, here_m):
                self._aim = aim
                return
        if self._is_within(self._aim, here_m, self._reach_m(arrived_m)):
            self._has_arrived = self._aim + 1 == len(self._aims_m)
            self._aim += not self._has_arrived

    def _may_cut_to(self, aim: int, here_m: np.ndarray) -> bool:
        """Whether to fly straight there costs hardly more than to follow the way."""
        if self._cost_m is None:
            return False
        cut_m = self._cost_m(here_m, self._aims_m[aim])
        if not math.isfinite(cut_m):
            return False
        way_m = [here_m, *self._aims_m[self._aim : aim + 1]]
        return cut_m <= CUT_COST * sum(map(self._cost_m, way_m, way_m[1:]))

    def _narrow_first(self, begin_m: np.ndarray, end_m: np.ndarray) -> list[np.ndarray]:
        """Return the places between, if a part of the leg is narrow."""
        places_m = in_steps((begin_m, end_m), AIM_M)
        is_narrow = any(map(self._is_narrow, places_m, places_m[1:]))
        return places_m[1:-1] if is_narrow and self._ahead_m > 0.0 else []

    def _reach_m(self, arrived_m: float) -> float:
        """Return within which distance of its aim the UAV has arrived."""
        if self._aim in self._entries:
            return min(arrived_m, ENTRY_M)
        return max(arrived_m, EXIT_M) if self._aim in self._exits else arrived_m

    def _narrow_ends(self) -> tuple[set[int], set[int]]:
        """Return the aims shortly before and behind narrow parts, but for the way's own ends."""
        narrow = list(map(self._is_narrow, self._aims_m, self._aims_m[1:])) if self._ahead_m > 0.0 else []
        begins = [k for k, (before, now) in enumerate(zip([True, *narrow], narrow)) if now and not before]
        ends = [k for k, (now, after) in enumerate(zip(narrow, narrow[1:])) if now and not after]
        exits = {k + 1 + GATE_AIMS for k in ends}
        return {max(k - GATE_AIMS, 0) for k in begins}, {k for k in exits if k < len(self._aims_m) - 1}

    def _is_narrow(self, a_m: np.ndarray, b_m: np.ndarray) -> bool:
        return self._cost_m is not None and self._cost_m(a_m, b_m) > NARROW_COST * math.dist(a_m, b_m)

    def _climb_first(self, here_m: np.ndarray) -> np.ndarray | None:
        """Return the place to climb or sink to before the UAV flies on; None: it flies straight on."""
        aim_m = self._aims_m[self._aim]
        level_m, beside_m = np.array((*aim_m[:2], here_m[2])), np.array((*here_m[:2], aim_m[2]))
        if self._cost_m is None or abs(aim_m[2] - here_m[2]) < LEVEL_M:
            return None
        if math.isfinite(self._cost_m(here_m, level_m)):
            return None
        return beside_m if math.isfinite(self._cost_m(here_m, beside_m)) else None

    def _is_within(self, aim: int, here_m: np.ndarray, reach_m: float) -> bool:
        return aim < len(self._aims_m) and math.dist(here_m, self._aims_m[aim]) < reach_m

    @property
    def is_left(self) -> bool:
        """Whether the UAV has not arrived at the end."""
        return not self._has_arrived

    @property
    def is_on_last_leg(self) -> bool:
        """Whether no corner is left before the end."""
        return sum(corner >= self._aim for corner in self._corners) <= 1

    @property
    def rest_m(self) -> list[np.ndarray]:
        """The places to come, from the one to fly to now."""
        aim, corners = self._aim, self._corners
        if self._has_arrived:
            return []
        return [self._aims_m[aim], *(self._aims_m[corner] for corner in corners if corner > aim)]

    @property
    def setpoint_m(self) -> np.ndarray | None:
        """The place to fly to now, in the end the last one; None: the way has none."""
        if self._beside_m is not None:
            return self._beside_m
        return self._aims_m[self._aim] if self._aims_m else None


def in_steps(places_m: Sequence[np.ndarray], step_m: float) -> list[np.ndarray]:
    """Return the places (x, y, z) of a way with others between, so that no step is longer than this."""
    stepped = [np.asarray(place_m, float) for place_m in places_m[:1]]
    for begin_m, end_m in zip(places_m, places_m[1:]):
        count = max(1, math.ceil(math.dist(begin_m, end_m) / step_m))
        stepped += [begin_m + share * (end_m - begin_m) for share in np.linspace(0.0, 1.0, count + 1)[1:]]
    return stepped


def _divided(places_m: Sequence[np.ndarray], step_m: float) -> tuple[tuple[np.ndarray, ...], list[int]]:
    """Return places and those between them, no farther apart than a step, and which are the given ones."""
    aims_m, corners = list(places_m[:1]), [0]
    for leg_m in zip(places_m, places_m[1:]):
        aims_m += in_steps(leg_m, step_m)[1:]
        corners.append(len(aims_m) - 1)
    return tuple(aims_m), corners
