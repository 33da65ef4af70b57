"""Particles' maps as plain tables, and beams at random: what the tests of the maps share."""

from __future__ import annotations

import numpy as np
from plain_filter import PlainMap

from gridslam.kernels.tiles import PARTS, SIDE
from gridslam.maps.beams import Beams
from gridslam.maps.tile_map import TileMaps

WINDOW = 3
"""Tiles along the side of the tests' windows."""
SIZE = WINDOW * SIDE


def plain_of(maps: TileMaps, particle: int) -> PlainMap:
    """One particle's map without tiles."""
    maps.settle(particle)
    table = maps.tables[particle]
    tiles = maps.pool.tiles
    ends, shape = tiles.ends[table], (*table.shape, SIDE, SIDE)
    visits = _assembled(tiles.visits[table].reshape(*shape, 1))[..., 0]
    hits = _assembled(tiles.hits[ends].reshape(*shape, 1))[..., 0]
    means = _assembled(tiles.means[ends].reshape(*shape, 2))
    return PlainMap(hits.astype(int), visits.astype(int), means / PARTS)


def _assembled(tiles: np.ndarray) -> np.ndarray:
    height, width = tiles.shape[:2]
    return tiles.transpose(0, 2, 1, 3, 4).reshape(height * SIDE, width * SIDE, -1)


def beams_from(rng: np.random.Generator, count: int, reach: float = 30.0) -> Beams:
    """Beams in all directions that end within ``reach`` cells, most of them at something."""
    bearings = np.sort(rng.uniform(-np.pi, np.pi, count))
    ranges = rng.uniform(2.0, reach, count)
    ends = np.stack((ranges * np.cos(bearings), ranges * np.sin(bearings)), axis=1)
    return Beams(np.array([0.5, -0.3]), ends, rng.random(count) < 0.8, np.zeros((0, 7)))
