"""The motion of a lidar, against vectors worked out by hand."""

import math

import numpy as np
import pytest

from cepa import Motion, MotionError

HALF = math.sqrt(0.5)
LEVEL = (0.0, 0.0, 0.0, 1.0)
TURNED_LEFT = (0.0, 0.0, HALF, HALF)
UPSIDE_DOWN = (1.0, 0.0, 0.0, 0.0)


def test_a_lidar_on_a_body_that_looks_to_the_left():
    motion = Motion.of_mounted(3.0, (1.0, 2.0, 3.0), TURNED_LEFT, (2.0, 0.5, 0.1), (0.1, 0.0, 0.2), LEVEL)
    np.testing.assert_allclose(motion.position_m, (1.0, 2.1, 3.2))
    np.testing.assert_allclose(motion.velocity_m_s, (-0.5, 2.0, 0.1), atol=1e-12)
    assert motion.yaw_rad == pytest.approx(math.pi / 2)
    assert (motion.stamp_s, motion.climb_ref_m_s, motion.age_s) == (3.0, 0.0, 0.0)


def test_the_mountings_orientation_is_turned_by_the_bodys():
    motion = Motion.of_mounted(
        0.0, (0.0, 0.0, 0.0), TURNED_LEFT, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), UPSIDE_DOWN
    )
    expected = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]
    np.testing.assert_allclose(motion.rotation(), expected, atol=1e-12)


def test_a_body_whose_orientation_is_none_is_refused():
    with pytest.raises(MotionError, match="not a unit quaternion"):
        Motion.of_mounted(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
