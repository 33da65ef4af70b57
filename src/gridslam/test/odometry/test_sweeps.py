"""A lidar that measures beam after beam while the base turns: `lidar_odometry` straightens its scans."""

from __future__ import annotations

import math

import numpy as np
import pytest
from planar_world import cast

from gridslam import se2
from gridslam.evaluation import Walls
from gridslam.odometry import LidarOdometry
from gridslam.odometry.inertial import GRAVITY_MPS2, InertialReading

BEAMS, PERIOD_S, SWEEP_S, RATE_RADPS = 120, 0.1, 0.09, 2.0
ANGLES = (-math.pi, math.tau / BEAMS)
LIMITS = (0.1, 10.0)
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
LEVEL = ((0.0, 0.0, 0.1), UPRIGHT)
ROOM = Walls.from_polygons(
    [
        np.array([(-4.0, -3.0), (5.0, -3.0), (5.0, 1.0), (3.0, 1.0), (3.0, 4.0), (-4.0, 4.0)]),
        np.array([(-1.5, 1.0), (-0.5, 1.2), (-0.8, 2.0)]),
    ]
)


def pose_at(time_s: float) -> np.ndarray:
    """At rest for 1 s, then along a circle of 0.5 m, at 1 m/s."""
    turned = RATE_RADPS * max(time_s - 1.0, 0.0)
    return np.array((0.5 * math.sin(turned), -0.5 * math.cos(turned), turned))


def swept(time_s: float, rng: np.random.Generator) -> np.ndarray:
    """The ranges (n,) of a scan whose beams are measured one after the other, from a time on."""
    ranges = []
    for beam in range(BEAMS):
        pose = pose_at(time_s + SWEEP_S * beam / (BEAMS - 1))
        bearing = np.array([pose[2] + ANGLES[0] + ANGLES[1] * beam])
        ranges.append(float(cast(ROOM.ends_m, pose[:2], bearing)[0]))
    return np.array(ranges) + 0.01 * rng.standard_normal(BEAMS)


def greatest_errors(lasts_s: float, has_imu: bool) -> tuple[float, float]:
    """The greatest errors, m and rad, of odometry that is told how long a scan lasts."""
    rng, off = np.random.default_rng(1), []
    odometry = LidarOdometry(start=tuple(pose_at(0.0)))
    for index in range(45):
        time_s = PERIOD_S * index
        if has_imu:
            for reading_s in (time_s - 0.5 * PERIOD_S, time_s):
                rate = RATE_RADPS if reading_s >= 1.0 else 0.0
                force = (0.0, 0.5 * rate**2, GRAVITY_MPS2)
                odometry.on_imu(InertialReading(reading_s, UPRIGHT, (0.0, 0.0, rate), force))
        estimate = odometry.on_scan(time_s, swept(time_s, rng), ANGLES, LIMITS, LEVEL, lasts_s)
        true = pose_at(time_s)
        turn = se2.wrap(estimate.roll_pitch_yaw[2] - true[2])
        off.append((math.dist(estimate.position_xyz[:2], true[:2]), abs(float(turn))))
    return tuple(np.max(off, axis=0).tolist())


@pytest.mark.table(("has_imu", "most_rad"), [(True, 0.02), (False, 0.09)])
def test_the_beams_of_a_turning_scan_are_put_where_they_were_measured(has_imu, most_rad):
    # given turns of 2 rad/s, in which the base turns by 0.18 rad and moves by 0.09 m within a scan
    off_m, off_rad = greatest_errors(SWEEP_S, has_imu)
    skewed_m, skewed_rad = greatest_errors(0.0, has_imu)
    # then odometry that knows how long a scan lasts follows. Without an IMU it learns of a turn a scan late
    assert (off_m < 0.05, off_rad < most_rad) == (True, True)
    # and one that does not know it is wrong by half the turn
    assert skewed_m > 2.0 * off_m
    assert skewed_rad > 0.1
