"""Reads the poses of photographs that were taken: of a folder, of a table, or of a plan."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Callable, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from flight_basics.errors import SurveyError
from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera, optical_axes, rolled
from inspection.files.table import Row, TableError, number_of, read_table
from inspection.photographs.calibration import read_camera
from inspection.photographs.listing import Listing
from inspection.photographs.record import PhotographError
from inspection.photographs.searched import countable
from inspection.survey.plan_file import read_plan

PLAN_SUFFIXES = (".yaml", ".yml")
HEADS = {
    "x": ("x_m",), "y": ("y_m",), "z": ("z_m",), "yaw_deg": ("yaw",), "tilt_deg": ("tilt",),
    "roll_deg": ("roll",),
    "qx": (), "qy": (), "qz": (), "qw": (), "blur_px": (),
}  # fmt: skip
ANGLES, QUATERNION = ("yaw_deg", "tilt_deg"), ("qx", "qy", "qz", "qw")
COLUMNS = "x, y, z and either yaw_deg, tilt_deg or qx, qy, qz, qw (of the optical frame)"


def read_photograph_poses(
    path: Path, camera: SurveyCamera, say: Callable[[str], None] = lambda _: None
) -> tuple[list[PhotographPose], SurveyCamera]:
    """Read a folder of photographs, a table of poses, or a plan; return what was taken, and the camera.

    The camera given counts for a table. A folder has its own in calibration.yaml, a plan in itself. say: told
    which photographs of a folder do not count; see `photographs.searched`.

    Raises:
        SurveyError: one sentence that names the file, the line and the fault.
    """
    if path.is_dir():
        listing = countable(path)
        listing.tell(say)
        return photograph_poses_in(path, listing, camera)
    if path.suffix.lower() in PLAN_SUFFIXES:
        plan = read_plan(path)
        taken, camera = [PhotographPose.of_view(view) for view in plan.views], plan.camera
    else:
        taken = _of_table(path, say)
    if not taken:
        raise SurveyError(f"{path}: there is no photograph in it.")
    return taken, camera


def photograph_poses_in(
    folder: Path, listing: Listing, camera: SurveyCamera
) -> tuple[list[PhotographPose], SurveyCamera]:
    """Return the photographs of a folder that count, and their camera on the gimbal of the one given.

    Raises:
        SurveyError: none counts, or the calibration cannot be read.
    """
    if not listing.whole:
        raise SurveyError(f"{folder}: there is no photograph in it that counts.")
    taken = [replace(record.pose, name=path.name, path=path) for path, record in listing.whole]
    return taken, _camera_of(folder / "calibration.yaml", camera)


def _camera_of(path: Path, camera: SurveyCamera) -> SurveyCamera:
    """Return the camera of a calibration.yaml on the gimbal of the one given."""
    try:
        held = read_camera(path)
    except PhotographError as error:
        raise SurveyError(str(error)) from None
    return replace(held, tilt_min=camera.tilt_min, tilt_max=camera.tilt_max, exposure=camera.exposure)


def _of_table(path: Path, say: Callable[[str], None]) -> list[PhotographPose]:
    try:
        table = read_table(path, HEADS, ("x", "y", "z"))
    except TableError as error:
        raise SurveyError(f"The poses {error}") from None
    if table.unused:
        say(f"{path.name}: these columns are not known and not read: {', '.join(table.unused)}.")
    return [_of_row(row) for row in table.rows]


def _of_row(row: Row) -> PhotographPose:
    try:
        place_m = [number_of(row.values[name]) for name in ("x", "y", "z")]
        blur_px = number_of(row.values.get("blur_px") or "0")
        if "qx" in row.values:
            return _taken(row.where, place_m, [number_of(row.values[name]) for name in QUATERNION], blur_px)
        yaw, tilt = (math.radians(number_of(row.values[name])) for name in ANGLES)
        roll = math.radians(number_of(row.values.get("roll_deg") or "0"))
        turn = Rotation.from_matrix(rolled(optical_axes(yaw, tilt), roll)).as_quat()
    except (KeyError, ValueError):
        raise SurveyError(f"{row.where}: the columns must be {COLUMNS}, all finite numbers.") from None
    return _taken(row.where, place_m, turn.tolist(), blur_px)


def _taken(
    where: str, place_m: Sequence[float], quaternion: Sequence[float], blur_px: float
) -> PhotographPose:
    place, turn = np.array(place_m, float), np.array(quaternion, float)
    finite = np.isfinite(place).all() and np.isfinite(turn).all() and 0.0 <= blur_px < math.inf
    if not finite or abs(np.linalg.norm(turn) - 1.0) > 0.01:
        raise SurveyError(
            f"{where}: the pose needs a place of three finite numbers, a unit quaternion and a blur "
            "of 0 or more."
        )
    return PhotographPose.of_pose(place_m, quaternion, blur_px)
