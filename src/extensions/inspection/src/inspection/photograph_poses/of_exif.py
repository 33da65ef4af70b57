"""Poses by what the pictures tell of themselves."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Mapping, Sequence

from inspection.camera.lens import Lens
from inspection.camera.survey_camera import SurveyCamera
from inspection.photograph_poses.exif import ALIKE, Exif, read_exif
from inspection.photograph_poses.pose import Pose, Poses, one_camera
from inspection.photograph_poses.world_frame import WorldFrame
from inspection.photographs.calibration import camera_with
from inspection.photographs.listing import LeftOut
from inspection.photographs.record import PhotographError
from inspection.photographs.sourced import Sourced

BY_COMPASS_RAD = math.radians(2.0)
"""Standard deviation of a direction by a compass: 1 to 2 degrees (data sheet of Honeywell's HMC5883L)."""
FINE_M = 0.5
"""A place that is less sure is told."""


def with_exif(pose: Pose, told: Exif) -> Pose:
    """Return a pose with time, exposure and ISO speed of the picture, where its source tells none."""
    stamp_s = told.taken.value if told.taken is not None else None
    values = {"stamp_s": stamp_s, "exposure_s": told.exposure_s, "iso": told.iso}
    lacking = {name: value for name, value in values.items() if getattr(pose, name) is None}
    return replace(pose, **lacking)  # type: ignore[arg-type]


def read_all(photographs: Sequence[Path]) -> tuple[dict[Path, Exif], list[LeftOut]]:
    """Return what pictures tell of themselves, and those that cannot be read."""
    told, left_out = dict[Path, Exif](), list[LeftOut]()
    for path in photographs:
        try:
            told[path] = read_exif(path)
        except PhotographError as error:
            left_out.append(LeftOut.of(path, error))
    return told, left_out


def with_exifs(poses: Poses, told: Mapping[Path, Exif]) -> Poses:
    """Return poses with what the pictures tell besides: light, doubts, and the camera if there is none.

    Those of pictures that cannot be read are left out.
    """
    kept = {path: with_exif(pose, told[path]) for path, pose in poses.of.items() if path in told}
    doubts = (*poses.doubts, *((path.name, each) for path in kept for each in told[path].doubts))
    poses = replace(poses, of=kept, doubts=doubts)
    if poses.camera is not None:
        sizes = Counter(told[path].size for path in kept)
        return replace(
            poses, camera=_fitting(poses.camera, max(sizes, key=sizes.__getitem__)) if sizes else None
        )
    cameras = {path: each for path in kept if (each := told[path].camera) is not None}
    camera, others = one_camera(cameras)
    names = {each.name for each in others}
    kept = {path: pose for path, pose in kept.items() if path.name not in names}
    left_out = (*poses.left_out, *others)
    return replace(poses, of=kept, left_out=left_out, camera=camera)


def _fitting(camera: Sourced[SurveyCamera], size: tuple[int, int]) -> Sourced[SurveyCamera]:
    """Return a camera for pictures of a size, px, if it is of larger or smaller ones of the same shape."""
    share, other = (new / old for new, old in zip(size, (camera.value.width, camera.value.height)))
    if share == 1.0 == other or abs(share / other - 1.0) > ALIKE:
        return camera
    matrix = camera.value.matrix
    plain = Lens((matrix[0, 0], matrix[1, 1]), camera.value.centre_px)
    return replace(camera, value=camera_with(*size, (camera.value.lens or plain).scaled(share)))


def poses_of_exif(told: Mapping[Path, Exif], frame: WorldFrame | None, heading_deg: float = 90.0) -> Poses:
    """Return the poses by GPS and gimbal.

    frame: None: the place of the first one is the map's origin. heading_deg: of its x axis then.
    """
    poses, left_out = dict[Path, Pose](), list[LeftOut]()
    for path, each in told.items():
        try:
            frame = frame or _frame_at(each, heading_deg)
            poses[path] = _pose(path, each, frame)
        except PhotographError as error:
            left_out.append(LeftOut.of(path, error))
    return Poses(poses, tuple(left_out))


def accuracy(poses: Poses) -> list[str]:
    """Return a sentence on the places that are not sure; none if they are."""
    unsure = [each for each in poses.of.values() if each.deviation > FINE_M]
    if not unsure:
        return []
    worst = max(unsure, key=lambda each: each.deviation)
    return [
        f"Places by {worst.source} may be wrong by some {worst.deviation:.1f} m: those of {len(unsure)} of "
        f"{len(poses.of)} photographs. Findings then lie as far beside their place. GPS with RTK, or COLMAP "
        "with --places, does better."
    ]


def _frame_at(told: Exif, heading_deg: float) -> WorldFrame | None:
    if told.place is None:
        return None
    return WorldFrame(*told.place.value, told.height.value if told.height else None, heading_deg)


def _pose(path: Path, told: Exif, frame: WorldFrame | None) -> Pose:
    if told.place is None or frame is None:
        raise PhotographError(f"{path}: its EXIF tells no place (GPS).")
    height = told.above_start if frame.height_m is None else told.height
    if height is None:
        which = "height above the take-off" if frame.height_m is None else "height (GPS)"
        raise PhotographError(f"{path}: it tells no {which}.")
    if told.yaw_deg is None or told.pitch_deg is None:
        raise PhotographError(
            f"{path}: it tells no direction (GimbalYawDegree and GimbalPitchDegree of DJI's XMP)."
        )
    pose = Pose.of_axes(
        frame.place_m(*told.place.value, height.value),
        frame.axes(told.yaw_deg, told.pitch_deg, told.roll_deg),
    )
    source, deviation_m = told.place.source, told.place.deviation
    if height.deviation > deviation_m:
        source, deviation_m = height.source, height.deviation
    return replace(pose, source=source, deviation=deviation_m, turned_rad=BY_COMPASS_RAD)
