"""The linear relaxation of the set cover: no set of photographs of these candidates can be smaller.

Its dual gives each patch a price, so that no photograph shows patches for more than 1. The sum of such
prices, without the dearest that may be left out, is a bound. Columns are generated: prices that are right
for some photographs tell which others would show more.
"""

from __future__ import annotations

from typing import Iterator

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csr_matrix, hstack, identity, vstack

from inspection.survey.views.candidates import Candidates
from inspection.survey.views.cover import Cover

PER_PHOTOGRAPH = 20
"""Patches drawn for each photograph of the plan. In hold_3d the relaxation's optimum is 231 photographs with
5 for each, 320 with 15 and 345 with 20, where 482 are planned."""
ROUNDS = 10
INERTIA = 0.6
"""New prices are mixed with so much of the best ones, as the LP's own jump from round to round."""
ALIKE = 4
"""A new column is left out if more than half of its patches are in so many other new ones already."""
IDLE = 0.15
"""A column is forgotten if its prices are so much below 1."""


def lp_bounds(
    candidates: Candidates, cover: Cover, share: float, rng: np.random.Generator
) -> Iterator[float]:
    """Yield rising lower bounds of the number of photographs that show a share of patches drawn by area.

    They end early if the solver finds no optimum.
    """
    sample = PatchSample(candidates, cover, share, rng)
    columns = [sample.rows_of(shot.drawn) for shot in cover.shots]
    bound, best = 0.0, None
    for _ in range(ROUNDS):
        prices = sample.prices_for(columns)
        if prices is None:
            return
        trial = prices if best is None else INERTIA * best + (1.0 - INERTIA) * prices
        views = sample.best_views(trial)
        fair = sample.fair(trial, views[:, 0], columns)
        fair = sample.fair(fair, sample.best_views(fair)[:, 0], columns)
        if best is None or sample.bound_by(fair) > bound:
            bound, best = sample.bound_by(fair), fair
        yield bound
        columns = [each for each in columns if prices[each].sum() > 1.0 - IDLE]
        columns += sample.new_columns(views, prices)


class PatchSample:
    """Patches that are drawn by area, their rows, and the places that see each of them."""

    def __init__(self, candidates: Candidates, cover: Cover, share: float, rng: np.random.Generator):
        self._c, areas = candidates, cover.areas_m2
        sample_size = min(PER_PHOTOGRAPH * max(len(cover.shots), 1), int((areas > 0.0).sum()))
        self._drawn = rng.choice(len(areas), sample_size, replace=False, p=areas / areas.sum())
        self._row = np.full(len(areas), -1)
        self._row[self._drawn] = np.arange(sample_size)
        self._left_out = max((1.0 - share) * sample_size, float((cover.counts[self._drawn] == 0).sum()))
        rows = self._row[candidates.seen]
        of = np.repeat(np.arange(len(candidates.places_m)), np.diff(candidates.begins))[rows >= 0]
        rows = rows[rows >= 0]
        order = np.argsort(rows, kind="stable")
        self._places, self._begins = of[order], np.searchsorted(rows[order], np.arange(sample_size))

    def rows_of(self, patches: np.ndarray) -> np.ndarray:
        """Return the rows of those patches that are drawn."""
        rows = self._row[patches]
        return rows[rows >= 0]

    def bound_by(self, prices: np.ndarray) -> float:
        """Return the sum of prices (rows,) without the dearest, which may be left out."""
        whole = int(self._left_out)
        falling = np.append(np.sort(prices)[::-1], 0.0)
        return float(falling[whole:].sum() - (self._left_out - whole) * falling[whole])

    def best_views(self, prices: np.ndarray) -> np.ndarray:
        """Return (places, 3) the price, yaw and tilt of the dearest photograph from each place."""
        worth = np.zeros(len(self._row))
        worth[self._drawn] = prices
        return self._c.best(np.arange(len(self._c.places_m)), worth)

    def fair(self, prices: np.ndarray, best: np.ndarray, columns: list[np.ndarray]) -> np.ndarray:
        """Return prices (rows,), lowered or raised, with which no photograph is worth more than 1.

        Each is divided by the dearest photograph (places,) of any place that sees the patch: with old prices
        a photograph is worth at most that of its place, so with new ones at most 1. The columns count, too:
        `best_views` tries some directions only, and may miss the best.
        """
        most = np.maximum.reduceat(best[self._places], self._begins)
        for column in columns:
            most[column] = np.maximum(most[column], prices[column].sum())
        return np.divide(prices, most, out=np.zeros_like(prices), where=most > 0.0)

    def new_columns(self, views: np.ndarray, prices: np.ndarray) -> list[np.ndarray]:
        """Return photographs (rows of each) worth more than 1, from views (places, 3), few of them alike."""
        added, counts = [], np.zeros(len(prices), np.int64)
        for place in np.argsort(-views[:, 0]).tolist():
            column = self.rows_of(self._c.drawn(place, views[place, 1], views[place, 2]))
            if prices[column].sum() > 1.0 + 1e-6 and (counts[column] >= ALIKE).mean() <= 0.5:
                counts[column] += 1
                added.append(column)
        return added

    def prices_for(self, columns: list[np.ndarray]) -> np.ndarray | None:
        """Return the dual prices (rows,) of the relaxation with these columns only; None: not solved."""
        rows, number = len(self._drawn), len(columns)
        begins = np.cumsum([0] + [len(each) for each in columns])
        entries = (np.ones(begins[-1]), np.concatenate(columns), begins)
        shows = csr_matrix(entries, shape=(number, rows)).T
        may_be_left = np.concatenate((np.zeros(number), np.ones(rows)))[None]
        matrix = vstack([hstack([-shows, -identity(rows)]), csr_matrix(may_be_left)]).tocsr()
        costs = np.concatenate((np.ones(number), np.zeros(rows)))
        limits = np.concatenate((-np.ones(rows), [self._left_out]))
        # The interior point method is five times as fast here as the simplex method.
        found = linprog(costs, A_ub=matrix, b_ub=limits, bounds=(0, None), method="highs-ipm")
        return -found.ineqlin.marginals[:-1] if found.success else None
