"""ATE and RPE in closed form."""

import math

import numpy as np
import pytest

from gridslam import se2
from gridslam.errors import EvaluationError
from gridslam.evaluation import trajectory_error
from gridslam.trajectory import Trajectory


def straight(scale=1.0, pose=(0.0, 0.0, 0.0), seconds=100):
    """One metre a second along x, seen from a frame at `pose`, and scaled."""
    stamps = np.arange(seconds + 1.0)
    poses = np.column_stack([scale * stamps, np.zeros_like(stamps), np.zeros_like(stamps)])
    return Trajectory(stamps, se2.compose(np.array(pose), poses))


def test_scale_error_grows_along_the_path():
    # Given an odometry that is 1 % short over 100 m: the error at metre i is 0.01 i
    error = trajectory_error(straight(0.99), straight(), rpe_distance_m=10.0)
    i = np.arange(101)
    assert error.ate_rmse_m == pytest.approx(0.01 * math.sqrt((i**2).mean()))
    assert error.ate_mean_m == pytest.approx(0.5)
    assert error.ate_max_m == pytest.approx(1.0)
    assert error.ate_rotation_rmse_deg == pytest.approx(0.0, abs=1e-6)
    assert error.rpe_translation_rmse_m == pytest.approx(0.1, rel=0.01)  # evo adds a pair of 9 m


@pytest.mark.parametrize(("align", "rmse"), [("none", 5.0), ("origin", 0.0), ("all", 0.0)])
def test_alignment_removes_a_shift_of_the_whole(align, rmse):
    bend = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 1.0), (1.0, 1.0, 2.0), (0.0, 2.0, 3.0)])
    stamps = np.arange(4.0)
    shifted = se2.compose(np.array([3.0, 4.0, 0.0]), bend)
    error = trajectory_error(Trajectory(stamps, shifted), Trajectory(stamps, bend), align)
    assert error.ate_rmse_m == pytest.approx(rmse, abs=1e-9)


def test_truth_is_interpolated_and_poses_beyond_it_are_left_out():
    truth = straight(seconds=10)
    estimate = Trajectory(
        np.array([-1.0, 2.5, 7.25, 11.0]), np.array([[9.0, 0, 0], [2.5, 0.3, 0], [7.25, 0.3, 0], [9.0, 0, 0]])
    )
    error = trajectory_error(estimate, truth)
    assert len(error.errors_m) == 2
    assert error.ate_rmse_m == pytest.approx(0.3)
    assert math.isnan(error.rpe_translation_rmse_m)  # no two poses about 1 m apart


def test_no_common_time_is_refused_with_a_sentence():
    late = Trajectory(straight().stamps_s + 1000.0, straight().poses_in_map)
    with pytest.raises(EvaluationError, match="Fewer than two poses"):
        trajectory_error(straight(), late)
