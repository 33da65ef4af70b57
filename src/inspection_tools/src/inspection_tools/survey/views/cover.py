"""A small set of photographs that shows a share of the surface: lazy greedy, then local search."""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import Callable

import numpy as np

from inspection_tools.survey.parameters import SurveyParameters
from inspection_tools.survey.views.candidates import Candidates, View

LEAST_M2 = 1e-9
NEIGHBOURHOOD = 8
"""Photographs that are taken away together and chosen anew."""


@dataclass(frozen=True)
class Shot:
    """A photograph from a place of the candidates, and the patches that it draws."""

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
        self._c, self._p = candidates, parameters
        self.areas_m2 = np.where(candidates.reachable, candidates.patches.areas_m2, 0.0)
        self._shown_m2 = np.zeros(len(candidates.patches.names)) if shown_m2 is None else shown_m2
        self._whole_m2 = float(self.areas_m2.sum() + self._shown_m2.sum())
        self.shots: list[Shot] = []
        self.counts = np.zeros(len(self.areas_m2), np.int64)
        self._bounds = candidates.best(np.arange(len(candidates.places_m)), self.areas_m2)[:, 0]
        self._by_class = self._shown_m2 + np.bincount(
            candidates.patches.parts, self.areas_m2, len(candidates.patches.names)
        )

    @property
    def share(self) -> float:
        """Of the reachable area that is shown, 0..1."""
        shown_m2 = self.areas_m2[self.counts > 0].sum() + self._shown_m2.sum()
        return float(shown_m2 / max(self._whole_m2, 1e-12))

    @property
    def cost(self) -> float:
        """Of all photographs: their number, where the UAV has room."""
        return float(sum(self._c.costs[each.place] for each in self.shots))

    @property
    def views(self) -> list[View]:
        """The photographs."""
        places_m = self._c.places_m
        return [View(tuple(places_m[s.place].tolist()), float(s.yaw), float(s.tilt)) for s in self.shots]

    def class_shares(self) -> np.ndarray:
        """(names,) the same for each thing; 1 where nothing of it is reachable."""
        shown = self._shown_m2 + np.bincount(
            self._c.patches.parts, self.areas_m2 * (self.counts > 0), len(self._c.patches.names)
        )
        return np.where(self._by_class > 1e-9, shown / np.maximum(self._by_class, 1e-9), 1.0)

    def is_enough(self) -> bool:
        """Whether the shares are those that are asked for."""
        return self.share >= self._p.share and bool((self.class_shares() >= self._p.class_share).all())

    def add(self, shot: Shot) -> None:
        """Take a photograph in."""
        self.shots.append(shot)
        self.counts[shot.drawn] += 1

    def remove(self, shot: Shot) -> None:
        """Take a photograph out."""
        self.shots = [each for each in self.shots if each is not shot]
        self.counts[shot.drawn] -= 1

    def fill(
        self, places: np.ndarray | None = None, most: int | None = None, least_m2: float = LEAST_M2
    ) -> bool:
        """Add the photograph that shows most of what is open for its cost, until it is enough (lazy greedy).

        places: candidates; None: all. most: so many at most. least_m2: that one must show. Returns whether it
        is enough.
        """
        numbers = np.arange(len(self._c.places_m)) if places is None else places
        costs = self._c.costs
        heap = [(-gain / costs[n], int(n)) for gain, n in zip(self._bounds[numbers], numbers) if gain > 0.0]
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
        worth = np.where(self.counts == 0, self.areas_m2, 0.0)
        if self.share >= self._p.share:
            lacks = self.class_shares() < self._p.class_share
            worth = np.where(lacks[self._c.patches.parts], worth, 0.0)
        return worth

    def drop_idle(self) -> None:
        """Take out photographs that are not needed for the shares, those that show least alone first."""
        for shot in sorted(self.shots, key=lambda each: self._alone_m2(each) / self._c.costs[each.place]):
            self.remove(shot)
            if not self.is_enough():
                self.add(shot)
                if self._alone_m2(shot) > self.slack_m2():
                    break

    def slack_m2(self) -> float:
        """Return the area that is shown beyond what is asked."""
        return (self.share - self._p.share) * self._whole_m2

    def _alone_m2(self, shot: Shot) -> float:
        return float(self.areas_m2[shot.drawn[self.counts[shot.drawn] == 1]].sum())

    def improve(self, rng: np.random.Generator, goes_on: Callable[[], bool]) -> None:
        """Choose photographs near each other anew while time is left; keep what costs less, or shows more."""
        places_m = self._c.places_m
        while goes_on() and len(self.shots) > 1:
            middle = places_m[self.shots[int(rng.integers(len(self.shots)))].place]
            away = np.array([np.linalg.norm(places_m[each.place] - middle) for each in self.shots])
            chosen = [self.shots[k] for k in np.argsort(away)[: min(NEIGHBOURHOOD, len(away))]]
            before, share, cost = list(self.shots), self.share, self.cost
            for shot in chosen:
                self.remove(shot)
            reach_m = float(np.sort(away)[len(chosen) - 1]) + 2.0
            near = np.flatnonzero(((places_m - middle) ** 2).sum(axis=1) <= reach_m**2)
            near = rng.permutation(near)[: max(200, len(near) // 2)]
            is_enough = self.fill(near, most=len(chosen))
            if is_enough:
                self.drop_idle()
            costs_more = self.cost - cost
            if not is_enough or costs_more > 1e-9 or (costs_more > -1e-9 and self.share <= share):
                self._set(before)

    def _set(self, shots: list[Shot]) -> None:
        self.shots = shots
        self.counts[:] = 0
        for shot in shots:
            self.counts[shot.drawn] += 1
