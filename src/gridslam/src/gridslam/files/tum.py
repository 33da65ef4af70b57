"""Trajectories as files in TUM form: a line ``stamp x y z qx qy qz qw`` for each pose, # comments."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gridslam.errors import EvaluationError
from gridslam.files.number_rows import read_rows
from gridslam.files.replacing import replace_file
from gridslam.trajectory import Trajectory

OTHER_FORMS = {
    12: " This may be KITTI's form: its poses have no stamps, which must be added.",
    17: " This may be EuRoC's form: evo_traj euroc FILE --save_as_tum makes TUM's of it.",
}
"""What lines with other than 8 numbers may be."""


def write_tum(path: Path, trajectory: Trajectory) -> None:
    """Write a level trajectory at once, turned about z only; stamps to the microsecond. z: 0 if not known.

    Raises:
        OSError: the file cannot be written.
    """
    lines, heights_m = [], np.zeros(len(trajectory.stamps_s))
    if trajectory.heights_m is not None:
        heights_m = np.nan_to_num(trajectory.heights_m)
    for stamp_s, (x, y, yaw), height_m in zip(trajectory.stamps_s, trajectory.poses_in_map, heights_m):
        z, w = np.sin(yaw / 2.0), np.cos(yaw / 2.0)
        lines.append(f"{stamp_s:.6f} {x:.9g} {y:.9g} {height_m:.9g} 0 0 {z:.9g} {w:.9g}\n")
    replace_file(path, "".join(lines))


def write_tum_in_space(path: Path, rows: np.ndarray) -> None:
    """Write poses in space at once: rows (n, 8) of stamp, x, y, z and quaternion xyzw, m and s.

    Raises:
        OSError: the file cannot be written.
    """
    lines = [f"{row[0]:.6f} " + " ".join(f"{value:.9g}" for value in row[1:]) + "\n" for row in rows.tolist()]
    replace_file(path, "".join(lines))


def read_tum(path: Path) -> Trajectory:
    """Read a trajectory. Keep x, y and yaw of poses in space. Keep the first of poses with one stamp.

    Raises:
        EvaluationError: the file cannot be read, or is not in TUM form, or its stamps go back in time.
    """
    rows = read_tum_in_space(path)
    x, y, z, w = rows[:, 4:].T
    yaw = np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)  # of any length
    return Trajectory(rows[:, 0], np.column_stack([rows[:, 1:3], yaw]))


def read_tum_in_space(path: Path) -> np.ndarray:
    """Read poses in space (n, 8): stamp, x, y, z, quaternion xyzw. Keep the first of poses with one stamp.

    Raises:
        EvaluationError: the file cannot be read, or is not in TUM form, or its stamps go back in time.
    """
    rows = read_rows(path, "8 finite numbers: stamp x y z qx qy qz qw", (8,), OTHER_FORMS)
    _, first = np.unique(rows[:, 0], return_index=True)
    if (np.diff(first) < 0).any():
        raise EvaluationError(f"{path}: the stamps go back in time; sort the lines, or cut the file there.")
    rows = rows[first]
    if not (rows[:, 4:] != 0.0).any(axis=1).all():
        raise EvaluationError(
            f"{path}: a quaternion is 0 0 0 0, which is not an orientation; unturned is 0 0 0 1."
        )
    return rows


def is_level(rows: np.ndarray) -> bool:
    """Whether poses in space (n, 8) hold no more than x, y and yaw: all heights are 0, and nothing leans.

    So a planar SLAM writes its path.
    """
    return not rows[:, 3:6].any()


def rows_at(rows: np.ndarray, stamps_s: np.ndarray) -> np.ndarray:
    """Return poses in space (n, 8) at stamps within those of rows (m, 8), interpolated."""
    from scipy.spatial.transform import Rotation, Slerp

    places = [np.interp(stamps_s, rows[:, 0], column) for column in rows[:, 1:4].T]
    turns = Slerp(rows[:, 0], Rotation.from_quat(rows[:, 4:]))(stamps_s).as_quat()
    return np.column_stack([stamps_s, *places, turns])


def poses_at(trajectory: Trajectory, stamps_s: np.ndarray) -> np.ndarray:
    """Return the poses (n, 3) at any stamps: interpolated (yaw the short way), constant beyond the ends."""
    x, y, yaw = np.asarray(trajectory.poses_in_map).T
    own = trajectory.stamps_s
    columns = [np.interp(stamps_s, own, values) for values in (x, y, np.unwrap(yaw))]
    return np.column_stack(columns)
