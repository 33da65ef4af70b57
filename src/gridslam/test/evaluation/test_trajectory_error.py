"""ATE and RPE in closed form."""

import math

import numpy as np
import pytest

from gridslam import se2
from gridslam.errors import EvaluationError
from gridslam.evaluation import trajectory_error
from gridslam.evaluation.command import main
from gridslam.evaluation.trajectory_error import trajectory_error_in_space
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


@pytest.mark.table(("align", "rmse"), [("none", 5.0), ("origin", 0.0), ("all", 0.0)])
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
    with pytest.raises(EvaluationError, match=r"Fewer than two poses.* to 100\.000 s, .*from 1000\.000 to"):
        trajectory_error(straight(), late)


def test_poses_in_a_gap_of_the_truth_do_not_count():
    # The truth is lost from 10 to 31 s, while the vehicle turns back; a straight line there is not its way
    kept = np.r_[0:11, 31:101]
    truth = Trajectory(straight().stamps_s[kept], straight().poses_in_map[kept])
    poses = straight().poses_in_map.copy()
    poses[11:31, 1] += 5.0
    poses[:, 1] += 0.3
    error = trajectory_error(Trajectory(straight().stamps_s, poses), truth)
    assert len(error.errors_m) == 81
    assert error.ate_rmse_m == pytest.approx(0.3)
    sparse = Trajectory(straight().stamps_s[::5], straight().poses_in_map[::5])
    assert len(trajectory_error(straight(), sparse).errors_m) == 101  # its usual steps are no gaps


def rows(heights_m, rolls_rad=0.0):
    """Poses in space (200, 8), 0.05 m apart along x, with heights and rolls."""
    k = np.arange(200.0)
    zero = np.zeros(200)
    roll = zero + rolls_rad
    return np.column_stack(
        (0.1 * k, 0.05 * k, zero, zero + heights_m, np.sin(roll / 2), zero, zero, np.cos(roll / 2))
    )


def test_heights_and_roll_count_in_space():
    # Half of the poses are 2 m too high, and all roll by 0.1 rad: sqrt(2) m, as evo_ape says
    error = trajectory_error_in_space(rows(1.0 + 2.0 * (np.arange(200) >= 100), 0.1), rows(1.0))
    assert error.ate_rmse_m == pytest.approx(math.sqrt(2.0))
    assert error.ate_max_m == pytest.approx(2.0)
    assert error.ate_rotation_rmse_deg == pytest.approx(math.degrees(0.1))


def test_the_truth_in_space_is_interpolated():
    # Given a truth of two poses, a metre and half a turn of roll apart
    truth = np.array([(0, 0, 0, 0, 0, 0, 0, 1), (4, 0, 0, 1, 1, 0, 0, 0)], float)
    half = math.pi / 4  # a quarter of the way rolls by 45 degrees
    estimate = np.array(
        [(1, 0, 0, 0.25, math.sin(half / 2), 0, 0, math.cos(half / 2)), (4, 0, 0, 1, 2, 0, 0, 0)], float
    )
    error = trajectory_error_in_space(estimate, truth)
    assert error.ate_rmse_m == pytest.approx(0.0, abs=1e-12)
    assert error.ate_rotation_rmse_deg == pytest.approx(0.0, abs=1e-5)


@pytest.mark.table(
    ("estimate_m", "truth_m", "rmse_m", "is_said"),
    [(0.0, 1.5, 0.0, True), (1.0, 1.5, 0.5, False), (0, 0, 0, False)],
)
def test_the_command_says_when_heights_do_not_count(tmp_path, capsys, estimate_m, truth_m, rmse_m, is_said):
    for name, height_m in (("estimate", estimate_m), ("truth", truth_m)):
        np.savetxt(tmp_path / name, rows(height_m))
    assert main(["ate", str(tmp_path / "estimate"), str(tmp_path / "truth")]) == 0
    said = capsys.readouterr()
    assert ("height, roll and pitch do not count" in said.err) is is_said
    (line,) = [line for line in said.out.splitlines() if line.startswith("ate_rmse_m")]
    assert float(line.split()[1]) == pytest.approx(rmse_m)


def test_the_command_tells_of_gaps_in_the_truth(tmp_path, capsys):
    estimate, truth = tmp_path / "estimate.tum", tmp_path / "truth.tum"
    lines = [f"{k} {k} 0 0 0 0 0 1\n" for k in range(60)]
    estimate.write_text("".join(lines))
    truth.write_text("".join(lines[:10] + lines[40:]))
    assert main(["ate", str(estimate), str(truth)]) == 0
    said = capsys.readouterr()
    assert "truth.tum has gaps, in which 30 poses of" in said.err
    assert dict(line.split() for line in said.out.splitlines())["poses"] == "30"


@pytest.mark.table(("numbers", "name"), [(12, "KITTI"), (17, "EuRoC"), (9, "")])
def test_trajectories_of_other_forms_are_called_by_name(tmp_path, capsys, numbers, name):
    path = tmp_path / "other.txt"
    path.write_text("# a heading\n" + "1 " * numbers)
    assert main(["ate", str(path), str(path)]) == 1
    said = capsys.readouterr().err
    assert f"line 2: has {numbers} numbers" in said
    assert [each for each in ("KITTI", "EuRoC") if each in said] == [name] * bool(name)
