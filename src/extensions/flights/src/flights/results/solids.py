"""Draws solid shapes from above, alike in every picture."""

from __future__ import annotations

from typing import Any, Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.patches import Patch, Polygon

from flights.results.palette import SOLID

_EDGE: dict[str, Any] = {"edgecolor": "black", "linewidth": 0.3}


def draw_solids(axes: Axes, outlines_xy: Iterable[np.ndarray], colour: str = SOLID, **style: Any) -> None:
    """Draw outlines (n, 2), m; those with fewer than three corners are left out. style: matplotlib's."""
    patches = [Polygon(outline, closed=True) for outline in outlines_xy if len(outline) > 2]
    axes.add_collection(PatchCollection(patches, facecolor=colour, **_EDGE, **style))


def solid_mark(label: str, colour: str = SOLID) -> Patch:
    """Return the mark of solid shapes for a legend."""
    return Patch(facecolor=colour, **_EDGE, label=label)
