"""Clusters of a planar scan, against a slow, plain reference and the shape of a box."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cepa.dynamic.obstacle_tracks.kernels import columns
from cepa.dynamic.obstacle_tracks.kernels.clusters import segment
from cepa.dynamic.obstacle_tracks.kernels.sides import GRAZING_SINE, reaches_of

ALL_AROUND = np.full(360, 9.0)
LEVEL = np.full(360, math.inf)
AT_ORIGIN = np.zeros(3)
ENDS = [columns.CUT_FIRST, columns.CUT_LAST]


def scan_of_arcs(rng):
    """Points (n, 2) around the origin in the order of their beams, at ranges that jump now and then."""
    angles = np.sort(rng.uniform(-math.pi, math.pi, 300))
    ranges = np.repeat(rng.uniform(1.0, 9.0, 30), 10) + rng.normal(0.0, 0.01, 300)
    return ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def plain_segments(points, gap, least):
    """Return the segments as lists of indices: neighbours on the circle of points stay together."""
    n = len(points)
    apart = [np.linalg.norm(points[k] - points[k - 1]) > gap for k in range(n)]
    segments = []
    for start in [k for k in range(n) if apart[k]]:
        segment = [start]
        while not apart[(segment[-1] + 1) % n]:
            segment.append((segment[-1] + 1) % n)
        segments.append(segment)
    return [segment for segment in segments if len(segment) >= least]


@pytest.mark.table("seed", range(5))
def test_segments_are_those_of_the_plain_reference(seed):
    points = scan_of_arcs(np.random.default_rng(seed))
    clusters, labels = np.empty((200, columns.CLUSTER_COLUMNS)), np.empty(len(points), np.int64)
    count = segment(points, AT_ORIGIN, ALL_AROUND, LEVEL, 0.3, 3, math.inf, clusters, labels)
    expected = plain_segments(points, 0.3, 3)
    assert count == len(expected)
    for c, members in enumerate(expected):
        assert sorted(np.flatnonzero(labels == c)) == sorted(members)
        middle = 0.5 * (points[members[0]] + points[members[-1]])
        radius = np.linalg.norm(points[members] - middle, axis=1).max()
        found = clusters[c, [columns.MIDDLE_X, columns.MIDDLE_Y, columns.SIZE]]
        assert found == pytest.approx([*middle, radius])


def test_a_large_thing_has_no_label():
    wall = np.stack([np.full(60, 2.0), np.linspace(-3.0, 3.0, 60)], axis=1)
    clusters, labels = np.empty((9, columns.CLUSTER_COLUMNS)), np.empty(60, np.int64)
    assert segment(wall, AT_ORIGIN, ALL_AROUND, LEVEL, 0.3, 3, 1.5, clusters, labels) == 0
    assert (labels == -1).all()


def test_what_something_nearer_hides_is_marked():
    # Given a trunk whose right end is behind another one, and the edge of the lidar's view at its left
    near = np.stack([np.full(10, 1.0), np.linspace(-0.2, 0.0, 10)], axis=1)
    far = np.stack([np.full(10, 4.0), np.linspace(0.05, 0.5, 10)], axis=1)
    points = np.concatenate((near, far))
    bins = ALL_AROUND.copy()
    clusters, labels = np.empty((9, columns.CLUSTER_COLUMNS)), np.empty(20, np.int64)
    segment(points, AT_ORIGIN, bins, LEVEL, 0.3, 3, 1.5, clusters, labels)
    assert clusters[0, ENDS] == pytest.approx([columns.NOT_CUT, columns.NOT_CUT])
    assert clusters[1, ENDS] == pytest.approx([columns.HIDDEN, columns.NOT_CUT])
    bins[-20:-10] = -1.0  # the near trunk's right end is at -11 degrees
    segment(points, AT_ORIGIN, bins, LEVEL, 0.3, 3, 1.5, clusters, labels)
    assert clusters[0, ENDS] == pytest.approx([columns.HIDDEN, columns.NOT_CUT])


def sides_of_a_box(angle, lidar, corners, middle):
    """Return points (n, 2) every 2 cm on the sides of a box that ``lidar`` (2,) sees, in order of beams."""
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    corners = middle + corners @ turn.T
    points = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        along = b - a
        if along[0] * (lidar - a)[1] - along[1] * (lidar - a)[0] < 0.0:
            points.append(a + np.linspace(0.0, 1.0, round(np.hypot(*along) / 0.02))[:, None] * along)
    points = np.concatenate(points)
    towards = middle - lidar
    off = points - lidar
    turns = np.arctan2(towards[0] * off[:, 1] - towards[1] * off[:, 0], off @ towards)
    return points[np.argsort(turns)], corners


LORRY = np.array([(2.25, 0.9), (-2.25, 0.9), (-2.25, -0.9), (2.25, -0.9)])
"""Its corners, counter-clockwise."""


@pytest.mark.table("seed", range(20))
def test_a_box_is_measured_where_the_lidar_stands_before_it(seed):
    rng = np.random.default_rng(seed)
    lidar, middle = rng.uniform(-1.0, 1.0, 2), rng.uniform(3.0, 5.0, 2)
    points, corners = sides_of_a_box(rng.uniform(0.0, 6.0), lidar, LORRY, middle)
    cluster, reaches = np.zeros(columns.CLUSTER_COLUMNS), np.empty(16)
    cluster[columns.END] = len(points)
    reaches_of(points, cluster, np.array([*lidar, 0.0]), columns.HIDDEN, reaches)
    for normal, reach in zip(columns.NORMALS, reaches):
        corner = corners[np.argmax(corners @ normal)]
        grazing = (lidar - corner) @ normal / np.hypot(*(lidar - corner))
        if abs(grazing - GRAZING_SINE) > 0.02:
            assert np.isnan(reach) == (grazing < GRAZING_SINE)
        if not np.isnan(reach):
            assert reach == pytest.approx(corner @ normal, abs=0.02)
    # Where an end is cut off, no side near it is measured
    cluster[columns.CUT_FIRST] = columns.HIDDEN
    cut = np.empty(16)
    reaches_of(points, cluster, np.array([*lidar, 0.0]), columns.HIDDEN, cut)
    near = np.hypot(*(corners[np.argmax(corners @ columns.NORMALS.T, axis=0)] - points[0]).T) < 0.25
    assert np.isnan(cut[near]).all()
    assert np.array_equal(cut[~np.isnan(cut)], reaches[~np.isnan(cut)])


def test_beams_far_from_level_at_the_end_of_a_thing_are_marked():
    wall = np.stack([np.full(30, 2.0), np.linspace(-0.5, 0.5, 30)], axis=1)
    clusters, labels = np.empty((9, columns.CLUSTER_COLUMNS)), np.empty(30, np.int64)
    for level_m, expected in ((2.2, columns.NOT_CUT), (1.9, columns.TILTED)):
        level = np.full(360, level_m)
        segment(wall, AT_ORIGIN, ALL_AROUND, level, 0.3, 3, 1.5, clusters, labels)
        assert (clusters[0, ENDS] == expected).all()
