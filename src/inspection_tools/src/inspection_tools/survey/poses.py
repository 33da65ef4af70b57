"""Where the camera really was: reads the poses of photographs that were taken."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Callable, Mapping, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from inspection_tools.errors import SurveyError
from inspection_tools.survey.camera import SurveyCamera, optical_axes
from inspection_tools.survey.plan_file import read_plan
from inspection_tools.survey.views.candidates import View

COLUMNS = "x, y, z and either yaw_deg, tilt_deg or qx, qy, qz, qw (of the optical frame)"
PLAN_SUFFIXES = (".yaml", ".yml")
NO_PHOTOGRAPHS = ("coverage.json", "findings.json", "result.json")
"""What other commands leave in a folder of photographs."""


@dataclass(frozen=True)
class Taken:
    """A photograph: place_m (3,) of the camera; axes (3, 3), the optical frame's in its columns; its blur.

    blur_px: where the motion is not known. shift_m, turn_rad: of the camera during the exposure.
    """

    place_m: np.ndarray
    axes: np.ndarray
    blur_px: float = 0.0
    shift_m: float = 0.0
    turn_rad: float = 0.0

    @classmethod
    def of_view(cls, view: View) -> Taken:
        """Return the photograph of a view that is taken from its own place."""
        return cls(np.array(view.place_m), optical_axes(view.yaw_rad, view.tilt_rad))

    @classmethod
    def of_pose(
        cls, place_m: Sequence[float], orientation_xyzw: Sequence[float], blur_px: float = 0.0
    ) -> Taken:
        """Return the photograph of a camera at this pose of its optical frame."""
        return cls(np.array(place_m), Rotation.from_quat(orientation_xyzw).as_matrix(), blur_px)

    def moved(self, shift_m: float | None, turn_rad: float | None) -> Taken:
        """Return it with a motion that counts in place of the blur in px, unless it is not known."""
        if shift_m is None or turn_rad is None:
            return self
        return replace(self, blur_px=0.0, shift_m=shift_m, turn_rad=turn_rad)

    def widths_m(self, footprints_m: np.ndarray, depths_m: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return (k,) how widely pixels are spread over the surface, blur included, m.

        footprints_m: (k,) of the pixels without blur. depths_m: (k,) along the optical axis. lengths: (k,) of
        the lines of sight up to depth 1. The motion is reckoned across the line of sight.
        """
        blur_m = self.shift_m * lengths + self.turn_rad * depths_m * lengths**2
        widths_m: np.ndarray = np.hypot(footprints_m * np.hypot(1.0, self.blur_px), blur_m)
        return widths_m


def read_taken(
    path: Path, camera: SurveyCamera, say: Callable[[str], None] = lambda _: None
) -> tuple[list[Taken], SurveyCamera]:
    """Read a folder of photographs (JSON beside each), a CSV, or a plan; return them and their camera.

    The camera given counts for a CSV. A folder has its own in calibration.yaml, a plan in itself. say: told
    which photographs of a folder are damaged; they are left out.

    Raises:
        SurveyError: one sentence that names the file, the line and the fault.
    """
    if path.is_dir():
        taken, camera = _of_folder(path, say), _camera_of(path / "calibration.yaml", camera)
    elif path.suffix.lower() in PLAN_SUFFIXES:
        plan = read_plan(path)
        taken, camera = (
            [Taken.of_view(view) for view in plan.views],
            plan.camera,
        )
    else:
        taken = _of_csv(path)
    if not taken:
        raise SurveyError(f"{path}: there is no photograph in it.")
    return taken, camera


def _of_folder(folder: Path, say: Callable[[str], None]) -> list[Taken]:
    found = []
    for path in sorted(folder.glob("*.json")):
        if path.name in NO_PHOTOGRAPHS:
            continue
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            numbers = [*content["position_m"], *content["orientation_xyzw"], content.get("blur_px", 0.0)]
            taken = _taken(f"{path}", numbers[:3], numbers[3:-1], numbers[-1])
            found.append(taken.moved(*_motion(path, content)))
        except SurveyError as error:
            say(f"{error} It is left out.")
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            say(f"{path}: is no record of a photograph ({error}). It is left out.")
    return found


def _motion(path: Path, content: Mapping[str, Any]) -> tuple[float | None, float | None]:
    """Return the camera's motion in a record; None: the record has none."""
    motion = content.get("shift_m"), content.get("turn_rad")
    if any(value is not None and not 0.0 <= float(value) < math.inf for value in motion):
        raise SurveyError(f"{path}: shift_m and turn_rad must be finite numbers of 0 or more.")
    return motion


def _camera_of(path: Path, camera: SurveyCamera) -> SurveyCamera:
    """Return the camera of a calibration.yaml, as camera_calibration_parsers writes it."""
    import yaml

    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        width, focal_px = content["image_width"], content["camera_matrix"]["data"][0]
        across_deg = 2.0 * math.degrees(math.atan(0.5 * width / focal_px))
        return replace(camera, width=width, height=content["image_height"], field_of_view=across_deg)
    except (OSError, yaml.YAMLError, KeyError, IndexError, TypeError, ValueError, ZeroDivisionError) as error:
        raise SurveyError(f"{path}: is no calibration of a camera ({error}).") from None


def _of_csv(path: Path) -> list[Taken]:
    try:
        with open(path, newline="", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream, skipinitialspace=True))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise SurveyError(f"{path}: cannot be read as CSV ({error}).") from None
    return [_of_row(f"{path}, line {number}", row) for number, row in enumerate(rows, start=2)]


def _of_row(where: str, row: Mapping[str, Any]) -> Taken:
    try:
        place_m = [float(row[name]) for name in ("x", "y", "z")]
        blur_px = float(row.get("blur_px") or 0.0)
        if "qx" in row:
            return _taken(where, place_m, [float(row[name]) for name in ("qx", "qy", "qz", "qw")], blur_px)
        yaw, tilt = (math.radians(float(row[name])) for name in ("yaw_deg", "tilt_deg"))
        axes = optical_axes(yaw, tilt)
    except (KeyError, TypeError, ValueError):
        raise SurveyError(f"{where}: the columns must be {COLUMNS}, all finite numbers.") from None
    return _taken(where, place_m, Rotation.from_matrix(axes).as_quat(), blur_px)


def _taken(where: str, place_m: Sequence[float], quaternion: Sequence[float], blur_px: float) -> Taken:
    try:
        place, turn = np.array(place_m, float), np.array(quaternion, float)
        blur = float(blur_px)
    except (TypeError, ValueError):
        raise SurveyError(f"{where}: the pose is not of numbers.") from None
    finite = np.isfinite(place).all() and np.isfinite(turn).all() and 0.0 <= blur < math.inf
    if place.shape != (3,) or turn.shape != (4,) or not finite or abs(np.linalg.norm(turn) - 1.0) > 0.01:
        raise SurveyError(
            f"{where}: the pose needs a place of three finite numbers, a unit quaternion and a blur "
            "of 0 or more."
        )
    return Taken(place, Rotation.from_quat(turn).as_matrix(), blur)
