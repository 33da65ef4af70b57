"""The movers' kernels against slow, plain references."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cepa.kernels import movers as kernels

ALL_AROUND = np.full(360, 9.0)
LEVEL = np.full(360, math.inf)
AT_ORIGIN = np.zeros(3)


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


@pytest.mark.parametrize("seed", range(5))
def test_segments_are_those_of_the_plain_reference(seed):
    points = scan_of_arcs(np.random.default_rng(seed))
    clusters, labels = np.empty((200, kernels.CLUSTER_COLUMNS)), np.empty(len(points), np.int64)
    count = kernels.segment(points, AT_ORIGIN, ALL_AROUND, LEVEL, 0.3, 3, math.inf, clusters, labels)
    expected = plain_segments(points, 0.3, 3)
    assert count == len(expected)
    for c, segment in enumerate(expected):
        assert sorted(np.flatnonzero(labels == c)) == sorted(segment)
        middle = 0.5 * (points[segment[0]] + points[segment[-1]])
        radius = np.linalg.norm(points[segment] - middle, axis=1).max()
        found = clusters[c, [kernels.MIDDLE_X, kernels.MIDDLE_Y, kernels.SIZE]]
        assert found == pytest.approx([*middle, radius])


def test_a_large_thing_has_no_label():
    wall = np.stack([np.full(60, 2.0), np.linspace(-3.0, 3.0, 60)], axis=1)
    clusters, labels = np.empty((9, kernels.CLUSTER_COLUMNS)), np.empty(60, np.int64)
    assert kernels.segment(wall, AT_ORIGIN, ALL_AROUND, LEVEL, 0.3, 3, 1.5, clusters, labels) == 0
    assert (labels == -1).all()


def test_what_something_nearer_hides_is_marked():
    # Given a trunk whose right end is behind another one, and the edge of the lidar's view at its left
    near = np.stack([np.full(10, 1.0), np.linspace(-0.2, 0.0, 10)], axis=1)
    far = np.stack([np.full(10, 4.0), np.linspace(0.05, 0.5, 10)], axis=1)
    points = np.concatenate((near, far))
    bins = ALL_AROUND.copy()
    clusters, labels = np.empty((9, kernels.CLUSTER_COLUMNS)), np.empty(20, np.int64)
    kernels.segment(points, AT_ORIGIN, bins, LEVEL, 0.3, 3, 1.5, clusters, labels)
    assert list(clusters[:2, kernels.HIDDEN]) == [0.0, 1.0]
    bins[-20:-10] = -1.0  # the near trunk's right end is at -11 degrees
    kernels.segment(points, AT_ORIGIN, bins, LEVEL, 0.3, 3, 1.5, clusters, labels)
    assert clusters[0, kernels.HIDDEN] == 1.0


def test_the_filter_is_a_kalman_filter_of_constant_velocity():
    rng = np.random.default_rng(3)
    dt, acceleration, deviation = 0.025, 0.6, 0.05
    track = np.zeros((1, kernels.TRACK_COLUMNS))
    track[0, [kernels.PP, kernels.VV]] = 0.0025, 1.0
    track[0, [kernels.RADIUS, kernels.USUAL]] = 0.3
    f = np.array([[1.0, dt], [0.0, 1.0]])
    noise = acceleration**2 * dt * np.array([[dt**2 / 3.0, dt / 2.0], [dt / 2.0, 1.0]])
    mean, covariance = np.zeros((2, 2)), np.diag([0.0025, 1.0])  # rows: position and velocity; columns: axes
    for step in range(40):
        measured = np.array([1.0, -0.5]) * step * dt + rng.normal(0.0, 0.03, 2)
        cluster = np.zeros((1, kernels.CLUSTER_COLUMNS))
        cluster[0, [kernels.MIDDLE_X, kernels.MIDDLE_Y]], cluster[0, kernels.SIZE] = measured, 0.3
        kernels.predict(track, dt, acceleration)
        kernels.correct(track, cluster, np.zeros(1, np.int64), deviation, 0.3, 1.0, 0.2)
        mean, covariance = f @ mean, f @ covariance @ f.T + noise
        gain = covariance[:, 0] / (covariance[0, 0] + deviation**2)
        mean = mean + np.outer(gain, measured - mean[0])
        covariance = covariance - np.outer(gain, covariance[0])
    columns = [kernels.X, kernels.Y, kernels.VX, kernels.VY, kernels.PP, kernels.PV, kernels.VV]
    assert track[0, columns] == pytest.approx([*mean.ravel(), *covariance.ravel()[[0, 1, 3]]])


@pytest.mark.parametrize("tilted", [False, True])
def test_a_part_of_a_thing_moves_its_track_only_if_the_lidar_is_level(tilted):
    # Given a wide thing that moves along x, of which a scan shows only the left half
    track, cluster = np.zeros((1, kernels.TRACK_COLUMNS)), np.zeros((1, kernels.CLUSTER_COLUMNS))
    track[0, [kernels.VX, kernels.PP, kernels.VV]] = -2.0, 0.01, 0.1
    track[0, [kernels.RADIUS, kernels.USUAL, kernels.UNSEEN]] = 0.9, 0.9, 0.025
    before = track.copy()
    half = [kernels.MIDDLE_Y, kernels.SIZE, kernels.TILTED]
    cluster[0, half] = 0.45, 0.45, float(tilted)
    kernels.correct(track, cluster, np.zeros(1, np.int64), 0.05, 0.3, 1.0, 0.2)
    if tilted:
        before[0, kernels.UNSEEN] = 0.0
        assert track == pytest.approx(before)
    else:
        assert track[0, kernels.Y] == pytest.approx(0.45)


def test_a_long_side_that_goes_out_of_sight_does_not_change_the_velocity():
    # Given a lorry of 4.5 m by 1.8 m that drives on at 1 m/s
    dt, owners = 0.025, np.zeros(1, np.int64)
    track, cluster = np.zeros((1, kernels.TRACK_COLUMNS)), np.zeros((1, kernels.CLUSTER_COLUMNS))
    track[0, [kernels.VX, kernels.PP, kernels.VV]] = 1.0, 0.03**2, 0.25**2
    track[0, [kernels.PV, kernels.RADIUS, kernels.USUAL]] = 0.005, 2.4, 2.4
    # When its front alone stays in sight, within 0.25 s
    for step in range(20):
        side_m = max(4.5 - 0.45 * step, 0.0)
        cluster[0, kernels.MIDDLE_X] = (step + 1) * dt + (4.5 - side_m) / 2.0
        cluster[0, kernels.SIZE] = math.hypot(side_m, 1.8) / 2.0
        kernels.predict(track, dt, 0.6)
        kernels.correct(track, cluster, owners, 0.05, 0.3, 0.98, 0.15)
    # Then its place is the front's, and its velocity as before
    assert track[0, kernels.X] == pytest.approx(20 * dt + 2.25)
    assert track[0, kernels.VX] == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize(("evidence_s", "place_m"), [(0.0, 1.0), (0.1, 0.0)])
def test_a_part_within_the_circle_of_what_moves_does_not_shift_it(evidence_s, place_m):
    track, cluster = np.zeros((1, kernels.TRACK_COLUMNS)), np.zeros((1, kernels.CLUSTER_COLUMNS))
    track[0, [kernels.PP, kernels.RADIUS, kernels.USUAL]] = 0.03**2, 2.4, 2.4
    track[0, kernels.EVIDENCE] = evidence_s
    cluster[0, [kernels.MIDDLE_X, kernels.SIZE]] = 1.0, 0.9
    kernels.correct(track, cluster, np.zeros(1, np.int64), 0.05, 0.3, 0.98, 0.15)
    assert track[0, kernels.X] == place_m


def test_beams_far_from_level_at_the_end_of_a_thing_are_marked():
    wall = np.stack([np.full(30, 2.0), np.linspace(-0.5, 0.5, 30)], axis=1)
    clusters, labels = np.empty((9, kernels.CLUSTER_COLUMNS)), np.empty(30, np.int64)
    for level_m, expected in ((2.2, 0.0), (1.9, 1.0)):
        level = np.full(360, level_m)
        kernels.segment(wall, AT_ORIGIN, ALL_AROUND, level, 0.3, 3, 1.5, clusters, labels)
        assert clusters[0, kernels.TILTED] == expected


@pytest.mark.parametrize("seed", range(5))
def test_pairs_are_each_others_nearest(seed):
    rng = np.random.default_rng(seed)
    clusters, tracks = np.zeros((20, kernels.CLUSTER_COLUMNS)), np.zeros((25, kernels.TRACK_COLUMNS))
    clusters[:, [kernels.MIDDLE_X, kernels.MIDDLE_Y]] = rng.uniform(0.0, 3.0, (20, 2))
    tracks[:, [kernels.X, kernels.Y]] = rng.uniform(0.0, 3.0, (25, 2))
    matches, owners = np.empty(20, np.int64), np.empty(25, np.int64)
    kernels.associate(clusters, tracks, 0.4, matches, owners)
    distances = np.linalg.norm(
        clusters[:, None, [kernels.MIDDLE_X, kernels.MIDDLE_Y]] - tracks[None, :, [kernels.X, kernels.Y]],
        axis=2,
    )
    nearest = np.where(distances.min(axis=1) < 0.4, distances.argmin(axis=1), -1)
    for t in range(25):
        candidates = [c for c in range(20) if nearest[c] == t]
        assert owners[t] == (min(candidates, key=lambda c: distances[c, t]) if candidates else -1)
    for c in range(20):
        assert matches[c] == (nearest[c] if nearest[c] >= 0 and owners[nearest[c]] == c else -1)


@pytest.mark.parametrize("seed", range(20))
def test_a_place_is_free_if_all_directions_near_it_are(seed):
    rng = np.random.default_rng(seed)
    bins = rng.choice([-1.0, 2.0, 9.0], 360, p=[0.01, 0.02, 0.97])
    turn, place = rng.uniform(-3.0, 3.0), rng.uniform(-5.0, 5.0, 2)
    distance, gap = float(np.hypot(*place)), 0.2
    centres = turn + np.arange(360) * 2.0 * math.pi / 360
    off = np.abs(np.angle(np.exp(1j * (centres - math.atan2(place[1], place[0])))))
    needed = 0.5 * gap / distance + kernels.HEADING_ERROR_RAD
    free = kernels._is_free(*place, 0.0, 0.0, turn, bins, gap)
    bin_rad = 2.0 * math.pi / 360
    # Bins are whole: what is nearer than asked for must agree, what is 2.5 bins farther must not matter
    if free:
        assert (bins[off <= needed] >= distance + gap).all()
    if (bins[off <= needed + 2.5 * bin_rad] >= distance + gap).all():
        assert free


def standing(rng, count=12):
    """Return tracks at random places, and the clusters of a scan that sees them without an error."""
    tracks, clusters = np.zeros((count, kernels.TRACK_COLUMNS)), np.zeros((count, kernels.CLUSTER_COLUMNS))
    places = rng.uniform(-8.0, 8.0, (count, 2))
    tracks[:, [kernels.X, kernels.Y]] = clusters[:, [kernels.MIDDLE_X, kernels.MIDDLE_Y]] = places
    return tracks, clusters


def test_the_alignment_finds_the_drift_in_spite_of_one_that_moves():
    rng = np.random.default_rng(4)
    tracks, clusters = standing(rng)
    pose, turn, shift = np.array([0.5, -0.3, 0.0]), 0.01, np.array([0.03, -0.02])
    c, s = math.cos(turn), math.sin(turn)
    places = clusters[:, [kernels.MIDDLE_X, kernels.MIDDLE_Y]]
    # Given a scan that is turned and shifted by the odometry's error, and one thing that went on by 0.5 m
    clusters[:, [kernels.MIDDLE_X, kernels.MIDDLE_Y]] = (places - pose[:2] - shift) @ np.array(
        [[c, -s], [s, c]]
    )
    clusters[:, [kernels.MIDDLE_X, kernels.MIDDLE_Y]] += pose[:2]
    clusters[0, kernels.MIDDLE_X] += 0.5
    motion = np.empty(3)
    known = np.arange(12), np.zeros(12, bool), pose
    assert kernels.align(clusters, tracks, *known, 0.025, 4, motion)
    assert motion == pytest.approx([*shift, turn], abs=0.005)


def test_too_few_standing_things_tell_no_drift():
    tracks, clusters = standing(np.random.default_rng(5), 3)
    clusters[:, kernels.MIDDLE_X] += 0.1
    motion = np.empty(3)
    known = np.arange(3), np.zeros(3, bool), AT_ORIGIN
    assert not kernels.align(clusters, tracks, *known, 0.025, 4, motion)
    assert (motion == 0.0).all()
