"""A place to look from, and a look that was taken."""

from __future__ import annotations

from typing import NamedTuple, Sequence

import numpy as np


class View(NamedTuple):
    """Where to look from.

    place_m: (x, y, z). way_m: to it. gain_m3: what it would show. column_m: (k, 3) the way straight up or
    down at its end, from where a way is known on; None: all of the way is known.
    """

    place_m: np.ndarray
    way_m: float
    gain_m3: float
    column_m: np.ndarray | None = None


class Look(NamedTuple):
    """What was looked at. places_m: (x, y, z) each, from which. counts: as how much of a view it counts."""

    places_m: Sequence[np.ndarray]
    counts: float


NO_LOOK = Look((), 0.0)
