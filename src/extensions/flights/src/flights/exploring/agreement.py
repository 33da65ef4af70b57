"""A flight whose map does not agree with itself is no success."""

from __future__ import annotations

import math

from gridslam.evaluation.volume.doubled_surfaces import disagreement


def with_agreement(content: dict, share: float) -> dict:
    """Return the content of result.json with `doubled_share`. A flight that failed keeps its own failure.

    content: with `exploration`. share: of the map, see `doubled_share`; NaN: it has no surface.
    """
    told = None if math.isnan(share) else share
    judged = {**content, "exploration": {**content["exploration"], "doubled_share": told}}
    wrong = disagreement(share)
    if wrong and content["success"]:
        judged |= {"success": False, "failure": wrong}
    return judged
