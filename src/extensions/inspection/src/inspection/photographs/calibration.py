"""The camera of a folder: `calibration.yaml`, as ROS's camera_calibration or OpenCV's samples write it.

`source` and `focal_deviation` in it are ours: where we have it from, and how sure its focal length is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping

import numpy as np

from flight_basics.checks import check_parameters, limited
from flight_basics.errors import ParameterError
from input_schemas import read_made, structured
from inspection.camera.lens import Lens, lens_of
from inspection.camera.survey_camera import SurveyCamera
from inspection.photographs.record import PhotographError
from inspection.photographs.sourced import Sourced

CALIBRATED = 0.003
"""Standard deviation of the focal length of a camera that was calibrated, as a share.

Pixels are square, but fx and fy of public calibrations (EuRoC's two cameras, TUM RGB-D's three) differ by
0.0038 (rms), which is sqrt(2) times as much.
"""
MIDDLE_PX, SQUARE = 1e-3, 1e-9
"""A principal point so near to the middle, and pixels so near to squares, are those of a pinhole."""


@dataclass(frozen=True)
class MatrixEntry:
    """A matrix in a calibration, row by row; raises ParameterError if its numbers are not rows x cols."""

    data: tuple[float, ...] = ()
    rows: int | None = None
    cols: int | None = None

    def __post_init__(self) -> None:
        if self.rows is not None and self.cols is not None and self.rows * self.cols != len(self.data):
            raise ParameterError(f"it has {len(self.data)} numbers for {self.rows} x {self.cols}")


@dataclass(frozen=True)
class CalibrationFile:
    """The file of a calibration; see the module."""

    image_width: int
    image_height: int
    camera_matrix: MatrixEntry
    distortion_coefficients: MatrixEntry = MatrixEntry()
    distortion_model: str = ""
    fisheye_model: Any = None
    source: str = ""
    focal_deviation: float = limited(CALIBRATED, 0.0, 1.0)

    def __post_init__(self) -> None:
        check_parameters(self)


def read_camera(path: Path) -> SurveyCamera:
    """Return the camera in a folder's calibration.yaml, with its lens unless it is a pinhole.

    Raises:
        PhotographError: the file cannot be read, or the lens is of another model than OpenCV's.
    """
    return read_sourced_camera(path).value


def read_sourced_camera(path: Path) -> Sourced[SurveyCamera]:
    """Return the same, with its source and the deviation of its focal length, a share."""
    return read_made(path, "The camera's calibration", _camera_in, PhotographError, plain=_without_opencv)


def _camera_in(content: Any) -> Sourced[SurveyCamera]:
    if isinstance(content, Mapping):  # OpenCV's samples write some in capitals
        content = {str(name).lower(): value for name, value in content.items()}
    told = structured(content, CalibrationFile, PhotographError, other_keys=True)
    try:
        if told.fisheye_model:
            raise ParameterError("it is of a fisheye lens. Undistort the photographs")
        lens = lens_of(told.camera_matrix.data, told.distortion_model, told.distortion_coefficients.data)
        camera = camera_with(told.image_width, told.image_height, lens)
    except ParameterError as error:
        raise PhotographError(f"is no camera's calibration ({str(error).rstrip('.')}).") from None
    return Sourced(camera, told.source, told.focal_deviation)


def focal_apart(one: Sourced[SurveyCamera], other: Sourced[SurveyCamera]) -> float:
    """Return by which share two focal lengths differ."""
    return abs(math.log(one.value.focal_px / other.value.focal_px))


def focal_in_words(camera: Sourced[SurveyCamera]) -> str:
    """Return a focal length, with what it is of."""
    told = camera.value
    return f"{told.focal_px:.0f} px for pictures of {told.width} x {told.height} px"


def _without_opencv(text: str) -> str:
    """Return YAML of a file that OpenCV's FileStorage has written: it has a head and types of its own."""
    if text.startswith("%YAML:"):
        text = "\n" + text.partition("\n")[2]
    return text.replace("!!opencv-matrix", "")


def camera_with(width: int, height: int, lens: Lens) -> SurveyCamera:
    """Return a camera with a lens, or the pinhole that it is; raises ParameterError if it makes no sense."""
    across = round(2.0 * math.degrees(math.atan(0.5 * width / lens.focal_px[0])), 6)
    pinhole = SurveyCamera(width, height, across)
    off_px = np.abs(np.subtract(lens.centre_px, pinhole.centre_px)).max()
    is_square = abs(lens.focal_px[1] / lens.focal_px[0] - 1.0) < SQUARE
    if is_square and off_px < MIDDLE_PX and not any(lens.distortion):
        return pinhole
    return SurveyCamera(width, height, across, lens=lens)


def calibration_of(camera: SurveyCamera) -> dict:
    """Return the content of calibration.yaml."""

    def matrix(values: np.ndarray) -> dict:
        return {"rows": values.shape[0], "cols": values.shape[1], "data": values.ravel().tolist()}

    model, distortion = distortion_of(camera)
    return {
        "image_width": camera.width,
        "image_height": camera.height,
        "camera_name": "inspection_camera",
        "camera_matrix": matrix(camera.matrix),
        "distortion_model": model,
        "distortion_coefficients": matrix(np.array([distortion])),
        "rectification_matrix": matrix(np.eye(3)),
        "projection_matrix": matrix(np.column_stack((camera.matrix, np.zeros(3)))),
    }


def distortion_of(camera: SurveyCamera) -> tuple[str, list[float]]:
    """Return CameraInfo's distortion_model and D of a camera."""
    held = list(camera.lens.distortion) if camera.lens is not None else [0.0] * 8
    return ("rational_polynomial", held) if any(held[5:]) else ("plumb_bob", held[:5])
