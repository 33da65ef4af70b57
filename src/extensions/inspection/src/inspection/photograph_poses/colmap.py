"""Reads a model of COLMAP in text: cameras.txt and images.txt (https://colmap.github.io/format.html).

Its optical frame is ours, but its pixels begin at the corner of the first one, not in its middle.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Collection, NamedTuple, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from flight_basics.errors import ParameterError
from input_schemas import text_of
from inspection.camera.lens import Lens
from inspection.camera.survey_camera import SurveyCamera
from inspection.photograph_poses.pose import Names, Pose, Poses, one_camera
from inspection.photographs.calibration import CALIBRATED, camera_with
from inspection.photographs.listing import LeftOut
from inspection.photographs.record import PhotographError
from inspection.photographs.sourced import Sourced

F, FXY = ("f", "cx", "cy"), ("fx", "fy", "cx", "cy")
MODELS = {
    "SIMPLE_PINHOLE": F,
    "PINHOLE": FXY,
    "SIMPLE_RADIAL": (*F, "k1"),
    "RADIAL": (*F, "k1", "k2"),
    "OPENCV": (*FXY, "k1", "k2", "p1", "p2"),
    "FULL_OPENCV": (*FXY, "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"),
}
DISTORTION = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")


class Seen(NamedTuple):
    """A photograph of a model. place_m: (3,) of the camera. axes: (3, 3) of the optical frame, in columns."""

    name: str
    camera: int
    place_m: np.ndarray
    axes: np.ndarray


def poses_of_colmap(model: Path, folder: Path, photographs: Sequence[Path]) -> Poses:
    """Return the poses in a model's own frame.

    Raises:
        PhotographError: a file of the model cannot be read, or its lenses are of another model than OpenCV's.
    """
    seen = read_images(model / "images.txt")
    if not seen:
        raise PhotographError(f"{model / 'images.txt'}: there is no photograph in it.")
    names = Names(folder, photographs, [each.name for each in seen], model)
    own = {path: each for each in seen if (path := names.find(each.name)) is not None}
    if not own:
        raise PhotographError(
            f"{model}: none of its {len(seen)} photographs is in {folder}; the first is {seen[0].name}."
        )
    cameras, faults = read_cameras(model / "cameras.txt", {each.camera for each in own.values()})
    if not cameras:
        raise PhotographError(next(iter(faults.values())))
    camera, others = one_camera(
        {path: cameras[each.camera] for path, each in own.items() if each.camera in cameras}
    )
    others += [LeftOut(path.name, faults[each.camera]) for path, each in own.items() if each.camera in faults]
    refused = {each.name for each in others}
    poses = {
        path: replace(Pose.of_axes(each.place_m, each.axes), source=f"COLMAP's model {model.name}")
        for path, each in own.items()
        if path.name not in refused
    }
    missing = [LeftOut(each.name, "It is not in COLMAP's model.") for each in photographs if each not in own]
    return Poses(poses, (*others, *missing), camera, is_camera_exact=True, remarks=names.remarks)


def read_images(path: Path) -> list[Seen]:
    """Return the photographs of images.txt.

    A line of points follows each, and is left out. It may be empty or missing; more empty lines do no harm.
    """
    seen, may_be_points = list[Seen](), False
    for number, line in _lines(path):
        words = line.split()
        if not words or line.startswith("#"):
            continue
        if may_be_points and len(words) % 3 == 0 and all(map(_is_number, words)):
            may_be_points = False
            continue
        seen.append(_seen(path, number, line.split(maxsplit=9)))
        may_be_points = True
    return seen


def _seen(path: Path, number: int, words: Sequence[str]) -> Seen:
    try:
        w, x, y, z, *shift = map(float, words[1:8])
        camera, name = int(words[8]), words[9]
        turn = np.array((x, y, z, w))
        if not np.isfinite([*turn, *shift]).all() or abs(np.linalg.norm(turn) - 1.0) > 0.01:
            raise ValueError
    except (ValueError, IndexError):
        raise PhotographError(
            f"{path}, line {number}: must be IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, and each "
            "second line one of points, which may be empty."
        ) from None
    into_camera = Rotation.from_quat(turn).as_matrix()
    return Seen(name, camera, -into_camera.T @ shift, into_camera.T)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def read_cameras(
    path: Path, wanted: Collection[int]
) -> tuple[dict[int, Sourced[SurveyCamera]], dict[int, str]]:
    """Return cameras of cameras.txt by their numbers, and a sentence for each that cannot be used."""
    cameras = dict[int, Sourced[SurveyCamera]]()
    faults = {each: f"{path}: there is no camera {each}, which images.txt names." for each in wanted}
    for number, line in _lines(path):
        words = line.partition("#")[0].split()
        if not words or words[0] not in map(str, wanted):
            continue
        camera = int(words[0])
        try:
            model, width, height, *values = words[1:]
            if model not in MODELS:
                raise ParameterError(
                    f"the lens model {model} is not read, but {', '.join(MODELS)} are. Undistort the "
                    "photographs with COLMAP's image_undistorter, and give that model"
                )
            numbers = [float(each) for each in values]
            if len(numbers) != len(MODELS[model]):
                raise ParameterError(f"{model} has {len(MODELS[model])} parameters, not {len(numbers)}")
            known = camera_with(int(width), int(height), _lens(dict(zip(MODELS[model], numbers))))
            cameras[camera] = Sourced(known, "COLMAP", CALIBRATED)
            del faults[camera]
        except (ValueError, ParameterError) as error:
            why = str(error).rstrip(".")
            faults[camera] = f"{path}, line {number}: is no camera that can be used: {why}."
    return cameras, faults


def _lens(values: dict[str, float]) -> Lens:
    focal = values.get("f", math.nan)
    return Lens(
        (values.get("fx", focal), values.get("fy", focal)),
        (values["cx"] - 0.5, values["cy"] - 0.5),
        tuple(values.get(each, 0.0) for each in DISTORTION),
    )


def _lines(path: Path) -> list[tuple[int, str]]:
    try:
        text = text_of(path.read_bytes())
    except OSError as error:
        more = ""
        if path.with_suffix(".bin").exists():
            more = " Write the model as text: colmap model_converter --output_type TXT."
        raise PhotographError(f"{path}: cannot be read: {error.strerror}.{more}") from None
    if "\0" in text:
        raise PhotographError(f"{path}: is no text of COLMAP.")
    return [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1)]
