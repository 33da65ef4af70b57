"""Which finding of one search is which of another: those that lie on each other, by their places."""

from __future__ import annotations

from typing import Sequence

import numpy as np
from scipy.spatial import cKDTree

from inspection.findings.kinds import kind_of
from inspection.findings.merging import Finding

APART_M = 0.15
"""Positions of one finding in two runs, or in two surveys, differ by less."""
GROWTH_AREA, GROWTH_LENGTH = 1.25, 1.2
LEAST_GROWTH_M2, LEAST_GROWTH_M = 0.001, 0.03
"""Below these, two photographs of one place may differ."""
LEAST_COMMON = 0.5
"""Share of the smaller finding's places that lie at the larger one's."""


def pairs_of(before: Sequence[Finding], now: Sequence[Finding]) -> list[tuple[int, int]]:
    """Return pairs (index before, index now) of one kind in one place, the nearest first; each once."""
    left, right, pairs = set(range(len(before))), set(range(len(now))), []
    for i, j in meetings_of(before, now):
        if i in left and j in right:
            pairs.append((i, j))
            left.remove(i)
            right.remove(j)
    return pairs


def meetings_of(before: Sequence[Finding], now: Sequence[Finding]) -> list[tuple[int, int]]:
    """Return all (index before, index now) of one kind in one place, the nearest first.

    Half of the smaller finding must lie within APART_M of the larger one. One whose places are not known is
    where its middle is, as far around as half the length of the shorter one. Findings that have grown into
    one all meet it.
    """
    apart_m: dict[tuple[int, int], float] = {}
    for kind in {each.kind for each in before} & {each.kind for each in now}:
        for i, j in _meeting(before, now, kind):
            middles = np.array(before[i].position_m), np.array(now[j].position_m)
            apart_m[i, j] = float(np.linalg.norm(middles[0] - middles[1]))
    return sorted(apart_m, key=lambda pair: (apart_m[pair], pair))


def has_grown(before: Sequence[Finding], now: Finding, times: float | None = None) -> bool:
    """Return whether a finding is larger than those before in its place together.

    times: it must be so many times as large; None: as of a finding that grows.
    """
    if kind_of(now.kind).is_sized_by_area:
        area_m2 = sum(each.area_m2 for each in before)
        return now.area_m2 > max((times or GROWTH_AREA) * area_m2, area_m2 + LEAST_GROWTH_M2)
    length_m = sum(each.length_m for each in before)
    return now.length_m > max((times or GROWTH_LENGTH) * length_m, length_m + LEAST_GROWTH_M)


def _meeting(before: Sequence[Finding], now: Sequence[Finding], kind: str) -> set[tuple[int, int]]:
    first = [k for k, each in enumerate(before) if each.kind == kind]
    second = [k for k, each in enumerate(now) if each.kind == kind]
    pairs = _of_middles([before[k] for k in first], [now[k] for k in second])
    pairs |= _of_places([before[k] for k in first], [now[k] for k in second])
    return {(first[i], second[j]) for i, j in pairs}


def _of_middles(first: Sequence[Finding], second: Sequence[Finding]) -> set[tuple[int, int]]:
    """Return the pairs of which one tells no places."""
    tree = cKDTree([each.position_m for each in first])
    pairs = set()
    for j, each in enumerate(second):
        for i in tree.query_ball_point(each.position_m, APART_M + 0.5 * each.length_m):
            if first[i].places_m and each.places_m:
                continue
            off_m = float(np.linalg.norm(np.subtract(first[i].position_m, each.position_m)))
            if off_m <= APART_M + 0.5 * min(first[i].length_m, each.length_m):
                pairs.add((i, j))
    return pairs


def _of_places(first: Sequence[Finding], second: Sequence[Finding]) -> set[tuple[int, int]]:
    """Return the pairs of which both tell places."""
    of_first, places_first = _places(first)
    of_second, places_second = _places(second)
    if not len(of_first) or not len(of_second):
        return set()
    near = cKDTree(places_first).sparse_distance_matrix(
        cKDTree(places_second), APART_M, output_type="coo_matrix"
    )
    shares: dict[tuple[int, int], float] = {}
    for own, other, of, many in (
        (near.row, near.col, of_first, first),
        (near.col, near.row, of_second, second),
    ):
        partner = (of_second if of is of_first else of_first)[other]
        met = np.unique(np.column_stack((of[own], partner, own)), axis=0)
        pairs, counts = np.unique(met[:, :2], axis=0, return_counts=True)
        for (mine, theirs), count in zip(pairs.tolist(), counts.tolist()):
            pair = (mine, theirs) if of is of_first else (theirs, mine)
            shares[pair] = max(shares.get(pair, 0.0), count / len(many[mine].places_m))
    return {pair for pair, share in shares.items() if share >= LEAST_COMMON}


def _places(findings: Sequence[Finding]) -> tuple[np.ndarray, np.ndarray]:
    """Return the finding (k,) of each place, and the places (k, 3)."""
    of = np.repeat(np.arange(len(findings)), [len(each.places_m) for each in findings])
    return of, np.array([place for each in findings for place in each.places_m]).reshape(-1, 3)
