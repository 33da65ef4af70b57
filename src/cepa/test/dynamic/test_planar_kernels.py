"""What a planar scan and range finders stamp, beside slow references."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cepa import CepaParameters, Motion, Ranging
from cepa.dynamic.constants.distance_fields import LAYERS
from cepa.dynamic.free_space.planar_sensors import Body, Cells, LidarPlane, stamp_plane, stamp_ranges
from cepa.dynamic.free_space.seen_cells import SeenCells
from cepa.dynamic.kernels.distance_layers import shade
from cepa.dynamic.kernels.free_space import BY_REACH
from cepa.dynamic.remembered.kernels.voxels import outside

EDGE_M, HEIGHT_M, NOW_S, NEVER_S = 0.2, 0.15, 10.0, -math.inf
BODY = Body(radius=0.35, below=0.2, above=0.1, middle=0.03)
LEAN = (0.03, -0.05, 0.4, 0.915)
seeds = st.integers(0, 2**32 - 1)


def moved(rng):
    quaternion = np.array(LEAN) / np.linalg.norm(LEAN)
    return Motion(
        NOW_S, tuple(rng.uniform((-3.0, -3.0, 1.5), (3.0, 3.0, 2.5))), tuple(quaternion), (0.0, 0.0, 0.0)
    )


def cells_of(motion, n=20, levels=12):
    """Return fresh cells, and of each its indices and the place of its middle from the lidar."""
    cells = Cells(np.full((n, n, levels), NEVER_S), EDGE_M, HEIGHT_M)
    x, y, z = motion.position_m
    firsts = (
        math.floor(y / EDGE_M) - n // 2,
        math.floor(x / EDGE_M) - n // 2,
        math.floor(z / HEIGHT_M) - levels // 2,
    )
    places = {}
    for i, j, k in np.ndindex(n, n, levels):
        row, column, level = firsts[0] + i, firsts[1] + j, firsts[2] + k
        middle = (column + 0.5) * EDGE_M - x, (row + 0.5) * EDGE_M - y, (level + 0.5) * HEIGHT_M - z
        places[row % n, column % n, level % levels] = middle
    return cells, places


def is_at_body(z):
    return BODY.middle - BODY.below - 0.5 * HEIGHT_M < z < BODY.middle + BODY.above + 0.5 * HEIGHT_M


@settings(max_examples=5)
@given(seed=seeds)
def test_beams_show_the_bodys_heights_and_their_own_plane(seed):
    rng = np.random.default_rng(seed)
    motion = moved(rng)
    cells, places = cells_of(motion)
    plane = LidarPlane(rng.uniform(-1.0, 2.5, 36), np.empty((1, 1, 1)))
    stamp_plane(cells, plane, motion, BODY)
    normal, lowest = motion.rotation()[:, 2], min(z for _, _, z in places.values())
    for index, (x, y, z) in places.items():
        bearing = round(math.atan2(y, x) * 36 / (2.0 * math.pi)) % 36
        is_passed = plane.free_m[bearing] > math.hypot(x, y) + 0.5 * EDGE_M
        tilted = -(normal[0] * x + normal[1] * y) / normal[2]
        is_in_plane = math.floor((tilted - lowest) / HEIGHT_M + 0.5) == round((z - lowest) / HEIGHT_M)
        assert (cells.stamps[index] == NOW_S) == (is_passed and (is_at_body(z) or is_in_plane))


@settings(max_examples=5)
@given(seed=seeds, range_m=st.sampled_from([0.5, 0.8, math.inf, math.nan]))
def test_a_range_shows_what_is_beside_the_body_along_its_beam(seed, range_m):
    rng = np.random.default_rng(seed)
    motion = moved(rng)
    cells, places = cells_of(motion)
    ranging = Ranging((0.05, -0.02, 0.04), (0.0, 0.0, -1.0), range_m, 0.05, 10.0)
    stamp_ranges(cells, [ranging], motion, BODY, 0.6)
    start, way = motion.rotation() @ ranging.origin_m, motion.rotation() @ ranging.direction
    for index, (x, y, z) in places.items():
        along = (z - start[2]) / way[2]
        is_passed = -0.5 * HEIGHT_M <= along <= ranging.free_m - 0.5 * HEIGHT_M
        apart_m = math.hypot(x - start[0] - along * way[0], y - start[1] - along * way[1])
        expected = is_passed and not is_at_body(z) and apart_m < 0.6
        assert (cells.stamps[index] == NOW_S) == expected


@pytest.mark.table("seed", range(3))
def test_its_own_place_is_what_would_be_seen_if_all_around_the_body_were(seed):
    rng, parameters = np.random.default_rng(seed), CepaParameters()
    motion = moved(rng)
    seen, origin = SeenCells(parameters), np.array(motion.position_m)
    seen._stamps_s[:] = np.where(rng.random(seen._stamps_s.shape) < 0.97, NOW_S, 0.0)
    before = seen.unseen_since(5.0, origin).copy()
    found = before.copy()
    own = SeenCells(parameters)
    own._stamps_s[:] = seen._stamps_s
    unseen = seen.unseen_since(5.0, origin)
    seen.open_own_place(unseen, motion, BODY.middle, 5.0, origin)
    np.testing.assert_array_equal(seen._stamps_s, own._stamps_s)  # it was for a moment only
    # All cells whose middles are within a metre of the body's rim, at the body's levels, are stamped
    body, n, levels = own._body(BODY.middle), *own._stamps_s.shape[1:]
    first = [math.floor(o / e) - c // 2 for o, e, c in zip(origin, (0.2, 0.2, 0.15), (n, n, levels))]
    columns, rows, heights = (np.arange(a, a + c) for a, c in zip(first, (n, n, levels)))
    x, y, z = (
        (columns + 0.5) * 0.2 - origin[0],
        (rows + 0.5) * 0.2 - origin[1],
        (heights + 0.5) * 0.15 - origin[2],
    )
    is_near = np.hypot(x, y[:, None]) < body.radius + 1.0
    for i, j in zip(*np.nonzero(is_near)):
        own._stamps_s[rows[i] % n, columns[j] % n, heights[body.levels(z, 0.15)] % levels] = NOW_S
    found[before > own.unseen_since(5.0, origin)] = BY_REACH
    np.testing.assert_array_equal(unseen, found)
    assert (found == BY_REACH).any()


@settings(max_examples=5)
@given(seed=seeds)
def test_where_nobody_has_looked_the_plane_counts_at_all_heights(seed):
    rng = np.random.default_rng(seed)
    far, shapes = 1.3, ((LAYERS, 7, 7), (7, 7), (7, 7))
    field, plane, known = (np.minimum(rng.uniform(0.0, 3.0 * far, shape), far) for shape in shapes)
    unseen, at = rng.integers(0, 3, (LAYERS, 4, 4)).astype(np.uint8), np.array([0, 0, 1, 1, 2, 2, 3])
    expected = field.copy()
    for layer, i, j in np.ndindex(field.shape):
        least = min(plane[i, j], known[i, j]) if unseen[layer, at[i], at[j]] else math.inf
        least = min(least, plane[i, j]) if layer == LAYERS // 2 else least
        expected[layer, i, j] = min(field[layer, i, j], least)
    shade(field, plane, known, unseen, at, far)
    np.testing.assert_array_equal(field, expected)


@settings(max_examples=20)
@given(seed=seeds)
def test_what_is_outside_of_a_disc_stays_in_its_order(seed):
    points = np.random.default_rng(seed).uniform(-2.0, 2.0, (50, 3))
    expected = points[np.hypot(points[:, 0] - 0.3, points[:, 1] + 0.2) > 1.1]
    np.testing.assert_array_equal(outside(points, 0.3, -0.2, 1.1), expected)
