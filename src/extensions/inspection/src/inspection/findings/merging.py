"""Merges what several photographs show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, Literal, Sequence, get_args

import numpy as np
from scipy.spatial import cKDTree

from flight_basics.geometry import Vector3
from inspection.findings.kinds import kind_of
from inspection.findings.linking import linked
from inspection.findings.placing import Placed, extent

PIECE_M = 1.0
"""What is wider along x, y or z of the map is told in pieces, but for cracks. So a corroded wall has findings
that lie on one plate each.
"""
CELL_M = 0.05
"""Of the places of a finding, one in each cube of this side is kept."""
SURE = 2.0
"""One spot in two photographs lies apart by at most so many standard deviations of the difference."""
ONE_SIDE = 0.5
"""Cosine of the angle between the normals of one spot, at least."""
SPARSE = 2.0
"""A photograph shows the surface up to so many times the distance between its points around them."""

Status = Literal["new", "under review", "confirmed", "dismissed"]
STATUSES: tuple[Status, ...] = get_args(Status)


@dataclass(frozen=True)
class Finding:
    """One finding in the map. area_m2: of rust. places_m: some of its places, (x, y, z) each.

    status: new, under review, confirmed or dismissed, and remark: the surveyor's. detail_mm: that a pixel
    covers in the worst direction, in the photograph that shows it best; 0: not known. deviation_m: standard
    deviation of the place, by the poses and the lens; 0: not known.
    """

    id: int
    kind: str
    position_m: Vector3
    normal: Vector3
    length_m: float
    area_m2: float
    photographs: tuple[str, ...]
    status: Status = "new"
    remark: str = ""
    detail_mm: float = 0.0
    places_m: tuple[Vector3, ...] = ()
    deviation_m: float = 0.0


def merged(placed: Sequence[Placed], apart_m: float) -> list[Finding]:
    """Return the findings: candidates of one kind with points nearer than apart_m are one.

    So are those of different photographs whose middles are not farther apart than their poses may be wrong.
    """
    findings: list[Finding] = []
    for kind in sorted({each.kind for each in placed}):
        for group in _groups([each for each in placed if each.kind == kind], apart_m):
            for piece in [group] if kind_of(kind).is_line else _pieces(group):
                findings.append(_finding(len(findings) + 1, kind, piece, apart_m))
    return findings


def _groups(own: Sequence[Placed], apart_m: float) -> list[list[Placed]]:
    """Return the candidates that belong together.

    Those that do so because their poses are not sure are moved to where the surest one is. Farther apart than
    PIECE_M two stay two: rust is better told twice than not at all.
    """
    groups = [[own[k] for k in together] for together in linked([e.points_m for e in own], apart_m)]
    middles_m = np.array([np.concatenate([e.points_m for e in group]).mean(axis=0) for group in groups])
    facing = np.array([np.mean([e.normal for e in group], axis=0) for group in groups])
    off_m = np.array([max(each.off_m for each in group) for group in groups])
    pairs = cKDTree(middles_m).query_pairs(PIECE_M, output_type="ndarray")
    pairs = pairs[(facing[pairs[:, 0]] * facing[pairs[:, 1]]).sum(axis=1) > ONE_SIDE]
    share = np.linalg.norm(np.diff(middles_m[pairs], axis=1)[:, 0], axis=1)
    share /= np.maximum(SURE * np.hypot(*off_m[pairs].T), 1e-9)
    shown = [{each.photograph for each in group} for group in groups]
    owner = list(range(len(groups)))
    for k in np.argsort(share, kind="stable")[: int((share <= 1.0).sum())]:
        first, second = (owner[each] for each in pairs[k].tolist())
        first, second = sorted((first, second), key=lambda each: min(one.off_m for one in groups[each]))
        if first != second and not shown[first] & shown[second]:  # what one photograph shows apart is apart
            shift_m = middles_m[first] - middles_m[second]
            groups[first] += [each._replace(points_m=each.points_m + shift_m) for each in groups[second]]
            shown[first] |= shown[second]
            owner = [first if each == second else each for each in owner]
    return [groups[k] for k in sorted(set(owner))]


def _pieces(group: list[Placed]) -> Iterator[list[Placed]]:
    """Yield the parts of a group between planes at multiples of `PIECE_M`, none wider than that."""
    points_m = np.concatenate([each.points_m for each in group])
    low, high = points_m.min(axis=0), points_m.max(axis=0)
    axis = int(np.argmax(high - low))
    if high[axis] - low[axis] <= PIECE_M:
        yield group
        return
    plane_m = PIECE_M * round(0.5 * (low[axis] + high[axis]) / PIECE_M)
    for is_above in (False, True):
        sides = [(each, (each.points_m[:, axis] >= plane_m) == is_above) for each in group]
        yield from _pieces([_part(each, are_meant) for each, are_meant in sides if are_meant.any()])


def _part(placed: Placed, are_meant: np.ndarray) -> Placed:
    """Return some of a candidate's points (n,), with their share of its area."""
    share = float(are_meant.mean())
    return placed._replace(points_m=placed.points_m[are_meant], area_m2=share * placed.area_m2)


def _finding(number: int, kind: str, group: Sequence[Placed], apart_m: float) -> Finding:
    best_m = min(each.off_m for each in group)
    sure = [each for each in group if each.off_m <= SURE * best_m]
    points_m = np.concatenate([each.points_m for each in sure])
    middle, length = extent(points_m)
    length = max([length, *(extent(each.points_m)[1] for each in group if each.off_m > SURE * best_m)])
    normal = np.mean([each.normal for each in group], axis=0)
    normal /= max(float(np.linalg.norm(normal)), 1e-9)
    names = tuple(sorted({each.photograph for each in group}))
    place, facing = (_rounded(each) for each in (middle, normal))
    return Finding(
        number, kind, place, facing, round(length, 4), round(_area_m2(group, apart_m), 6), names,
        detail_mm=round(min(each.detail_mm for each in group), 3),
        places_m=thinned(points_m), deviation_m=round(max(each.off_m for each in sure), 3),
    )  # fmt: skip


def _area_m2(group: Sequence[Placed], apart_m: float) -> float:
    """Return the area that the photographs show together.

    The one that shows most counts. Each further one counts with what lies farther than apart_m from that.
    """
    shown: dict[str, list[Placed]] = {}
    for each in group:
        shown.setdefault(each.photograph, []).append(each)
    total_m2, known = 0.0, np.zeros((0, 3))
    for parts in sorted(shown.values(), key=lambda parts: -sum(each.area_m2 for each in parts)):
        points_m = np.concatenate([each.points_m for each in parts])
        each_m2 = np.concatenate([np.full(len(p.points_m), p.area_m2 / len(p.points_m)) for p in parts])
        if len(known):
            reach_m = np.maximum(apart_m, SPARSE * np.sqrt(each_m2))
            is_new = cKDTree(known).query(points_m)[0] > reach_m
            points_m, each_m2 = points_m[is_new], each_m2[is_new]
        total_m2 += float(each_m2.sum())
        known = np.concatenate((known, points_m))
    return total_m2


def _rounded(values: np.ndarray) -> Vector3:
    x, y, z = (round(float(each), 4) for each in values)
    return x, y, z


def thinned(points_m: np.ndarray) -> tuple[Vector3, ...]:
    """Return the first point in each cube of `CELL_M`, to the millimetre."""
    _, first = np.unique(np.floor(points_m / CELL_M).astype(int), axis=0, return_index=True)
    return tuple((x, y, z) for x, y, z in np.round(points_m[np.sort(first)], 3).tolist())
