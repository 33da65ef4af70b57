"""Forests: trunks that keep a distance from each other, and thick ones that may overlap."""

from __future__ import annotations

import math

import numpy as np

from flights.worlds.drawn.free_way import shapes_of, way_exists
from flights.worlds.drawn.materials import BARK, CLEAR_M, GRASS
from flights.worlds.writer import Cylinder, Part, Prop, write_world

HALF_WIDTH_M, THICK_HALF_WIDTH_M = 10.0, 15.0
SPACING_M = 2.0
"""Least distance between trunks' middles in a forest of a given density."""
MIXED_SPACINGS_M = (2.0, 4.0)
"""Bounds of the least distance that is drawn for each mixed forest: 0.16 to 0.04 trees per m2."""
RADII_M, THICK_RADII_M = (0.12, 0.30), (0.25, 1.0)
THICK_DENSITY_PER_M2 = 0.12
THICK_HEIGHT_M = 6.0
DARTS = 3000


def plant(
    rng: np.random.Generator, spacing_m: float, distance_m: float, most: int | None = None
) -> np.ndarray:
    """Return trunks (n, 3: x, y, radius in m): as many as their spacing leaves room for (darts), or fewer.

    With the same generator a denser forest is a sparser one with more trunks in it.
    """
    trunks = np.empty((0, 3))
    for _ in range(DARTS):
        if len(trunks) == most:
            break
        x, y = rng.uniform(CLEAR_M, distance_m - CLEAR_M), rng.uniform(-HALF_WIDTH_M, HALF_WIDTH_M)
        radius = rng.uniform(*RADII_M)
        gaps = np.hypot(*(trunks[:, :2] - (x, y)).T)
        if gaps.min(initial=math.inf) >= spacing_m:
            trunks = np.vstack((trunks, (x, y, radius)))
    return trunks


def plant_thick(rng: np.random.Generator, distance_m: float) -> np.ndarray:
    """Return trunks (n, 3: x, y, radius in m) that may overlap but leave a way through.

    A drawing without a way is drawn again; there was none in 400 drawings over 54 m.
    """
    area_m2 = (distance_m - 2 * CLEAR_M) * 2 * THICK_HALF_WIDTH_M
    low = CLEAR_M, -THICK_HALF_WIDTH_M, THICK_RADII_M[0]
    high = distance_m - CLEAR_M, THICK_HALF_WIDTH_M, THICK_RADII_M[1]
    while True:
        trunks = rng.uniform(low, high, (round(THICK_DENSITY_PER_M2 * area_m2), 3))
        shapes = shapes_of(_trees(trunks, THICK_HEIGHT_M))
        if way_exists(shapes, distance_m, THICK_HALF_WIDTH_M, (THICK_HEIGHT_M / 2,)):
            return trunks


def forest_sdf(trunks: np.ndarray, height_m: float = 4.0) -> str:
    """Return the world file's text of trunks (n, 3: x, y, radius in m)."""
    return write_world("random_forest", "A forest drawn at random.", GRASS, _trees(trunks, height_m))


def _trees(trunks: np.ndarray, height_m: float) -> tuple[Prop, ...]:
    return tuple(
        Prop(f"tree_{i}", x, y, (Part("trunk", Cylinder(radius, height_m), BARK),))
        for i, (x, y, radius) in enumerate(trunks.tolist())
    )
