"""A small set of photographs that shows a share of the surface: lazy greedy, then local search."""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import Callable

import numpy as np

from inspection.survey.kernels.gains import sums_alone
from inspection.survey.parameters import SurveyParameters
from inspection.survey.views.candidates import Candidates, View

LEAST_M2 = TINY_M2 = 1e-9
ROUNDING = 1e-9
"""Shares are sums that photographs change one by one; a whole one may come out so much short of 1."""
ANEW = 2
"""So many photographs at most are taken away together and chosen anew. In hold_3d this led to 11 % fewer
photographs in 30 s of search than 8 did."""
REACH_M = 1.0
"""The new ones are sought so much farther from the first than the old ones are."""
TRIED = 0.5
"""From so many of the places there, drawn anew each time."""
IN_VAIN = 30
"""After so many choices in vain for each photograph the search ends. A room of 6 m has 17 photographs then,
and has 17 after eight times as long."""


@dataclass(frozen=True, eq=False)
class Shot:
    """A photograph from a place of the candidates, and the patches that it draws. Each is itself alone."""

    place: int
    yaw: float
    tilt: float
    drawn: np.ndarray


class Cover:
    """Photographs, and how many of them show each patch.

    Args:
        candidates: places of photographs. parameters: see there. shown_m2: (names,) of each thing, beside the
            candidates' patches, what is shown already; None: nothing.
    """

    def __init__(
        self, candidates: Candidates, parameters: SurveyParameters, shown_m2: np.ndarray | None = None
    ):
        self._c = candidates
        self.shots: list[Shot] = []
        self.areas_m2 = np.where(candidates.reachable, candidates.patches.areas_m2, 0.0)
        self.counts = np.zeros(len(self.areas_m2), np.int64)
        self._open_m2 = self.areas_m2.copy()
        self._bounds = candidates.likely_gains(np.arange(len(candidates.places_m)), self.areas_m2)
        names = candidates.patches.names
        self._now_m2 = np.zeros(len(names)) if shown_m2 is None else np.array(shown_m2, float)
        self.by_class_m2 = self._now_m2 + self._sums_m2(np.arange(len(self.areas_m2)))
        self._whole_m2 = float(self.by_class_m2.sum())
        self._asked_m2 = (parameters.share - ROUNDING) * self._whole_m2
        asked_m2 = (parameters.class_share - ROUNDING) * self.by_class_m2
        self._asked_by_class_m2 = np.where(self.by_class_m2 > TINY_M2, asked_m2, -np.inf)

    @property
    def share(self) -> float:
        """Of the reachable area that is shown, 0..1."""
        return float(self._now_m2.sum() / max(self._whole_m2, 1e-12))

    @property
    def cost(self) -> float:
        """Of all photographs: their number, where the UAV has room."""
        return float(self._c.costs[[each.place for each in self.shots]].sum())

    @property
    def views(self) -> list[View]:
        """The photographs."""
        places_m = self._c.places_m
        return [View(tuple(places_m[s.place].tolist()), float(s.yaw), float(s.tilt)) for s in self.shots]

    def class_shares(self) -> np.ndarray:
        """(names,) the same for each thing; 1 where nothing of it is reachable."""
        whole_m2 = np.maximum(self.by_class_m2, TINY_M2)
        return np.where(self.by_class_m2 > TINY_M2, self._now_m2 / whole_m2, 1.0)

    def is_enough(self) -> bool:
        """Whether the shares are those that are asked for."""
        return bool(self._are_enough(self._now_m2))

    def _are_enough(self, shown_m2: np.ndarray) -> np.ndarray:
        """Return whether the shares are enough if so much (..., names) of each thing is shown."""
        return (shown_m2.sum(axis=-1) >= self._asked_m2) & (shown_m2 >= self._asked_by_class_m2).all(axis=-1)

    def _lacks_all(self) -> bool:
        return bool(self._now_m2.sum() < self._asked_m2)

    def _lack(self) -> np.ndarray:
        """Return which things (names,) are shown to less than is asked of each."""
        return self._now_m2 < self._asked_by_class_m2

    def add(self, shot: Shot) -> None:
        """Take a photograph in."""
        self.shots.append(shot)
        fresh = shot.drawn[self.counts[shot.drawn] == 0]
        self.counts[shot.drawn] += 1
        self._open_m2[fresh] = 0.0
        self._now_m2 += self._sums_m2(fresh)

    def remove(self, shot: Shot) -> None:
        """Take a photograph out."""
        self.shots.remove(shot)
        self.counts[shot.drawn] -= 1
        lost = shot.drawn[self.counts[shot.drawn] == 0]
        self._open_m2[lost] = self.areas_m2[lost]
        self._now_m2 -= self._sums_m2(lost)

    def _sums_m2(self, patches: np.ndarray) -> np.ndarray:
        """Return (names,) the reachable area of the patches (n,), by thing."""
        p = self._c.patches
        return np.bincount(p.parts[patches], self.areas_m2[patches], len(p.names))

    def fill(
        self, places: np.ndarray | None = None, most: int | None = None, least_m2: float = LEAST_M2
    ) -> bool:
        """Add the photograph that shows most of what is open for its cost, until it is enough (lazy greedy).

        places: candidates; None: all. most: so many at most. least_m2: that one must show. Returns whether it
        is enough.
        """
        costs = self._c.costs
        if places is None:
            numbers, bounds = np.arange(len(self._c.places_m)), self._bounds
        else:
            numbers, bounds = places, self._c.likely_gains(places, self._worth())
        heap = [(-gain / costs[n], int(n)) for gain, n in zip(bounds, numbers) if gain > 0.0]
        heapq.heapify(heap)
        added = 0
        while heap and (most is None or added < most):
            if self.is_enough():
                return True
            worth = self._worth()
            while heap:
                bound, place = heap[0]
                gain, yaw, tilt = self._c.best(np.array([place]), worth)[0]
                if gain <= least_m2:
                    heapq.heappop(heap)
                    continue
                value = gain / costs[place]
                heapq.heapreplace(heap, (-value, place))
                if value >= -bound - 1e-9 or heap[0][1] == place:
                    self.add(Shot(place, yaw, tilt, self._c.drawn(place, yaw, tilt)))
                    added += 1
                    break
        return self.is_enough()

    def _worth(self) -> np.ndarray:
        """Return what each patch counts: its area if none shows it; once the sum is enough, by class."""
        if self._lacks_all():
            return self._open_m2
        return np.where(self._lack()[self._c.patches.parts], self._open_m2, 0.0)

    def drop_idle(self) -> None:
        """Take out photographs that are not needed for the shares, those that show least alone first."""
        alone_m2, costs = self._alone_m2(), self._c.costs[[each.place for each in self.shots]]
        are_idle = self._are_enough(self._now_m2 - alone_m2)
        shots = list(self.shots)
        for k in np.argsort(alone_m2.sum(axis=1) / costs):
            # Without those before, it may show more alone.
            if are_idle[k] and self._are_enough(self._now_m2 - self._alone_of_m2(shots[k])):
                self.remove(shots[k])

    def _alone_of_m2(self, shot: Shot) -> np.ndarray:
        """Return (names,) what a photograph shows that no other does, by thing."""
        return self._sums_m2(shot.drawn[self.counts[shot.drawn] == 1])

    def _alone_m2(self) -> np.ndarray:
        """Return (n, names) the same of each photograph."""
        begins = np.cumsum([0] + [len(each.drawn) for each in self.shots])
        drawn = np.concatenate([each.drawn for each in self.shots])
        p = self._c.patches
        return sums_alone(begins, drawn, self.counts, self.areas_m2, p.parts, len(p.names))

    def improve(self, rng: np.random.Generator, goes_on: Callable[[], bool]) -> None:
        """Choose photographs near each other anew while time is left; keep what costs less, or shows more.

        It ends sooner when `IN_VAIN` choices of each photograph have led to nothing.
        """
        places_m, in_vain = self._c.places_m, 0
        while goes_on() and len(self.shots) > 1 and in_vain < IN_VAIN * len(self.shots):
            in_vain += 1
            before, share, cost = list(self.shots), self.share, self.cost
            state = self.counts.copy(), self._open_m2.copy(), self._now_m2.copy()
            shots_m = places_m[[each.place for each in self.shots]]
            middle_m = shots_m[int(rng.integers(len(self.shots)))]
            away_m = np.linalg.norm(shots_m - middle_m, axis=1)
            chosen = np.argsort(away_m)[: int(rng.integers(1, ANEW + 1))]
            for k in chosen:
                self.remove(before[k])
            reach_m = away_m[chosen[-1]] + REACH_M
            near = np.flatnonzero(((places_m - middle_m) ** 2).sum(axis=1) <= reach_m**2)
            near = near[rng.random(len(near)) < TRIED]
            is_enough = self.fill(near, most=len(chosen))
            if is_enough:
                self.drop_idle()
            costs_more = self.cost - cost
            if not is_enough or costs_more > 1e-9 or (costs_more > -1e-9 and self.share <= share):
                self.shots = before
                self.counts, self._open_m2, self._now_m2 = state
            else:
                in_vain = 0
