"""The movers' kernels against slow, plain references."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cepa.dynamic.obstacle_tracks.kernels import columns
from cepa.dynamic.obstacle_tracks.kernels.clusters import placed
from cepa.dynamic.obstacle_tracks.kernels.drift import align
from cepa.dynamic.obstacle_tracks.kernels.evidence import HEADING_ERROR_RAD, _is_free
from cepa.dynamic.obstacle_tracks.kernels.sides import (
    SIDES_AGREE,
    SIDES_DAMPING,
    SIDES_NEW_M,
    SIDES_OUTLIER_M,
    shift_of,
)
from cepa.dynamic.obstacle_tracks.kernels.tracks import _hold, are_fast, associate, correct, predict, weigh

ANY = np.array([[-math.inf] * 3, [math.inf] * 3])
AT_ORIGIN = np.zeros(3)
ENDS = [columns.CUT_FIRST, columns.CUT_LAST]


def plain_shift(reaches, track):
    """Return the damped least squares of what the sides say; from round to round outliers count less.

    In a last round those that contradict the others do not count at all. Returns them, too.
    """
    off = reaches - track[columns.REACH :] - columns.NORMALS @ track[[columns.X, columns.Y]]
    shift, new = np.zeros(2), np.zeros(len(reaches), bool)
    for last in (False, False, False, True):
        rest = off - columns.NORMALS @ shift
        if last and np.sum(np.abs(rest) < SIDES_OUTLIER_M) >= SIDES_AGREE:
            new = np.abs(rest) > SIDES_NEW_M
        if not last or new.any():
            used = ~np.isnan(off) & ~new
            normals, weights = columns.NORMALS[used], 1.0 / (1.0 + (rest[used] / SIDES_OUTLIER_M) ** 2)
            damped = SIDES_DAMPING * np.eye(2) + (weights * normals.T) @ normals
            shift = np.linalg.solve(damped, normals.T @ (weights * off[used]))
    return shift, np.sum(~np.isnan(off) & ~new), new


@pytest.mark.table("seed", range(20))
def test_sides_tell_how_far_a_thing_is_from_its_track(seed):
    rng = np.random.default_rng(seed)
    track, shift, new = rng.normal(size=columns.TRACK_COLUMNS), np.empty(2), np.empty(16, bool)
    reaches = track[columns.REACH :] + columns.NORMALS @ (track[[columns.X, columns.Y]] + (0.04, -0.03))
    reaches[4 + rng.integers(4) :] = math.nan
    reaches[rng.integers(4)] += rng.choice([0.0, 0.15, 0.5])  # another thing has come near there
    known = shift_of(reaches, track, shift, new)
    expected, expected_known, expected_new = plain_shift(reaches, track)
    assert known == expected_known
    assert shift == pytest.approx(expected)
    np.testing.assert_array_equal(new, expected_new)


def test_a_side_that_contradicts_the_others_tells_nothing():
    # Given a thing that is 0.1 m farther along x, and of which 0.8 m more are in sight on one side
    track, shift, new = np.zeros(columns.TRACK_COLUMNS), np.empty(2), np.empty(16, bool)
    reaches = 0.1 * columns.NORMALS[:, 0]
    reaches[9:], reaches[4] = math.nan, 0.8
    assert shift_of(reaches, track, shift, new) == 8
    assert np.flatnonzero(new).tolist() == [4]
    assert shift == pytest.approx((0.1, 0.0), abs=0.01)


def test_sides_that_all_disagree_are_kept():
    track, shift, new = np.zeros(columns.TRACK_COLUMNS), np.empty(2), np.empty(16, bool)
    reaches = np.full(16, math.nan)
    reaches[[0, 4]] = 0.9, -0.9
    assert shift_of(reaches, track, shift, new) == 2
    assert not new.any()


def test_the_filter_is_a_kalman_filter_of_constant_velocity():
    rng = np.random.default_rng(3)
    dt, acceleration, deviation = 0.025, 0.6, 0.05
    track = np.zeros((1, columns.TRACK_COLUMNS))
    track[0, [columns.PP, columns.VV]] = 0.0025, 1.0
    track[0, columns.RADIUS], track[0, columns.REACH :] = 9.0, math.nan
    f = np.array([[1.0, dt], [0.0, 1.0]])
    noise = acceleration**2 * dt * np.array([[dt**2 / 3.0, dt / 2.0], [dt / 2.0, 1.0]])
    mean, covariance = np.zeros((2, 2)), np.diag([0.0025, 1.0])  # rows: position and velocity; columns: axes
    for step in range(40):
        # Given a thing of which no side is known, so that its middle counts
        measured = np.array([1.0, -0.5]) * step * dt + rng.normal(0.0, 0.03, 2)
        cluster = np.zeros((1, columns.CLUSTER_COLUMNS))
        cluster[0, [columns.MIDDLE_X, columns.MIDDLE_Y]], cluster[0, columns.END] = measured, 1
        cluster[0, ENDS] = columns.HIDDEN
        predict(track, dt, acceleration)
        scan = cluster, np.zeros(1, np.int64), measured[None], AT_ORIGIN
        correct(track, *scan, 9.0, deviation, 1.0, 0.2)
        mean, covariance = f @ mean, f @ covariance @ f.T + noise
        gain = covariance[:, 0] / (covariance[0, 0] + deviation**2)
        mean = mean + np.outer(gain, measured - mean[0])
        covariance = covariance - np.outer(gain, covariance[0])
    state = [columns.X, columns.Y, columns.VX, columns.VY, columns.PP, columns.PV, columns.VV]
    assert track[0, state] == pytest.approx([*mean.ravel(), *covariance.ravel()[[0, 1, 3]]])


@pytest.mark.table("seed", range(5))
def test_a_disc_holds_what_is_left_of_it_and_the_cluster(seed):
    rng = np.random.default_rng(seed)
    for _ in range(50):
        track, cluster = np.zeros(columns.TRACK_COLUMNS), np.zeros(columns.CLUSTER_COLUMNS)
        track[: columns.VX], track[columns.RADIUS] = rng.normal(size=2), rng.uniform(0.1, 2.0)
        cluster[[columns.MIDDLE_X, columns.MIDDLE_Y]] = rng.normal(size=2)
        cluster[columns.SIZE] = rng.uniform(0.1, 2.0)
        before, sides = track.copy(), columns.NORMALS @ track[: columns.VX] + track[columns.REACH :]
        _hold(track, cluster, 0.9)
        old, new = before[: columns.VX], track[: columns.VX]
        seen, size = cluster[[columns.MIDDLE_X, columns.MIDDLE_Y]], cluster[columns.SIZE]
        left, radius = 0.9 * before[columns.RADIUS], track[columns.RADIUS]
        assert np.hypot(*(old - new)) + left <= radius + 1e-9
        assert np.hypot(*(seen - new)) + size <= radius + 1e-9
        assert radius == pytest.approx(max(left, size, (left + size + np.hypot(*(seen - old))) / 2.0))
        assert columns.NORMALS @ new + track[columns.REACH :] == pytest.approx(sides)  # they stay in place


@pytest.mark.table("tilted", [False, True])
def test_a_part_of_a_thing_is_a_side_only_if_the_lidar_is_level(tilted):
    # Given a side of 1.8 m that stood 3 m ahead, of which a scan shows only the left half
    points = np.column_stack((np.full(46, 3.0), np.linspace(0.0, 0.9, 46)))
    track, cluster = np.zeros((1, columns.TRACK_COLUMNS)), np.zeros((1, columns.CLUSTER_COLUMNS))
    track[0, [columns.X, columns.PP, columns.RADIUS]] = 3.0, 0.01, 0.9
    track[0, columns.EVIDENCE] = 0.1
    to_the_right = 9  # in columns.NORMALS: 22.5 degrees from the lidar's direction, to the thing's right end
    track[0, columns.REACH :] = math.nan
    track[0, columns.REACH + to_the_right] = 0.9 * math.sin(math.pi / 8)
    cluster[0, [columns.MIDDLE_X, columns.MIDDLE_Y, columns.SIZE, columns.END]] = 3.0, 0.45, 0.45, 46
    cluster[0, columns.CUT_FIRST] = columns.TILTED if tilted else columns.NOT_CUT
    correct(track, cluster, np.zeros(1, np.int64), points, AT_ORIGIN, 0.05, 0.3, 1.0, 0.2)
    assert (track[0, columns.Y] == 0.0) == tilted


@pytest.mark.table("seed", range(5))
def test_pairs_are_each_others_nearest(seed):
    rng = np.random.default_rng(seed)
    clusters, tracks = np.zeros((20, columns.CLUSTER_COLUMNS)), np.zeros((25, columns.TRACK_COLUMNS))
    clusters[:, [columns.MIDDLE_X, columns.MIDDLE_Y]] = rng.uniform(0.0, 3.0, (20, 2))
    tracks[:, [columns.X, columns.Y]] = rng.uniform(0.0, 3.0, (25, 2))
    matches, owners = np.empty(20, np.int64), np.empty(25, np.int64)
    associate(clusters, tracks, 0.4, np.zeros(len(tracks), bool), matches, owners)
    distances = np.linalg.norm(
        clusters[:, None, [columns.MIDDLE_X, columns.MIDDLE_Y]] - tracks[None, :, [columns.X, columns.Y]],
        axis=2,
    )
    nearest = np.where(distances.min(axis=1) < 0.4, distances.argmin(axis=1), -1)
    for t in range(25):
        candidates = [c for c in range(20) if nearest[c] == t]
        assert owners[t] == (min(candidates, key=lambda c: distances[c, t]) if candidates else -1)
    for c in range(20):
        assert matches[c] == (nearest[c] if nearest[c] >= 0 and owners[nearest[c]] == c else -1)


@pytest.mark.table("seed", range(20))
def test_a_place_is_free_if_all_directions_near_it_are(seed):
    rng = np.random.default_rng(seed)
    bins = rng.choice([-1.0, 2.0, 9.0], 360, p=[0.01, 0.02, 0.97])
    turn, place = rng.uniform(-3.0, 3.0), rng.uniform(-5.0, 5.0, 2)
    distance, gap = float(np.hypot(*place)), 0.2
    centres = turn + np.arange(360) * 2.0 * math.pi / 360
    off = np.abs(np.angle(np.exp(1j * (centres - math.atan2(place[1], place[0])))))
    needed = 0.5 * gap / distance + HEADING_ERROR_RAD
    free = _is_free(*place, 0.0, 0.0, turn, bins, gap)
    bin_rad = 2.0 * math.pi / 360
    # Bins are whole: what is nearer than asked for must agree, what is 2.5 bins farther must not matter
    if free:
        assert (bins[off <= needed] >= distance + gap).all()
    if (bins[off <= needed + 2.5 * bin_rad] >= distance + gap).all():
        assert free


def rotated(points, turn):
    c, s = math.cos(turn), math.sin(turn)
    return points @ np.array([[c, s], [-s, c]])


def test_what_counts_is_laid_without_the_drift():
    rng = np.random.default_rng(6)
    points, counts, corrected = rng.normal(size=(9, 3)), rng.random(9) < 0.6, np.empty((9, 2))
    count = placed(points, counts, 3.0, -1.0, 0.2, 0.05, -0.02, corrected)
    expected = rotated(points[counts, :2] + np.array((3.0, -1.0)), 0.2)
    np.testing.assert_allclose(corrected[:count] - (0.05, -0.02), expected, atol=1e-12)


@pytest.mark.table("seed", range(5))
def test_evidence_grows_and_falls_and_tells_what_moves(seed):
    rng = np.random.default_rng(seed)
    tracks, owners = rng.uniform(0.0, 1.0, (60, columns.TRACK_COLUMNS)), rng.integers(-1, 3, 60)
    tracks[:, columns.EVIDENCE] *= rng.integers(0, 2, 60) * 0.3
    speeds, evidence = np.hypot(*tracks[:, [columns.VX, columns.VY]].T), tracks[:, columns.EVIDENCE].copy()
    fast = np.empty(60, np.bool_)
    are_fast(tracks, owners, 0.35, 1.2, fast)
    slowest = np.maximum(0.35, 1.2 * np.sqrt(tracks[:, columns.VV]))
    np.testing.assert_array_equal(fast, (owners >= 0) & (speeds > slowest))
    shown, moving = fast & (rng.random(60) < 0.5), rng.random(60) < 0.3
    change = np.select([owners < 0, shown, fast], [0.0, 1.0, -0.1], -0.5)
    expected = np.clip(evidence + 0.1 * change, 0.0, 0.25)
    goes_on = ((expected > 0.07) & (speeds > 0.35)) | (moving & (expected > 0.0))
    weigh(tracks, owners, fast, shown, 0.1, (0.1, 0.5), 0.07, 0.25, 0.35, moving)
    np.testing.assert_allclose(tracks[:, columns.EVIDENCE], expected, atol=1e-15)
    np.testing.assert_array_equal(moving, goes_on)


def standing(rng, count=12):
    """Return tracks of corners at random places, and points and clusters of a scan that sees them exactly."""
    tracks, clusters = np.zeros((count, columns.TRACK_COLUMNS)), np.zeros((count, columns.CLUSTER_COLUMNS))
    places = rng.uniform(-8.0, 8.0, (count, 2))
    tracks[:, [columns.X, columns.Y]] = clusters[:, [columns.MIDDLE_X, columns.MIDDLE_Y]] = places
    clusters[:, [columns.FIRST, columns.END]] = np.arange(count)[:, None] + (0, 1)
    return tracks, clusters, places.copy()


def test_the_alignment_finds_the_drift_in_spite_of_one_that_moves():
    rng = np.random.default_rng(4)
    tracks, clusters, places = standing(rng)
    pose, turn, shift = np.array([0.5, -0.3, 0.0]), 0.01, np.array([0.03, -0.02])
    c, s = math.cos(turn), math.sin(turn)
    # Given a scan that is turned and shifted by the odometry's error, and one thing that went on by 0.5 m
    points = (places - pose[:2] - shift) @ np.array([[c, -s], [s, c]]) + pose[:2]
    points[0, 0] += 0.5
    clusters[:, [columns.MIDDLE_X, columns.MIDDLE_Y]] = points
    motion, before, lidar = np.empty(3), points.copy(), pose[:2].copy()
    known = np.arange(12), np.zeros(12, bool), points, pose
    assert align(clusters, tracks, *known, 0.025, 4, ANY, motion)
    assert motion == pytest.approx([*shift, turn], abs=0.005)
    placed = rotated(before - lidar, motion[2]) + lidar + motion[:2]
    np.testing.assert_allclose(points, placed, atol=1e-12)
    np.testing.assert_allclose(clusters[:, [columns.MIDDLE_X, columns.MIDDLE_Y]], placed, atol=1e-12)
    np.testing.assert_allclose(pose, [*(lidar + motion[:2]), motion[2]], atol=1e-12)


def test_too_few_standing_things_tell_no_drift():
    tracks, clusters, points = standing(np.random.default_rng(5), 3)
    points[:, 0] += 0.1
    motion = np.empty(3)
    known = np.arange(3), np.zeros(3, bool), points, AT_ORIGIN
    assert not align(clusters, tracks, *known, 0.025, 4, ANY, motion)
    assert (motion == 0.0).all()
