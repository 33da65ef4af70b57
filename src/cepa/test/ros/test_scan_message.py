"""Scans of drivers whose last beam lies before angle_max."""

import math

import numpy as np
import pytest

conversions = pytest.importorskip("cepa_ros.conversions", reason="the workspace is not built, or not sourced")

from sensor_msgs.msg import LaserScan  # noqa: E402

from cepa import ScanError  # noqa: E402


@pytest.mark.parametrize(
    ("first", "last", "step", "ranges", "agree"),
    [
        (-1.5708, 1.5708, 0.0175, 180, True),  # pointcloud_to_laserscan: 179.52 steps
        (1.0, -1.0, -0.0175, 115, True),  # 114.29 steps, clockwise
        (-1.0, 1.0, 0.01, 200, True),
        (-1.0, 1.0, 0.01, 199, False),
        (-1.0, 1.0, 0.01, 202, False),
        (-math.pi, math.pi, 0.007, 897, True),  # velodyne_laserscan
    ],
)
def test_the_last_beam_may_lie_before_angle_max(first, last, step, ranges, agree):
    scan = LaserScan(range_min=0.1, range_max=10.0, ranges=[1.0] * ranges)
    angles = np.array((first, last, step), np.float32).tolist()  # as a message carries them
    scan.angle_min, scan.angle_max, scan.angle_increment = angles
    if agree:
        assert conversions.scan_of(scan).ranges.size == ranges
        return
    with pytest.raises(ScanError, match="check the driver"):
        conversions.scan_of(scan)
