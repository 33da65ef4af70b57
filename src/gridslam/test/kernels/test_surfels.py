"""The grid of surface elements, against plain dictionaries."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from gridslam.kernels.nearest import NearestPoints
from gridslam.kernels.surfels import FACING_MIN, FLAT_MIN, SurfelTable, add_points, find_surfels, move_cells

CELL, SLOTS = 0.1, 64
TIE = 1e-9
"""Where two numbers are nearer than this, rounding decides which is greater."""

place = st.floats(-0.7, 0.7)
angle = st.one_of(st.none(), st.floats(0.0, math.tau))
surfaces = st.lists(st.tuples(place, place, angle), min_size=1, max_size=25)


def rows(points) -> np.ndarray:
    return np.array(
        [(x, y, *((0.0, 0.0) if a is None else (math.cos(a), math.sin(a))), 1.0) for x, y, a in points]
    )


def empty() -> SurfelTable:
    return SurfelTable.empty(SLOTS)


def held(table: SurfelTable) -> dict:
    """{cell: sums} of the cells that hold points."""
    return {tuple(cell): sums for cell, sums in zip(table.cells.tolist(), table.sums) if sums[4] > 0.5}


def plain(points: np.ndarray) -> dict:
    """{cell: (mean x, mean y, mean normal x, y)}."""
    cells: dict = {}
    for row in points:
        cells.setdefault((math.floor(row[0] / CELL), math.floor(row[1] / CELL)), []).append(row)
    return {cell: np.mean(members, axis=0)[:4] for cell, members in cells.items()}


def nearest(cells: dict, point: np.ndarray, normal: np.ndarray, reach: float):
    facing = []
    for mean in cells.values():
        across = mean[2:] @ normal - FACING_MIN * (normal @ normal) * math.hypot(mean[2], mean[3])
        assume(across == 0.0 or abs(across) > TIE)
        if across >= 0.0:
            facing.append((math.dist(mean[:2], point), mean))
    facing.sort(key=lambda found: found[0])
    distances = [distance for distance, _ in facing]
    assume(all(abs(distance - reach) > TIE for distance in distances))
    assume(len(facing) < 2 or distances[1] - distances[0] > TIE)
    return facing[0][1] if facing and distances[0] < reach else None


@given(surfaces, surfaces, st.floats(-3.0, 3.0), st.floats(-0.1, 0.1))
def test_the_nearest_surface_is_that_of_a_plain_search(mapped, seen, yaw, x):
    table, points, scan = empty(), rows(mapped), rows(seen)
    add_points(points, 1.0, CELL, table)
    turn = np.array(((math.cos(yaw), -math.sin(yaw)), (math.sin(yaw), math.cos(yaw))))
    beams = np.zeros((len(scan), 7))  # as seen from the pose (x, 0, yaw)
    beams[:, 0:2], beams[:, 2:4] = (scan[:, 0:2] - (x, 0.0)) @ turn, scan[:, 2:4] @ turn
    nearby = NearestPoints(np.empty((len(scan), 2)), np.empty(len(scan), np.int64))
    found, _newness = find_surfels(x, 0.0, yaw, beams, 0.2, CELL, table, nearby)
    expected = {}
    for i, row in enumerate(scan):
        mean = nearest(plain(points), row[:2], row[2:4], 0.2)
        if mean is not None:
            expected[i] = mean
    assert list(nearby.which[:found]) == list(expected)
    for k in range(found):
        i = nearby.which[k]
        np.testing.assert_allclose(nearby.points[k], expected[i][:2], atol=1e-9)
        length = math.hypot(*expected[i][2:])
        assume(abs(length - FLAT_MIN) > TIE)
        assert beams[i, 6] == (0.0 if length >= FLAT_MIN else 1.0)
        if length >= FLAT_MIN:
            np.testing.assert_allclose(turn @ beams[i, 4:6], expected[i][2:] / length, atol=1e-9)


@given(surfaces, surfaces)
def test_what_is_taken_out_leaves_no_trace(kept, gone):
    table, only = empty(), empty()
    add_points(rows(kept), 1.0, CELL, table)
    add_points(rows(gone), 1.0, CELL, table)
    add_points(rows(gone), -1.0, CELL, table)
    add_points(rows(kept), 1.0, CELL, only)
    assert held(table).keys() == held(only).keys()
    for cell, sums in held(table).items():
        np.testing.assert_allclose(sums, held(only)[cell], atol=1e-9)


@given(
    st.lists(st.tuples(st.integers(-(10**6), 10**6), st.integers(-(10**6), 10**6)), min_size=1, max_size=40)
)
def test_cells_far_apart_are_told_apart_and_stay_so_in_a_larger_table(cells):
    # Given points in cells anywhere on the plane, so that some belong to the same slot
    points = np.array([((i + 0.5) * CELL, (j + 0.5) * CELL, 1.0, 0.0, 1.0) for i, j in cells])
    table, larger = empty(), SurfelTable.empty(4 * SLOTS)
    taken = add_points(points, 1.0, CELL, table)
    # When they move into another table
    moved = move_cells(table, larger)
    # Then both hold every cell with all its points
    assert taken == moved == len(set(cells))
    for one in (table, larger):
        assert {cell: sums[4] for cell, sums in held(one).items()} == Counter(cells)


def test_a_cell_that_shares_a_slot_is_found_after_the_other_one_left():
    # Given cells in one row whose columns differ by the number of slots
    one, other = rows([(0.05, 0.05, 0.0)]), rows([(0.05 + SLOTS * CELL, 0.05, 0.0)])
    table, nearby = empty(), NearestPoints(np.empty((1, 2)), np.empty(1, np.int64))
    add_points(np.concatenate([one, other, other]), 1.0, CELL, table)
    beams = np.zeros((1, 7))
    beams[0, :3] = 0.05, 0.05, 1.0
    assert find_surfels(0.0, 0.0, 0.0, beams, 0.2, CELL, table, nearby) == (1, 1.0)
    add_points(one, -1.0, CELL, table)
    assert find_surfels(0.0, 0.0, 0.0, beams, 0.2, CELL, table, nearby) == (0, 0.0)
    assert find_surfels(SLOTS * CELL, 0.0, 0.0, beams, 0.2, CELL, table, nearby) == (1, 0.5)
