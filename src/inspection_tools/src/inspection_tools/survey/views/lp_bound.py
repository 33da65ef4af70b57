"""The linear relaxation of the set cover: no set of photographs of these candidates can be smaller."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csr_matrix, hstack, identity, vstack

from inspection_tools.survey.views.candidates import Candidates
from inspection_tools.survey.views.cover import Cover

PER_PHOTOGRAPH = 5
"""Patches drawn for each photograph of the plan."""
ROUNDS = 8
PART = 4
"""Each round prices one of so many parts of the places; the last one prices all."""


def lp_bound(candidates: Candidates, cover: Cover, share: float, rng: np.random.Generator) -> float:
    """Return a lower bound of the number of photographs that show a share of patches drawn by area.

    Columns are generated: the dual prices of the patches tell which photograph would lower the optimum. At
    the end the prices are scaled until no candidate is worth more than 1, so that they prove the bound.
    """
    areas = cover.areas_m2
    wanted = PER_PHOTOGRAPH * max(len(cover.shots), 1)
    drawn = rng.choice(
        len(areas), min(wanted, int((areas > 0.0).sum())), replace=False, p=areas / areas.sum()
    )
    row = np.full(len(areas), -1)
    row[drawn] = np.arange(len(drawn))
    left_out = max((1.0 - share) * len(drawn), float((cover.counts[drawn] == 0).sum()))
    columns = [row[shot.drawn][row[shot.drawn] >= 0] for shot in cover.shots]
    numbers = rng.permutation(len(candidates.places_m))
    for turn in range(ROUNDS + 1):
        prices, objective = _solve(columns, len(drawn), left_out)
        worth = np.zeros(len(areas))
        worth[drawn] = prices
        places = numbers if turn == ROUNDS else numbers[turn % PART :: PART]
        found = candidates.best(places, worth)
        if turn == ROUNDS:
            most = max(1.0, float(found[:, 0].max(initial=0.0)))
            return max(objective / most, 0.0)
        good = np.argsort(-found[:, 0])[: max(200, len(cover.shots))]
        for k in good[found[good, 0] > 1.0 + 1e-6].tolist():
            shown = row[candidates.drawn(int(places[k]), found[k, 1], found[k, 2])]
            columns.append(shown[shown >= 0])
    return math.nan


def _solve(columns: list[np.ndarray], rows: int, left_out: float) -> tuple[np.ndarray, float]:
    """Return the prices of the patches (rows,) and the optimum."""
    begins = np.cumsum([0] + [len(each) for each in columns])
    shows = csr_matrix((np.ones(begins[-1]), np.concatenate(columns), begins), shape=(len(columns), rows)).T
    matrix = vstack(
        [
            hstack([-shows, -identity(rows)]),
            csr_matrix(np.concatenate((np.zeros(len(columns)), np.ones(rows)))[None]),
        ]
    ).tocsr()
    costs = np.concatenate((np.ones(len(columns)), np.zeros(rows)))
    limits = np.concatenate((-np.ones(rows), [left_out]))
    found = linprog(costs, A_ub=matrix, b_ub=limits, bounds=(0, None), method="highs")
    prices = -found.ineqlin.marginals
    return prices[:-1], float(found.fun)
