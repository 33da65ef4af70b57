"""ATE and RPE of a trajectory against the ground truth, computed by evo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gridslam.errors import EvaluationError
from gridslam.files.tum import poses_at, rows_at
from gridslam.trajectory import Trajectory

ALIGNMENTS = ("none", "origin", "all")
GAP_S, GAP_FACTOR = 1.0, 10.0
"""A gap of the truth lasts longer than this, and longer than so many of its usual steps."""


@dataclass(frozen=True)
class TrajectoryError:
    """Absolute errors of each pose, their summary, and the relative error over a distance.

    stamps_s, errors_m: (k,) each: position error of each judged pose.
    """

    stamps_s: np.ndarray
    errors_m: np.ndarray
    ate_rmse_m: float
    ate_mean_m: float
    ate_median_m: float
    ate_max_m: float
    ate_rotation_rmse_deg: float
    rpe_distance_m: float
    rpe_translation_rmse_m: float
    """NaN where the path is too short for a pair of poses `rpe_distance_m` apart."""
    rpe_rotation_rmse_deg: float

    def as_dict(self) -> dict:
        """Return the figures, without the series, under the names that result files use."""
        series = ("stamps_s", "errors_m")
        return {name: value for name, value in vars(self).items() if name not in series}


def trajectory_error(
    estimate: Trajectory, truth: Trajectory, align: str = "none", rpe_distance_m: float = 1.0
) -> TrajectoryError:
    """Compare an estimate with the truth, which is interpolated at the estimate's stamps.

    Args:
        estimate: the trajectory to judge; poses outside the truth's time, and in its gaps, are left out.
        truth: the ground truth, densely stamped.
        align: "none" (both are in one frame), "origin" (the first poses coincide) or "all" (least squares).
        rpe_distance_m: the relative error is taken over pieces of path of this length.

    Raises:
        EvaluationError: nothing to compare, or evo is not installed, or it cannot align them.
    """
    judged = _judged(estimate.stamps_s, truth.stamps_s)
    stamps_s = estimate.stamps_s[judged]
    evo = _evo()
    reference = _evo_path(evo, poses_at(truth, stamps_s), stamps_s)
    estimated = _evo_path(evo, estimate.poses_in_map[judged], stamps_s)
    return _compared(evo, estimated, reference, stamps_s, align, rpe_distance_m)


def trajectory_error_in_space(
    estimate: np.ndarray, truth: np.ndarray, align: str = "none", rpe_distance_m: float = 1.0
) -> TrajectoryError:
    """Compare poses in space as `trajectory_error` compares level ones: heights, roll and pitch count.

    Args:
        estimate: (n, 8) rows of stamp, x, y, z and quaternion xyzw.
        truth: (m, 8) likewise.
        align: see `trajectory_error`.
        rpe_distance_m: see `trajectory_error`.

    Raises:
        EvaluationError: see `trajectory_error`.
    """
    rows = estimate[_judged(estimate[:, 0], truth[:, 0])]
    evo = _evo()
    reference, estimated = (_evo_path_in_space(evo, each) for each in (rows_at(truth, rows[:, 0]), rows))
    return _compared(evo, estimated, reference, rows[:, 0], align, rpe_distance_m)


def in_gaps(stamps_s: np.ndarray, truth_s: np.ndarray) -> np.ndarray:
    """Return (n,) whether stamps lie in a gap of the truth, where nobody knows the way: GAP_S and longer."""
    steps_s = np.diff(truth_s)
    if not steps_s.size:
        return np.zeros(len(stamps_s), bool)
    is_long = steps_s > max(GAP_S, GAP_FACTOR * float(np.median(steps_s)))
    step = np.clip(np.searchsorted(truth_s, stamps_s) - 1, 0, len(steps_s) - 1)
    return is_long[step] & (stamps_s > truth_s[step]) & (stamps_s < truth_s[step + 1])


def _judged(estimate_s: np.ndarray, truth_s: np.ndarray) -> np.ndarray:
    """Return (n,) whether the truth is known at a stamp of the estimate; it must be at two."""
    judged = (estimate_s >= truth_s[0]) & (estimate_s <= truth_s[-1]) & ~in_gaps(estimate_s, truth_s)
    if judged.sum() < 2:
        raise EvaluationError(
            "Fewer than two poses of the estimate lie in the time of the ground truth. The estimate is from "
            f"{estimate_s[0]:.3f} to {estimate_s[-1]:.3f} s, the truth from {truth_s[0]:.3f} to "
            f"{truth_s[-1]:.3f} s; check the clocks, and that both count in seconds."
        )
    return judged


def _compared(
    evo: _Evo, estimated: Any, reference: Any, stamps_s: np.ndarray, align: str, rpe_distance_m: float
) -> TrajectoryError:
    """Return the errors of evo's trajectories, which have the same stamps."""
    if align not in ALIGNMENTS:
        raise EvaluationError(f"align must be one of {', '.join(ALIGNMENTS)}, not {align!r}.")
    try:
        if align == "origin":
            estimated.align_origin(reference)
        elif align == "all":
            estimated.align(reference)
    except evo.EvoException as error:
        raise EvaluationError(f"The trajectories cannot be aligned: {error}.") from None
    relation = evo.metrics.PoseRelation
    metres = _ape(evo, relation.translation_part, reference, estimated)
    degrees = _ape(evo, relation.rotation_angle_deg, reference, estimated)
    return TrajectoryError(
        stamps_s=stamps_s,
        errors_m=metres.error,
        ate_rmse_m=_statistic(metres, "rmse"),
        ate_mean_m=_statistic(metres, "mean"),
        ate_median_m=_statistic(metres, "median"),
        ate_max_m=_statistic(metres, "max"),
        ate_rotation_rmse_deg=_statistic(degrees, "rmse"),
        rpe_distance_m=rpe_distance_m,
        rpe_translation_rmse_m=_rpe(evo, relation.translation_part, reference, estimated, rpe_distance_m),
        rpe_rotation_rmse_deg=_rpe(evo, relation.rotation_angle_deg, reference, estimated, rpe_distance_m),
    )


class _Evo:
    """The parts of evo used here. They are imported on first use."""

    def __init__(self) -> None:
        from evo import EvoException
        from evo.core import metrics, trajectory

        self.EvoException, self.metrics, self.trajectory = EvoException, metrics, trajectory


def _evo() -> _Evo:
    try:
        return _Evo()
    except ImportError as error:
        raise EvaluationError(f"ATE and RPE need evo: pip install -r requirements.txt ({error}).") from None


def _evo_path(evo: _Evo, poses: np.ndarray, stamps_s: np.ndarray) -> Any:
    zero = np.zeros(len(poses))
    return evo.trajectory.PoseTrajectory3D(
        positions_xyz=np.column_stack([poses[:, :2], zero]),
        orientations_quat_wxyz=np.column_stack(
            [np.cos(poses[:, 2] / 2), zero, zero, np.sin(poses[:, 2] / 2)]
        ),
        timestamps=stamps_s,
    )


def _evo_path_in_space(evo: _Evo, rows: np.ndarray) -> Any:
    return evo.trajectory.PoseTrajectory3D(
        positions_xyz=rows[:, 1:4],
        orientations_quat_wxyz=rows[:, (7, 4, 5, 6)] / np.linalg.norm(rows[:, 4:], axis=1, keepdims=True),
        timestamps=rows[:, 0],
    )


def _ape(evo: _Evo, relation: Any, reference: Any, estimated: Any) -> Any:
    metric = evo.metrics.APE(relation)
    metric.process_data((reference, estimated))
    return metric


def _rpe(evo: _Evo, relation: Any, reference: Any, estimated: Any, distance_m: float) -> float:
    metric = evo.metrics.RPE(relation, distance_m, evo.metrics.Unit.meters, rel_delta_tol=0.2, all_pairs=True)
    try:
        metric.process_data((reference, estimated))
    except evo.EvoException:
        return float("nan")
    return _statistic(metric, "rmse")


def _statistic(metric: Any, name: str) -> float:
    return float(metric.get_all_statistics()[name])
