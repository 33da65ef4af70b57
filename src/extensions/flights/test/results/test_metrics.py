"""Metrics of a flight against closed forms."""

import math

import numpy as np
import pytest

from flights.flight.flight_log import FlightLog, Series
from flights.results import clearance, metrics


def poses_along(points_xyz, times=None):
    poses = np.zeros((len(points_xyz), 8))
    poses[:, 0] = np.arange(len(points_xyz)) * 0.01 if times is None else times
    poses[:, 1:4] = points_xyz
    poses[:, 7] = 1.0
    return poses


def test_the_length_of_a_helix():
    angle = np.linspace(0, 4 * math.pi, 4001)
    helix = np.column_stack((3 * np.cos(angle), 3 * np.sin(angle), 0.5 * angle))
    assert metrics.path_length_m(helix) == pytest.approx(4 * math.pi * math.hypot(3, 0.5), rel=1e-6)


def test_a_path_of_one_point_has_no_length():
    assert metrics.path_length_m(np.zeros((1, 3))) == 0.0
    assert metrics.path_length_m(np.zeros((0, 3))) == 0.0


def test_statistics_of_known_values():
    found = metrics.statistics_of(np.arange(101.0))
    assert found == {"mean": 50.0, "median": 50.0, "p99": 99.0, "max": 100.0, "count": 101}
    assert metrics.statistics_of([math.nan, 2.0])["count"] == 1
    assert metrics.statistics_of([]) is None


def test_thinning_keeps_the_ends_and_the_spacing():
    poses = poses_along(np.column_stack((np.linspace(0, 1, 1001), np.zeros(1001), np.zeros(1001))))
    kept = clearance.thinned(poses, 0.0105)
    assert (kept[0] == poses[0]).all()
    assert (kept[-1] == poses[-1]).all()
    steps = np.diff(kept[:, 1])
    assert steps[:-1].min() >= 0.0105
    assert steps.max() <= 0.0105 + 0.001


def test_clearance_is_asked_at_every_pose_in_order():
    poses = poses_along([(0, 0, 2), (1, 0, 2), (2, 0, 2)])
    told = []
    distances = clearance.measured(
        lambda time_s, pose: 5.0 - pose.position_m[0], poses, lambda *done: told.append(done)
    )
    assert distances.tolist() == [5.0, 4.0, 3.0]
    assert told == [(0, 3)]


def test_a_series_leaves_out_repetitions_and_refuses_misfits():
    series = Series(("t_s", "value"))
    for row in ((0.0, 1), (0.1, 2), (0.1, 3), (0.05, 4), (0.2, 5)):
        series.add(*row)
    assert series.array("t_s", "value").tolist() == [[0.0, 1.0], [0.1, 2.0], [0.2, 5.0]]
    with pytest.raises(ValueError, match="a row has 2 values"):
        series.add(1.0)


def test_speed_of_a_circle():
    log = FlightLog()
    for step in range(1000):
        t = 0.01 * step
        log.truth.add(t, 2 * math.cos(t), 2 * math.sin(t), 2.0, 0.0, 0.0, 0.0, 1.0)
    speeds = log.speeds()
    # A chord of the circle stands for the arc: sin(0.05) / 0.05 of it
    assert speeds[20:-20, 1] == pytest.approx(2.0 * math.sin(0.05) / 0.05, rel=1e-6)


def test_lidar_hits_lie_where_the_wall_is():
    """A UAV at (1, 2) turned by 90 degrees, its lidar 0.1 m ahead, sees a wall at y = 5 across its way."""
    log = FlightLog()
    log.truth.add(1.0, 1.0, 2.0, 2.0, 0.0, 0.0, math.sin(math.pi / 4), math.cos(math.pi / 4))
    angles = np.linspace(-0.5, 0.5, 11)
    log.add_scan(1.0, 2.9 / np.cos(angles), angles[0], angles[1] - angles[0])
    log.add_scan(1.1, np.full(11, 1.0), -0.5, 0.1)  # too soon after the last one kept
    log.add_scan(2.0, np.full(11, 1.0), -0.5, 0.1)  # without a pose of its stamp
    hits = log.hits((0.1, 0.0, 0.05))
    assert hits.shape == (11, 4)
    assert hits[:, 2] == pytest.approx(5.0, abs=1e-6)
    assert hits[:, 1] == pytest.approx(1.0 - 2.9 * np.tan(angles), abs=1e-5)
    assert hits[:, 3] == pytest.approx(2.05)


def test_beams_without_return_hit_nothing():
    log = FlightLog()
    log.truth.add(0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0)
    log.add_scan(0.0, [math.inf, -math.inf, math.nan, 3.0], 0.0, 0.1)
    assert len(log.hits()) == 1
