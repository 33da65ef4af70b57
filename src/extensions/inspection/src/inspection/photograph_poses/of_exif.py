"""Poses by what the pictures tell of themselves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Sequence

from inspection.camera.survey_camera import SurveyCamera
from inspection.photograph_poses.exif import Exif, read_exif
from inspection.photograph_poses.pose import Pose, Poses
from inspection.photograph_poses.world_frame import WorldFrame
from inspection.photographs.listing import LeftOut
from inspection.photographs.record import PhotographError

ALIKE = 1e-3
"""Focal lengths of one camera differ by less, as a share."""


def with_exif(pose: Pose, told: Exif) -> Pose:
    """Return a pose with time, exposure and ISO speed of the picture, where its source tells none."""
    values = {
        name: getattr(told, name)
        for name in ("stamp_s", "exposure_s", "iso")
        if getattr(pose, name) is None and getattr(told, name) is not None
    }
    return replace(pose, **values)


def camera_of_exif(told: Sequence[tuple[Path, Exif]]) -> tuple[SurveyCamera | None, list[LeftOut], list[str]]:
    """Return the camera of most pictures, those of another focal length, and what to know of it."""
    cameras = [each.camera for _, each in told if each.camera is not None]
    if not cameras:
        return None, [], []
    keys = [(each.width, each.height, round(each.focal_px / ALIKE / each.width)) for each in cameras]
    camera = cameras[keys.index(max(keys, key=keys.count))]
    others = [
        LeftOut(path.name, "It was taken with another focal length than most. Give it a folder of its own.")
        for path, each in told
        if each.camera is not None and abs(each.camera.focal_px / camera.focal_px - 1.0) > 5.0 * ALIKE
    ]
    said = []
    if not next(each.is_calibrated for _, each in told if each.camera is camera):
        said.append(
            "The lens is taken for one without distortion, for the pictures tell a focal length only. "
            "Put the camera's calibration.yaml into the folder for better places."
        )
    return camera, others, said


def poses_of_exif(photographs: Sequence[Path], frame: WorldFrame | None, heading_deg: float = 90.0) -> Poses:
    """Return the poses by GPS and gimbal.

    frame: None: the place of the first one is the map's origin. heading_deg: of its x axis then.
    """
    poses, left_out, told = dict[Path, Pose](), list[LeftOut](), list[tuple[Path, Exif]]()
    for path in photographs:
        try:
            each = read_exif(path)
            told.append((path, each))
            frame = frame or _frame_at(each, heading_deg)
            poses[path] = with_exif(_pose(path, each, frame), each)
        except PhotographError as error:
            left_out.append(LeftOut.of(path, error))
    camera, others, said = camera_of_exif(told)
    kept = {path: pose for path, pose in poses.items() if path.name not in {each.name for each in others}}
    if any(not each.is_rtk for path, each in told if path in kept):
        said.append(
            "GPS without RTK is wrong by some metres. Findings then lie as far beside their place; COLMAP "
            "with --places does better."
        )
    return Poses(kept, (*left_out, *others), camera, remarks=tuple(said))


def _frame_at(told: Exif, heading_deg: float) -> WorldFrame | None:
    if told.latitude_deg is None or told.longitude_deg is None:
        return None
    return WorldFrame(told.latitude_deg, told.longitude_deg, told.height_m, heading_deg)


def _pose(path: Path, told: Exif, frame: WorldFrame | None) -> Pose:
    if told.latitude_deg is None or told.longitude_deg is None or frame is None:
        raise PhotographError(f"{path}: its EXIF tells no place (GPS).")
    height_m = told.above_start_m if frame.height_m is None else told.height_m
    if height_m is None:
        which = "height above the take-off" if frame.height_m is None else "height (GPS)"
        raise PhotographError(f"{path}: it tells no {which}.")
    if told.yaw_deg is None or told.pitch_deg is None:
        raise PhotographError(
            f"{path}: it tells no direction (GimbalYawDegree and GimbalPitchDegree of DJI's XMP)."
        )
    place_m = frame.place_m(told.latitude_deg, told.longitude_deg, height_m)
    return Pose.of_axes(place_m, frame.axes(told.yaw_deg, told.pitch_deg, told.roll_deg))
