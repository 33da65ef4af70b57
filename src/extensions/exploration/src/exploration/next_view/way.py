"""The places that a UAV flies to one after the other."""

from __future__ import annotations

import math
from itertools import groupby
from typing import Sequence

import numpy as np

from exploration.next_view.narrow_part import Cost, Drift, NarrowPart, middle_of
from exploration.next_view.steps import in_steps

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
PAST_AIMS = 2
"""So many aims above or below a rim it leaves it: its body has a height."""
ENTRY_M, EXIT_M = 0.1, 0.3
"""It has entered and left it when it is so near to these aims: it enters slowly."""


class Progress:
    """Whether a UAV comes nearer to its goal, whichever way it takes."""

    def __init__(self) -> None:
        self._goal_m: np.ndarray | None = None
        self._least_m, self._nearer_s, self._way_m = math.inf, math.nan, math.inf
        self._began_m = np.zeros(3)

    def note(self, stamp_s: float, here_m: np.ndarray, rest_m: Sequence[np.ndarray]) -> None:
        """Take a pose (x, y, z), and the places that are still to come."""
        if not rest_m:
            self._goal_m = None
            return
        way_m = sum(math.dist(a, b) for a, b in zip((here_m, *rest_m), rest_m))
        is_new = self._goal_m is None or math.dist(self._goal_m, rest_m[-1]) > SAME_M
        # All at once it is longer: another way. A UAV that stays between two of them makes no progress.
        is_other = way_m > self._way_m + STAYS_M and math.dist(here_m, self._began_m) > STAYS_M
        if is_new or is_other:
            self._began_m = here_m
        if is_new or is_other or way_m < self._least_m - NEARER_M:
            self._goal_m, self._least_m, self._nearer_s = rest_m[-1], way_m, stamp_s
        self._way_m = way_m

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
        cost_m: how long straight legs seem, m, one or many; infinite: one may not be flown.
        ahead_m: it aims at places that are not farther than this. 0: at each of the places in turn.
        climbs_first: it climbs or sinks on the spot to the height of the aim while the level way there is not
            clear. A CEPA that sees one height only would keep it away from a manhole below or above.
        begin_m: where the UAV is, (x, y, z). If the way to the first place is narrow, it is divided, too.
    """

    def __init__(
        self,
        places_m: Sequence[np.ndarray] = (),
        cost_m: Cost | None = None,
        ahead_m: float = 0.0,
        climbs_first: bool = False,
        begin_m: np.ndarray | None = None,
    ) -> None:
        self._cost_m, self._ahead_m, self._climbs_first = cost_m, ahead_m, climbs_first
        first_m = [] if begin_m is None or not len(places_m) else self._narrow_first(begin_m, places_m[0])
        aims_m, corners = _divided(places_m, AIM_M if ahead_m > 0.0 else math.inf)
        self._aims_m = (*first_m, *aims_m)
        self._corners = [corner + len(first_m) for corner in corners]
        self._narrow = self._narrow_parts(begin_m)
        """The UAV does not aim past entry and exit of one before it is there: a fast one that turns in
        between would be carried towards the rim.
        """
        self._aim, self._has_arrived, self._drift = 0, not self._aims_m, Drift()
        self._instead_m: np.ndarray | None = None
        """Where it flies in place of its aim: along a narrow part, or straight up or down first."""

    def follow(self, stamp_s: float, here_m: np.ndarray, arrived_m: float) -> None:
        """Aim farther ahead if the UAV (x, y, z) can, or is nearer than this to the present aim."""
        self._drift.note(stamp_s, here_m)
        if not self._has_arrived:
            self._choose_aim(here_m, arrived_m)
        self._instead_m = self._in_place_of_aim(here_m) if self.is_left else None

    def _in_place_of_aim(self, here_m: np.ndarray) -> np.ndarray | None:
        for part in self._narrow:
            if part.is_passage and part.holds(self._aim):
                aim_m = part.aim_m(here_m, self._drift.velocity_m_s)
                if self._cost_m is not None and math.isfinite(self._cost_m(here_m, aim_m)):
                    return aim_m
        return self._climb_first(here_m) if self._climbs_first else None

    def _choose_aim(self, here_m: np.ndarray, arrived_m: float) -> None:
        farthest = self._aim
        gates = {aim for part in self._narrow for aim in (part.entry, part.exit)}
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
        return bool(cut_m <= CUT_COST * _costs_along(way_m, self._cost_m).sum())

    def _narrow_first(self, begin_m: np.ndarray, end_m: np.ndarray) -> list[np.ndarray]:
        """Return the places between, if a part of the leg is narrow."""
        places_m = in_steps((begin_m, end_m), AIM_M)
        is_narrow = any(map(self._is_narrow, places_m, places_m[1:]))
        return places_m[1:-1] if is_narrow and self._ahead_m > 0.0 else []

    def _reach_m(self, arrived_m: float) -> float:
        """Return within which distance of its aim the UAV has arrived."""
        if any(self._aim == part.entry for part in self._narrow):
            return min(arrived_m, ENTRY_M)
        is_exit = any(self._aim == part.exit for part in self._narrow) and self._aim + 1 < len(self._aims_m)
        return max(arrived_m, EXIT_M) if is_exit else arrived_m

    def _narrow_parts(self, begin_m: np.ndarray | None) -> list[NarrowPart]:
        """Find those of the way, and lead it through their middle. Each begins shortly before what is narrow.

        Through a hole in a deck it leads straight up or down, from before the rim until the body is past it.
        """
        if self._ahead_m <= 0.0 or not self._aims_m or self._cost_m is None:
            return []
        known_m = [] if begin_m is None else [begin_m]
        track_m, before = [*known_m, *self._aims_m], len(known_m)
        legs = list(map(self._is_narrow, track_m, track_m[1:]))
        found: list[tuple[int, int, int, bool]] = []
        for is_narrow, run in groupby(range(len(legs)), legs.__getitem__):
            if not is_narrow:
                continue
            numbers = list(run)
            begin = max(numbers[0] - GATE_AIMS, before) if numbers[0] else 0
            entry, end = begin - before if numbers[0] else -1, min(numbers[-1] + 1 + GATE_AIMS, len(legs))
            shift_m = middle_of(track_m[numbers[0] : numbers[-1] + 2], self._cost_m)
            if shift_m is not None:
                self._move(track_m, begin, end, [place_m + shift_m for place_m in track_m[begin : end + 1]])
            steep = [n for n in numbers if _is_steep(track_m[n], track_m[n + 1])]
            if shift_m is not None and steep:
                end = min(steep[-1] + 1 + PAST_AIMS, len(legs))
                self._straighten(track_m, steep[0], steep[-1] + 1, end)
            is_passage = shift_m is not None
            if found and begin <= found[-1][2]:  # what overlaps is one: else the UAV waits between both
                entry, begin, _, was_passage = found.pop()
                is_passage = is_passage or was_passage
            found.append((entry, begin, end, is_passage))
        self._aims_m = tuple(track_m[before:])
        return [
            NarrowPart(entry, end - before, track_m[begin : end + 1], is_passage)
            for entry, begin, end, is_passage in found
        ]

    def _straighten(self, track_m: list[np.ndarray], begin: int, last: int, end: int) -> None:
        """Lead the way straight up or down from a place to `end`, in the middle of those up to `last`."""
        level_m = np.mean([place_m[:2] for place_m in track_m[begin : last + 1]], axis=0)
        straight_m = [np.array((*level_m, place_m[2])) for place_m in track_m[begin : end + 1]]
        self._move(track_m, begin, end, straight_m)

    def _move(self, track_m: list[np.ndarray], begin: int, end: int, moved_m: Sequence[np.ndarray]) -> None:
        """Move the places from `begin` to `end`, but not the way's end, if it is clear then."""
        assert self._cost_m is not None
        end = min(end + 1, len(track_m) - 1)
        moved_m = list(moved_m[: end - begin])
        around_m = [*track_m[max(begin - 1, 0) : begin], *moved_m, *track_m[end : end + 1]]
        if np.isfinite(_costs_along(around_m, self._cost_m)).all():
            track_m[begin:end] = moved_m

    def _is_narrow(self, a_m: np.ndarray, b_m: np.ndarray) -> bool:
        return self._cost_m is not None and bool(self._cost_m(a_m, b_m) > NARROW_COST * math.dist(a_m, b_m))

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
        if self._instead_m is not None:
            return self._instead_m
        return self._aims_m[self._aim] if self._aims_m else None


def _is_steep(begin_m: np.ndarray, end_m: np.ndarray) -> bool:
    return bool(abs(end_m[2] - begin_m[2]) > math.dist(begin_m[:2], end_m[:2]))


def _costs_along(places_m: Sequence[np.ndarray], cost_m: Cost) -> np.ndarray:
    """Return the cost of each leg (n - 1,) between places (n, 3)."""
    track_m = np.reshape(places_m, (-1, 3))
    return cost_m(track_m[:-1], track_m[1:])


def _divided(places_m: Sequence[np.ndarray], step_m: float) -> tuple[tuple[np.ndarray, ...], list[int]]:
    """Return places and those between them, no farther apart than a step, and which are the given ones."""
    aims_m, corners = list(places_m[:1]), [0]
    for leg_m in zip(places_m, places_m[1:]):
        aims_m += in_steps(leg_m, step_m)[1:]
        corners.append(len(aims_m) - 1)
    return tuple(aims_m), corners
