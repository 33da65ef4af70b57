"""A nearer photograph decides: a crack that it should show, and does not, is none."""

from __future__ import annotations

from typing import Sequence

import numpy as np
from scipy.spatial import cKDTree

from inspection.findings.kinds import kind_of
from inspection.findings.parameters import FindingParameters
from inspection.findings.placing import Placed, PosedPhotograph

MOST_SHOWN = 0.8
"""A photograph shows a crack if so much of it lies in the part where cracks are looked for."""


def without_refuted(
    placed: Sequence[Placed], photographs: Sequence[PosedPhotograph], parameters: FindingParameters
) -> list[Placed]:
    """Return the candidates without cracks that only farther photographs show.

    A photograph is near if a pixel of it covers at most `crack_closer` mm.
    """
    p = parameters
    near = [each for each in placed if kind_of(each.kind).is_line and each.detail_mm <= p.crack_closer]
    confirmed = cKDTree(np.concatenate([each.points_m for each in near])) if near else None

    def stays(each: Placed) -> bool:
        if not kind_of(each.kind).is_line or each.detail_mm <= p.crack_closer:
            return True
        if confirmed is not None and confirmed.query(each.points_m)[0].min() <= p.apart:
            return True
        return not any(one.share_judged(each.points_m, p.crack_closer) >= MOST_SHOWN for one in photographs)

    return [each for each in placed if stays(each)]
