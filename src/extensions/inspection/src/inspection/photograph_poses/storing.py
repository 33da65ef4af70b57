"""Writes what is known of placed photographs beside them. The pictures themselves are left as they are."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import yaml

from input_schemas import read_file
from inspection.camera.survey_camera import SurveyCamera
from inspection.files.whole import write_whole
from inspection.photograph_poses.pose import Pose, Poses
from inspection.photographs.calibration import (
    CALIBRATED,
    calibration_of,
    focal_apart,
    focal_in_words,
    read_sourced_camera,
)
from inspection.photographs.listing import pictures_in
from inspection.photographs.record import PhotographError, PhotographRecord, check_record
from inspection.photographs.sourced import Sourced, best_of, doubts_in_words

CALIBRATION = "calibration.yaml"
BY = "place_photographs"
"""Value of `placed_by` in the JSON files of this program, which it may replace."""


def store(folder: Path, poses: Poses, replace_all: bool = False, keeps: bool = False) -> list[str]:
    """Write a JSON beside each photograph that has a pose, and the folder's calibration.yaml.

    A pose that an earlier call has given to a photograph which has none now is removed. Return a sentence for
    what becomes of each of these, and for a camera that contradicts the calibration.

    replace_all: also the JSON files that this program has not written, and the calibration. keeps: the poses
    of earlier calls stay.

    Raises:
        PhotographError: nothing is known of the camera, files of others are in the way, or the disk is full.
    """
    files: dict[Path, bytes] = {}
    taken = [path.with_suffix(".json") for path in poses.of if _is_of_another(path.with_suffix(".json"))]
    if taken and not replace_all:
        raise PhotographError(
            f"{taken[0]}: is of another program, as {len(taken)} in all are. Move them, or give --replace."
        )
    calibration, said = _calibration(folder, poses, replace_all)
    if calibration is not None:
        files[folder / CALIBRATION] = calibration
    files |= {each.with_suffix(".json"): _json(each, pose) for each, pose in poses.of.items()}
    earlier = [
        path
        for each in pictures_in(folder)
        if (path := each.with_suffix(".json")) not in files and path.exists() and not _is_of_another(path)
    ]
    try:
        write_whole(files)
        for each in () if keeps else earlier:
            each.unlink()
    except OSError as error:
        raise PhotographError(f"The poses cannot be stored in {folder}: {error.strerror}.") from None
    what = "keeps the pose" if keeps else "loses the pose"
    return [*said, *(f"{each.name}: the photograph {what} that an earlier call gave it." for each in earlier)]


def _calibration(folder: Path, poses: Poses, replace_all: bool) -> tuple[bytes | None, list[str]]:
    """Return what is to be written as calibration.yaml, None for nothing; and what is to be said.

    A file of ours is written anew. One of others stays, and counts.
    """
    path, camera = folder / CALIBRATION, poses.camera
    if camera is None:
        if path.exists():
            return None, []
        refused = " ".join(doubts_in_words(poses.doubts)[:1])
        raise PhotographError(
            f"{folder}: nothing tells the camera's focal length. {refused} Put calibration.yaml of ROS's "
            "camera_calibration into the folder.".replace("  ", " ")
        )
    content = yaml.safe_dump(
        calibration_of(camera.value) | {"source": camera.source, "focal_deviation": camera.deviation}
    ).encode()
    if replace_all or not path.exists():
        return content, _unsure(camera)
    held = read_sourced_camera(path)
    if held.source and (poses.is_camera_exact or camera.deviation <= held.deviation):
        return content, _unsure(camera)
    known = replace(held, source=held.source or "calibration.yaml")
    _, doubts = best_of((known, camera), focal_apart, "the focal length", focal_in_words)
    if doubts and poses.is_camera_exact:
        raise PhotographError(
            f"{path}: {doubts[0].why} The poses hold with {camera.source}'s camera only. Give the "
            "calibration with which they were found, or --replace."
        )
    return None, [f"{path}: {each.why}" for each in doubts]


def _unsure(camera: Sourced[SurveyCamera]) -> list[str]:
    """Return a sentence on a focal length that nobody has measured."""
    if camera.deviation <= 2.0 * CALIBRATED:
        return []
    return [
        f"The focal length, {camera.value.focal_px:.0f} px by {camera.source}, may be wrong by some "
        f"{100 * camera.deviation:.1f} %"
        + (", and the lens is taken for one without distortion" if camera.value.lens is None else "")
        + ". Put the camera's calibration.yaml into the folder for better places."
    ]


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
    variances = [pose.deviation**2] * 3 + [pose.turned_rad**2] * 3
    record = PhotographRecord(
        pose.stamp_s or 0.0, pose.position_m, pose.orientation_xyzw, pose.exposure_s, pose.iso, pose.lux,
        covariance=tuple(np.diag(variances).ravel().tolist()), source=pose.source,
    )  # fmt: skip
    try:
        check_record(record)
    except (ValueError, TypeError) as error:
        raise PhotographError(f"The pose of {path.name} cannot be used: {error}.") from None
    return json.dumps({"placed_by": BY, **asdict(record)}, indent=1, allow_nan=False).encode()
