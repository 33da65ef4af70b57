"""A narrow part of a way, as through a manhole: the UAV keeps to the middle of it."""

from __future__ import annotations

import math
from typing import Callable, Sequence

import numpy as np

from exploration.next_view.steps import in_steps

LEAD_M = 0.5
"""A UAV in the middle aims so far ahead of the place abeam on the way."""
ASIDE_M, CARRIED_S = 0.1, 0.4
"""The lead is the shorter the farther the UAV is beside the way, or is carried there in this time. At this
distance it aims at the place abeam, and so does not go on before it is back.
"""

SHIFT_M, SHIFT_STEP_M, ALONG_M = 0.3, 0.02, 0.05
"""A part is shifted to its middle by so much at most, in such steps. It counts in pieces of this length."""
RIM_M = 0.6
"""What is as wide as the widest place within `SHIFT_M` may reach so far: a way at one rim of a manhole of
0.8 m sees the other rim.
"""
ALIKE = 1e-6
"""Costs whose difference is less are the same."""

Cost = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""How long straight legs (...) between places (..., 3), x, y, z, seem, m; infinite: one may not be flown."""


def middle_of(places_m: Sequence[np.ndarray], cost_m: Cost) -> np.ndarray | None:
    """Return by how much (x, y, z) to shift a passage, m: then it lies amid all that is as wide.

    A map of voxels does not tell these apart, and the shortest way leads along their border. None: it is no
    passage, as a way along a wall: there is more room to one side. Or it may not be flown straight.
    """
    pieces_m = np.array(in_steps(places_m, ALONG_M))
    steps_m = np.arange(-RIM_M, RIM_M + 1e-9, SHIFT_STEP_M)
    shift_m = None
    if not np.isfinite(cost_m(pieces_m[:-1], pieces_m[1:])).all():
        return None
    for axis in _axes_across(pieces_m[-1] - pieces_m[0]):
        known_m = np.zeros(3) if shift_m is None else shift_m
        narrowness = _narrowness(pieces_m + known_m + steps_m[:, None, None] * axis, cost_m)
        middles_m = _middles_m(steps_m, narrowness)
        if middles_m:
            shift_m = known_m + min(middles_m, key=abs) * axis
    return shift_m


def _middles_m(steps_m: np.ndarray, narrowness: np.ndarray) -> list[float]:
    """Return the middles of all runs of steps (k,) that are as wide as the widest within `SHIFT_M`.

    A run that has more room beside it, or whose ends are not seen, has no middle.
    """
    least = narrowness[np.abs(steps_m) <= SHIFT_M + ALIKE].min()
    (wide,) = np.nonzero(narrowness <= least + ALIKE)
    runs = np.split(wide, np.flatnonzero(np.diff(wide) > 1) + 1)
    ended = [run for run in runs if run[0] > 0 and run[-1] < len(steps_m) - 1]
    alike = [run for run in ended if narrowness[run].min() >= least - ALIKE]
    middles_m = [0.5 * float(steps_m[run[0]] + steps_m[run[-1]]) for run in alike]
    return [middle_m for middle_m in middles_m if abs(middle_m) <= SHIFT_M + ALIKE]


def _axes_across(along_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors across a direction: a level one, and the one across both."""
    along = along_m / max(float(np.linalg.norm(along_m)), 1e-9)
    level = np.cross(along, (0.0, 0.0, 1.0))
    length = float(np.linalg.norm(level))
    first = level / length if length > 0.1 else np.array((1.0, 0.0, 0.0))
    second = np.cross(first, along)
    return first, second / max(float(np.linalg.norm(second)), 1e-9)


def _narrowness(parts_m: np.ndarray, cost_m: Cost) -> np.ndarray:
    """Return the cost of a metre (k,) at the narrowest place of each of parts (k, n, 3) beside each other."""
    begins_m, ends_m = parts_m[:, :-1], parts_m[:, 1:]
    lengths_m = np.maximum(np.linalg.norm(ends_m - begins_m, axis=2), 1e-9)
    narrowness: np.ndarray = (cost_m(begins_m, ends_m) / lengths_m).max(axis=1)
    return narrowness


class Drift:
    """How fast a UAV moves, by its last two poses."""

    def __init__(self) -> None:
        self._stamp_s, self._here_m = math.nan, np.zeros(3)
        self.velocity_m_s = np.zeros(3)

    def note(self, stamp_s: float, here_m: np.ndarray) -> None:
        """Take a pose (x, y, z)."""
        if stamp_s > self._stamp_s:
            self.velocity_m_s = (here_m - self._here_m) / (stamp_s - self._stamp_s)
        self._stamp_s, self._here_m = stamp_s, here_m


class NarrowPart:
    """Leads a UAV along the middle, if it is a passage.

    Args:
        entry, exit_: numbers of the way's aims before and behind it. entry -1: the way begins in it.
        places_m: (x, y, z) each, from the entry to the exit; two at least.
        is_passage: there is no more room to any side.
    """

    def __init__(
        self, entry: int, exit_: int, places_m: Sequence[np.ndarray], is_passage: bool = True
    ) -> None:
        self.entry, self.exit, self.is_passage = entry, exit_, is_passage
        self._places_m = np.array(places_m, float)
        self._along_m = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(self._places_m, axis=0), axis=1)))

    def holds(self, aim: int) -> bool:
        """Whether a UAV that flies to this aim has entered it, and not left it."""
        return self.entry < aim <= self.exit

    def aim_m(self, here_m: np.ndarray, velocity_m_s: np.ndarray) -> np.ndarray:
        """Return where a UAV aims, which is at (x, y, z) and moves so."""
        abeam_m, aside_m = self._abeam(here_m)
        _, carried_m = self._abeam(here_m + CARRIED_S * velocity_m_s)
        lead_m = LEAD_M * max(0.0, 1.0 - max(aside_m, carried_m) / ASIDE_M)
        return np.array([np.interp(abeam_m + lead_m, self._along_m, axis) for axis in self._places_m.T])

    def _abeam(self, here_m: np.ndarray) -> tuple[float, float]:
        """Return how far along the part the nearest place is, and how far off, m. Its ends go on straight."""
        begins, legs = self._places_m[:-1], np.diff(self._places_m, axis=0)
        lengths_m = np.maximum(np.linalg.norm(legs, axis=1), 1e-9)
        ahead_m = np.einsum("ij,ij->i", here_m - begins, legs) / lengths_m
        least = np.append(-math.inf, np.zeros(len(legs) - 1))
        most = np.append(lengths_m[:-1], math.inf)
        ahead_m = np.clip(ahead_m, least, most)
        off_m = np.linalg.norm(here_m - begins - legs * (ahead_m / lengths_m)[:, None], axis=1)
        nearest = int(off_m.argmin())
        return float(self._along_m[nearest] + ahead_m[nearest]), float(off_m[nearest])
