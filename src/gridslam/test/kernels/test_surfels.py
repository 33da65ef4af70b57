"""The grid of surface elements, against plain dictionaries."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from gridslam.kernels.nearest import NearestPoints
from gridslam.kernels.surfels import FACING_MIN, FLAT_MIN, SurfelTable, add_points, find_surfels

CELL, SIDE = 0.1, 16
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
    return SurfelTable(np.zeros((SIDE, SIDE, 2), np.int64), np.zeros((SIDE, SIDE, 5)))


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


@settings(max_examples=80, deadline=None)
@given(surfaces, surfaces, st.floats(-3.0, 3.0), st.floats(-0.1, 0.1))
def test_the_nearest_surface_is_that_of_a_plain_search(mapped, seen, yaw, x):
    table, points, scan = empty(), rows(mapped), rows(seen)
    add_points(points, 1.0, CELL, table)
    turn = np.array(((math.cos(yaw), -math.sin(yaw)), (math.sin(yaw), math.cos(yaw))))
    beams = np.zeros((len(scan), 7))  # as seen from the pose (x, 0, yaw)
    beams[:, 0:2], beams[:, 2:4] = (scan[:, 0:2] - (x, 0.0)) @ turn, scan[:, 2:4] @ turn
    nearby = NearestPoints(np.empty((len(scan), 2)), np.empty(len(scan), np.int64))
    found = find_surfels(x, 0.0, yaw, beams, 0.2, CELL, table, nearby)
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


@settings(max_examples=40, deadline=None)
@given(surfaces, surfaces)
def test_what_is_taken_out_leaves_no_trace(kept, gone):
    table, only = empty(), empty()
    add_points(rows(kept), 1.0, CELL, table)
    add_points(rows(gone), 1.0, CELL, table)
    add_points(rows(gone), -1.0, CELL, table)
    add_points(rows(kept), 1.0, CELL, only)
    np.testing.assert_allclose(table.sums, only.sums, atol=1e-9)


def test_cells_that_share_a_place_are_told_apart():
    table = empty()
    far = rows([(0.05 + SIDE * CELL, 0.05, 0.0)])
    add_points(rows([(0.05, 0.05, 0.0)]), 1.0, CELL, table)
    add_points(far, 1.0, CELL, table)
    beams, nearby = np.zeros((1, 7)), NearestPoints(np.empty((1, 2)), np.empty(1, np.int64))
    beams[0, :3] = 0.05, 0.05, 1.0
    assert find_surfels(0.0, 0.0, 0.0, beams, 0.2, CELL, table, nearby) == 0
    assert find_surfels(SIDE * CELL, 0.0, 0.0, beams, 0.2, CELL, table, nearby) == 1
    add_points(rows([(0.05, 0.05, 0.0)]), -1.0, CELL, table)  # the place is not its own any more
    assert find_surfels(SIDE * CELL, 0.0, 0.0, beams, 0.2, CELL, table, nearby) == 1
