"""The camera of a folder: `calibration.yaml`, as ROS's camera_calibration_parsers writes it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import yaml

from inspection_tools.camera.survey_camera import SurveyCamera
from inspection_tools.errors import ParameterError
from inspection_tools.photographs.record import PhotographError


def read_camera(path: Path) -> SurveyCamera:
    """Return the camera in a folder's calibration.yaml, which has no distortion.

    Raises:
        PhotographError: the file cannot be read.
    """
    try:
        values = yaml.safe_load(path.read_text(encoding="utf-8"))
        width, height = values["image_width"], values["image_height"]
        across = 2.0 * math.degrees(math.atan(0.5 * width / values["camera_matrix"]["data"][0]))
        return SurveyCamera(width, height, round(across, 6))
    except OSError as error:
        raise PhotographError(f"{path}: cannot be read: {error.strerror}.") from None
    except (yaml.YAMLError, KeyError, IndexError, TypeError, ZeroDivisionError, ParameterError) as error:
        raise PhotographError(f"{path}: is no camera's calibration ({error}).") from None


def calibration_of(camera: SurveyCamera) -> dict:
    """Return the content of calibration.yaml."""

    def matrix(values: np.ndarray) -> dict:
        return {"rows": values.shape[0], "cols": values.shape[1], "data": values.ravel().tolist()}

    return {
        "image_width": camera.width,
        "image_height": camera.height,
        "camera_name": "inspection_camera",
        "camera_matrix": matrix(camera.matrix),
        "distortion_model": "plumb_bob",
        "distortion_coefficients": matrix(np.zeros((1, 5))),
        "rectification_matrix": matrix(np.eye(3)),
        "projection_matrix": matrix(np.column_stack((camera.matrix, np.zeros(3)))),
    }
