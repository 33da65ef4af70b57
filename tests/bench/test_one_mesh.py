"""What `bench explore --rows one_mesh` tells of a flight. The values are counted by hand."""

import numpy as np
import pytest

from benchmarks.explore_rows.one_mesh import height_error_m


def test_the_height_counts_from_the_floor_and_not_from_the_first_pose_which_tells_none():
    times_s = np.arange(0.0, 4.0, 0.1)
    truth = np.column_stack((times_s, 0.12 + np.maximum(times_s - 2.0, 0.0)))
    odometry = truth + np.array((0.0, 0.02))
    odometry[0, 1] = 0.0
    assert height_error_m(odometry, truth) == pytest.approx(0.02)
    odometry[30, 1] -= 0.05
    assert height_error_m(odometry, truth) == pytest.approx(0.03)
