"""Merges what several photographs show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from inspection_tools.findings.placing import Placed, extent


@dataclass(frozen=True)
class Finding:
    """One finding in the map. area_m2: of rust, the largest that one photograph shows.

    status: new, under review, confirmed or dismissed, and remark: the surveyor's. detail_mm: that a pixel
    covers in the worst direction, in the photograph that shows it best; 0: not known.
    """

    id: int
    kind: str
    position_m: tuple[float, ...]
    normal: tuple[float, ...]
    length_m: float
    area_m2: float
    photographs: tuple[str, ...]
    status: str = "new"
    remark: str = ""
    detail_mm: float = 0.0


def merged(placed: Sequence[Placed], apart_m: float) -> list[Finding]:
    """Return the findings: candidates of one kind with points nearer than apart_m are one."""
    findings: list[Finding] = []
    for kind in sorted({each.kind for each in placed}):
        own = [each for each in placed if each.kind == kind]
        of = np.repeat(np.arange(len(own)), [len(each.points_m) for each in own])
        pairs = cKDTree(np.concatenate([each.points_m for each in own])).query_pairs(
            apart_m, output_type="ndarray"
        )
        links = np.unique(of[pairs], axis=0) if len(pairs) else np.zeros((0, 2), int)
        graph = coo_matrix((np.ones(len(links)), (links[:, 0], links[:, 1])), (len(own), len(own)))
        count, numbers = connected_components(graph, directed=False)
        for number in range(count):
            group = [own[k] for k in np.flatnonzero(numbers == number)]
            findings.append(_finding(len(findings) + 1, kind, group))
    return findings


def _finding(number: int, kind: str, group: Sequence[Placed]) -> Finding:
    middle, length = extent(np.concatenate([each.points_m for each in group]))
    normal = np.mean([each.normal for each in group], axis=0)
    normal /= max(float(np.linalg.norm(normal)), 1e-9)
    names = tuple(sorted({each.photograph for each in group}))
    areas = [sum(each.area_m2 for each in group if each.photograph == name) for name in names]
    place, facing = (tuple(round(float(v), 4) for v in each) for each in (middle, normal))
    detail = round(min(each.detail_mm for each in group), 3)
    return Finding(
        number, kind, place, facing, round(length, 4), round(max(areas), 6), names, detail_mm=detail
    )
