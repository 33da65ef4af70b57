"""A small set of photographs that shows a share of the surface: lazy greedy, then local search."""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import Callable

import numpy as np

from inspection_tools.survey.parameters import SurveyParameters
from inspection_tools.survey.views.candidates import Candidates

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
    """Photographs, and how many of them show each patch."""

    def __init__(self, candidates: Candidates, parameters: SurveyParameters):
        self._c, self._p = candidates, parameters
        self.areas_m2 = np.where(candidates.reachable, candidates.patches.areas_m2, 0.0)
        self.shots: list[Shot] = []
        self.counts = np.zeros(len(self.areas_m2), np.int64)
        self._bounds = candidates.best(np.arange(len(candidates.places_m)), self.areas_m2)[:, 0]
        self._by_class = np.bincount(candidates.patches.parts, self.areas_m2, len(candidates.patches.names))

    @property
    def share(self) -> float:
        """Of the reachable area that is shown, 0..1."""
        return float(self.areas_m2[self.counts > 0].sum() / max(self.areas_m2.sum(), 1e-12))

    def class_shares(self) -> np.ndarray:
        """(names,) the same for each thing; 1 where nothing of it is reachable."""
        shown = np.bincount(
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

    def fill(self, places: np.ndarray | None = None, most: int | None = None) -> bool:
        """Add the photograph that shows most of what none shows, until it is enough (lazy greedy).

        places: candidates; None: all. most: so many at most. Returns whether it is enough.
        """
        numbers = np.arange(len(self._c.places_m)) if places is None else places
        heap = [(-gain, int(n)) for gain, n in zip(self._bounds[numbers], numbers) if gain > 0.0]
        heapq.heapify(heap)
        added = 0
        while heap and (most is None or added < most):
            if self.is_enough():
                return True
            worth = self._worth()
            while heap:
                bound, place = heap[0]
                gain, yaw, tilt = self._c.best(np.array([place]), worth)[0]
                if gain <= 1e-9:
                    heapq.heappop(heap)
                    continue
                heapq.heapreplace(heap, (-gain, place))
                if gain >= -bound - 1e-9 or heap[0][1] == place:
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
        for shot in sorted(self.shots, key=self._alone_m2):
            self.remove(shot)
            if not self.is_enough():
                self.add(shot)
                if self._alone_m2(shot) > self.slack_m2():
                    break

    def slack_m2(self) -> float:
        """Return the area that is shown beyond what is asked."""
        return (self.share - self._p.share) * float(self.areas_m2.sum())

    def _alone_m2(self, shot: Shot) -> float:
        return float(self.areas_m2[shot.drawn[self.counts[shot.drawn] == 1]].sum())

    def improve(self, rng: np.random.Generator, goes_on: Callable[[], bool]) -> None:
        """Choose photographs near each other anew while time is left; keep what is fewer, or shows more."""
        places_m = self._c.places_m
        while goes_on() and len(self.shots) > 1:
            middle = places_m[self.shots[int(rng.integers(len(self.shots)))].place]
            away = np.array([np.linalg.norm(places_m[each.place] - middle) for each in self.shots])
            chosen = [self.shots[k] for k in np.argsort(away)[: min(NEIGHBOURHOOD, len(away))]]
            before, share = list(self.shots), self.share
            for shot in chosen:
                self.remove(shot)
            reach_m = float(np.sort(away)[len(chosen) - 1]) + 2.0
            near = np.flatnonzero(((places_m - middle) ** 2).sum(axis=1) <= reach_m**2)
            near = rng.permutation(near)[: max(200, len(near) // 2)]
            is_enough = self.fill(near, most=len(chosen))
            if is_enough:
                self.drop_idle()
            fewer = len(self.shots) < len(before)
            if not is_enough or not (fewer or (len(self.shots) == len(before) and self.share > share)):
                self._set(before)

    def _set(self, shots: list[Shot]) -> None:
        self.shots = shots
        self.counts[:] = 0
        for shot in shots:
            self.counts[shot.drawn] += 1
