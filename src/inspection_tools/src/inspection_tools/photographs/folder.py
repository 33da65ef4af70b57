"""A folder of photographs: JPEG with EXIF, a JSON beside each, and the lists that other tools read.

`rgb.txt` and `groundtruth.txt` are those of TUM's RGB-D data sets, `calibration.yaml` is that of ROS's
camera_calibration_parsers. A file appears under its name only when it is whole, JPEG and JSON at once.
"""

from __future__ import annotations

import errno
import json
import math
import os
import threading
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from PIL import Image

from inspection_tools.errors import InspectionToolsError, ParameterError
from inspection_tools.survey.camera import SurveyCamera
from inspection_tools.survey.poses import Taken

JPEG_QUALITY = 92
POSES_HEAD = "# timestamp tx ty tz qx qy qz qw of the optical frame\n"
NAMES_HEAD = "# timestamp filename\n"
MAKE, MODEL, EXPOSURE_TIME, ISO_SPEED, FOCAL_35MM, EXIF_BLOCK = 0x010F, 0x0110, 0x829A, 0x8827, 0xA405, 0x8769
"""Tags of EXIF 2.3."""


class PhotographError(InspectionToolsError):
    """A photograph cannot be stored or read."""


@dataclass(frozen=True)
class PhotographRecord:
    """What is known of a photograph.

    position_m, orientation_xyzw: of the optical frame (x right, y down, z ahead) in the map. covariance: 36
    numbers, row by row, of x, y, z and the rotation about x, y, z. exposure_s, iso, lux: of the picture, lux
    in its middle. blur_px: by motion and turning during the exposure, the longest. patches: of the surface,
    seen in it. view: number of the photograph in the plan that it was taken for; 0: none. shift_m, turn_rad:
    that the camera moved and turned during the exposure; None: only blur_px is known. viewpoint: for which it
    was taken: x, y, z in m, yaw and tilt in rad, in the map; None: not known. A plan that is edited gives
    other numbers, so this tells what a photograph was taken for. told_position_m, told_orientation_xyzw: the
    pose as it was told first, before SLAM's path moved the photograph; None: it did not.
    """

    stamp_s: float
    position_m: tuple[float, float, float]
    orientation_xyzw: tuple[float, float, float, float]
    exposure_s: float
    iso: float
    lux: float
    blur_px: float = 0.0
    covariance: tuple[float, ...] = (0.0,) * 36
    patches: tuple[int, ...] = ()
    view: int = 0
    shift_m: float | None = None
    turn_rad: float | None = None
    viewpoint: tuple[float, float, float, float, float] | None = None
    told_position_m: tuple[float, float, float] | None = None
    told_orientation_xyzw: tuple[float, float, float, float] | None = None

    @property
    def taken(self) -> Taken:
        """Where the camera was, and how the picture is blurred."""
        taken = Taken.of_pose(self.position_m, self.orientation_xyzw, self.blur_px)
        return taken.moved(self.shift_m, self.turn_rad)


KEYS = frozenset(each.name for each in fields(PhotographRecord))


class PhotographFolder:
    """Stores photographs of one camera. A folder that is there already is continued.

    Attributes:
        damaged: a sentence for each photograph there whose record is damaged; it counts as not taken.
    """

    def __init__(self, folder: Path, camera: SurveyCamera) -> None:
        """Make the folder; raises PhotographError if that fails, or if it is another camera's."""
        self.folder, self._camera = folder, camera
        self._lists = threading.Lock()
        self.damaged: list[str] = []
        calibration = folder / "calibration.yaml"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if calibration.exists():
                self._refuse_another_camera(calibration)
            else:
                _write(calibration, yaml.safe_dump(_calibration(camera)).encode())
            self.last_stamp_s = self._restore_lists()
        except OSError as error:
            raise self._lost(error, "The folder") from None

    def _refuse_another_camera(self, path: Path) -> None:
        if read_camera(path) != replace(
            self._camera, tilt_min=-90.0, tilt_max=90.0, exposure=SurveyCamera.exposure
        ):
            raise PhotographError(f"{self.folder} holds photographs of another camera. Give another folder.")

    def _restore_lists(self) -> float | None:
        """Write the lists anew from what is stored, for a run may have been killed. Return the last stamp."""
        whole, self.damaged = records_in(self.folder)
        lines = ["".join(each) for each in zip(*(_lines(path, record) for path, record in whole))]
        poses, names = lines or ("", "")
        _write(self.folder / "groundtruth.txt", (POSES_HEAD + poses).encode())
        _write(self.folder / "rgb.txt", (NAMES_HEAD + names).encode())
        stamps = [float(path.stem) for path in self.folder.glob("*.jpg") if _is_number(path.stem)]
        return max(stamps, default=None)

    def save(self, picture: np.ndarray, record: PhotographRecord) -> Path:
        """Store a picture, uint8 (height, width, 3), and return the JPEG's path.

        Raises:
            PhotographError: the stamp has a photograph, the record has a number that is none, or the disk is
                full or cannot be written. What was stored before is whole.
        """
        name = f"{record.stamp_s:.6f}"
        path = self.folder / f"{name}.jpg"
        if path.exists():
            raise PhotographError(f"{path} is there already, and is kept. Give the photograph another stamp.")
        try:
            _check(record)
        except (ValueError, TypeError) as error:
            raise PhotographError(f"The photograph of {name} s is not stored: {error}.") from None
        partial, partial_json = path.with_suffix(".part"), path.with_suffix(".json.part")
        try:
            Image.fromarray(picture).save(
                partial, "JPEG", quality=JPEG_QUALITY, exif=self._exif(record).tobytes()
            )
            partial_json.write_text(json.dumps(asdict(record), indent=1, allow_nan=False), encoding="utf-8")
            pose, line = _lines(path, record)
            with self._lists:
                os.replace(partial, path)
                os.replace(partial_json, path.with_suffix(".json"))
                _append(self.folder / "groundtruth.txt", pose)
                _append(self.folder / "rgb.txt", line)
        except OSError as error:
            partial.unlink(missing_ok=True)
            partial_json.unlink(missing_ok=True)
            raise self._lost(error, f"The photograph of {name} s") from None
        self.last_stamp_s = max(record.stamp_s, self.last_stamp_s or record.stamp_s)
        return path

    def correct(self, path: Path, record: PhotographRecord) -> None:
        """Replace the record of a stored photograph; raises PhotographError if that fails: the old one stays.

        `correct_lists` brings the lists up to date.
        """
        try:
            _write(path.with_suffix(".json"), json.dumps(asdict(record), indent=1, allow_nan=False).encode())
        except OSError as error:
            raise self._lost(error, f"The record of {path.name}") from None

    def correct_lists(self) -> None:
        """Write the lists anew from the records; raises PhotographError if that fails."""
        try:
            with self._lists:
                self._restore_lists()
        except OSError as error:
            raise self._lost(error, "The list of photographs") from None

    def _exif(self, record: PhotographRecord) -> Image.Exif:
        exif = Image.Exif()
        exif[MAKE], exif[MODEL] = "inspection_tools", f"{self._camera.width} x {self._camera.height}"
        block = exif.get_ifd(EXIF_BLOCK)
        block[EXPOSURE_TIME], block[ISO_SPEED] = record.exposure_s, min(round(record.iso), 65_535)
        block[FOCAL_35MM] = round(36.0 * self._camera.focal_px / self._camera.width)
        return exif

    def _lost(self, error: OSError, what: str) -> PhotographError:
        why = "the disk is full; free some space" if error.errno == errno.ENOSPC else error.strerror
        return PhotographError(f"{what} cannot be stored in {self.folder}: {why}. Earlier ones are whole.")


def photographs_in(folder: Path) -> list[Path]:
    """Return the JPEGs that have a JSON, by their stamps."""
    found = [path for path in folder.glob("*.jpg") if _is_number(path.stem)]
    return sorted((path for path in found if path.with_suffix(".json").exists()), key=lambda p: float(p.stem))


def records_in(folder: Path) -> tuple[list[tuple[Path, PhotographRecord]], list[str]]:
    """Return the photographs with their records, by their stamps, and a sentence for each damaged record."""
    whole, damaged = [], []
    for path in photographs_in(folder):
        try:
            whole.append((path, read_record(path.with_suffix(".json"))))
        except PhotographError as error:
            damaged.append(f"{error} This photograph is left out.")
    return whole, damaged


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


def read_photograph(path: Path) -> tuple[np.ndarray, PhotographRecord]:
    """Return a picture, uint8 (height, width, 3), and its record.

    Raises:
        PhotographError: the JPEG is cut or no picture, or its JSON is missing or damaged.
    """
    try:
        with Image.open(path) as image:
            picture = np.array(image.convert("RGB"))  # one may write to it
    except (OSError, SyntaxError) as error:
        raise PhotographError(f"{path}: the picture is cut or damaged ({error}). Shoot it again.") from None
    return picture, read_record(path.with_suffix(".json"))


def read_record(path: Path) -> PhotographRecord:
    """Return what a photograph's JSON tells; raises PhotographError if it is missing or damaged.

    Keys that are not known here are ignored: a newer program may have written the folder.
    """
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
        known: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value
            for name, value in values.items()
            if name in KEYS
        }
        record = PhotographRecord(**known)
        _check(record)
        return record
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise PhotographError(f"{path}: cannot be read ({error}).") from None


def _check(record: PhotographRecord) -> None:
    """Raise ValueError or TypeError if the record has no pose and no numbers."""
    sizes = [("position_m", 3), ("orientation_xyzw", 4), ("covariance", 36)]
    if record.viewpoint is not None:
        sizes.append(("viewpoint", 5))
    for name, size in sizes:
        values = np.array(getattr(record, name), float)
        if values.shape != (size,) or not np.isfinite(values).all():
            raise ValueError(f"{name} must be {size} finite numbers")
    if not np.linalg.norm(record.orientation_xyzw) > 0.0:
        raise ValueError("orientation_xyzw must not be 0")
    for name in ("stamp_s", "exposure_s", "iso", "lux", "blur_px", "view"):
        if not math.isfinite(float(getattr(record, name))):
            raise ValueError(f"{name} must be a finite number")
    for name in ("blur_px", "shift_m", "turn_rad"):
        value = getattr(record, name)
        if value is not None and not 0.0 <= value < math.inf:
            raise ValueError(f"{name} must be a finite number, not negative")


def _is_number(name: str) -> bool:
    try:
        return math.isfinite(float(name))
    except ValueError:
        return False


def _lines(path: Path, record: PhotographRecord) -> tuple[str, str]:
    """Return a photograph's lines in groundtruth.txt and rgb.txt."""
    pose = " ".join(f"{x:.6f}" for x in (*record.position_m, *record.orientation_xyzw))
    return f"{path.stem} {pose}\n", f"{path.stem} {path.name}\n"


def _calibration(camera: SurveyCamera) -> dict:
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


def _write(path: Path, content: bytes) -> None:
    partial = path.with_name(path.name + ".part")
    try:
        partial.write_bytes(content)
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def _append(path: Path, line: str) -> None:
    """Append a line, whole or not at all."""
    length = path.stat().st_size if path.exists() else 0
    try:
        with path.open("a", encoding="utf-8") as file:
            file.write(line)
    except OSError:
        os.truncate(path, length)
        raise
