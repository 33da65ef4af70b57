"""Writes what is known of placed photographs beside them. The pictures themselves are left as they are."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

import yaml

from input_schemas import read_file
from inspection.camera.survey_camera import SurveyCamera
from inspection.files.whole import write_whole
from inspection.photograph_poses.pose import Pose, Poses
from inspection.photographs.calibration import calibration_of, read_camera
from inspection.photographs.record import PhotographError, PhotographRecord, check_record

CALIBRATION = "calibration.yaml"
BY = "place_photographs"
"""Value of `placed_by` in the JSON files of this program, which it may replace."""


def store(folder: Path, poses: Poses, replace_all: bool = False) -> None:
    """Write a JSON beside each photograph that has a pose, and the folder's calibration.yaml if it has none.

    replace_all: also the JSON files that this program has not written, and the calibration.

    Raises:
        PhotographError: nothing is known of the camera, files of others are in the way, or the disk is full.
    """
    files: dict[Path, bytes] = {}
    taken = [path.with_suffix(".json") for path in poses.of if _is_of_another(path.with_suffix(".json"))]
    if taken and not replace_all:
        raise PhotographError(
            f"{taken[0]}: is of another program, as {len(taken)} in all are. Move them, or give --replace."
        )
    path = folder / CALIBRATION
    if not path.exists() or (replace_all and poses.camera is not None):
        files[path] = _calibration(folder, poses.camera)
    elif poses.camera is not None and poses.is_camera_exact and not _alike(read_camera(path), poses.camera):
        raise PhotographError(
            f"{path}: is of another camera than the poses, whose focal length is "
            f"{poses.camera.focal_px:.1f} px. "
            "Give the calibration with which they were found, or --replace."
        )
    files |= {each.with_suffix(".json"): _json(each, pose) for each, pose in poses.of.items()}
    try:
        write_whole(files)
    except OSError as error:
        raise PhotographError(f"The poses cannot be stored in {folder}: {error.strerror}.") from None


def _calibration(folder: Path, camera: SurveyCamera | None) -> bytes:
    if camera is None:
        raise PhotographError(
            f"{folder}: nothing tells the camera's focal length. Put calibration.yaml of ROS's "
            "camera_calibration "
            "into the folder."
        )
    return yaml.safe_dump(calibration_of(camera)).encode()


def _alike(one: SurveyCamera, other: SurveyCamera) -> bool:
    return (one.width, one.height) == (other.width, other.height) and abs(
        one.focal_px / other.focal_px - 1.0
    ) < 1e-4


@dataclass(frozen=True)
class Placed:
    """What of a photograph's JSON tells who has written it."""

    placed_by: str = ""


def _is_of_another(path: Path) -> bool:
    if not path.exists():
        return False
    try:
        return read_file(path, "The record", Placed, PhotographError, other_keys=True).placed_by != BY
    except PhotographError:
        return True


def _json(path: Path, pose: Pose) -> bytes:
    record = PhotographRecord(
        pose.stamp_s or 0.0, pose.position_m, pose.orientation_xyzw, pose.exposure_s, pose.iso, pose.lux
    )
    try:
        check_record(record)
    except (ValueError, TypeError) as error:
        raise PhotographError(f"The pose of {path.name} cannot be used: {error}.") from None
    return json.dumps({"placed_by": BY, **asdict(record)}, indent=1, allow_nan=False).encode()
