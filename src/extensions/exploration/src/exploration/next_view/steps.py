"""Divides ways into short steps."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np


def in_steps(places_m: Sequence[np.ndarray], step_m: float) -> list[np.ndarray]:
    """Return the places (x, y, z) of a way with others between, so that no step is longer than this."""
    stepped = [np.asarray(place_m, float) for place_m in places_m[:1]]
    for begin_m, end_m in zip(places_m, places_m[1:]):
        count = max(1, math.ceil(math.dist(begin_m, end_m) / step_m))
        stepped += [begin_m + share * (end_m - begin_m) for share in np.linspace(0.0, 1.0, count + 1)[1:]]
    return stepped
