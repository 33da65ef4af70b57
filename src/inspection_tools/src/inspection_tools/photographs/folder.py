"""A folder of photographs: JPEG with EXIF, a JSON beside each, and the lists that other tools read.

`rgb.txt` and `groundtruth.txt` are those of TUM's RGB-D data sets, `calibration.yaml` is that of ROS's
camera_calibration_parsers. A file appears under its name only when it is whole.
"""

from __future__ import annotations

import errno
import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from PIL import Image

from inspection_tools.errors import InspectionToolsError
from inspection_tools.survey.camera import SurveyCamera

JPEG_QUALITY = 92
MAKE, MODEL, EXPOSURE_TIME, ISO_SPEED, FOCAL_35MM, EXIF_BLOCK = 0x010F, 0x0110, 0x829A, 0x8827, 0xA405, 0x8769
"""Tags of EXIF 2.3."""


class PhotographError(InspectionToolsError):
    """A photograph cannot be stored or read."""


@dataclass(frozen=True)
class PhotographRecord:
    """What is known of a photograph.

    position_m, orientation_xyzw: of the optical frame (x right, y down, z ahead) in the map. covariance: 36
    numbers, row by row, of x, y, z and the rotation about x, y, z. exposure_s, iso, lux: of the picture, lux
    in its middle. blur_px: by motion and turning during the exposure. patches: of the surface, seen in it.
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


class PhotographFolder:
    """Stores photographs of one camera. A folder that is there already is continued."""

    def __init__(self, folder: Path, camera: SurveyCamera) -> None:
        """Make the folder; raises PhotographError if that fails."""
        self.folder, self._camera = folder, camera
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if not (folder / "rgb.txt").exists():
                _write(folder / "calibration.yaml", yaml.safe_dump(_calibration(camera)).encode())
                _append(folder / "groundtruth.txt", "# timestamp tx ty tz qx qy qz qw of the optical frame\n")
                _append(folder / "rgb.txt", "# timestamp filename\n")
        except OSError as error:
            raise self._lost(error, "The folder") from None

    def save(self, picture: np.ndarray, record: PhotographRecord) -> Path:
        """Store a picture, uint8 (height, width, 3), and return the JPEG's path.

        Raises:
            PhotographError: the disk is full or cannot be written. What was stored before is whole.
        """
        name = f"{record.stamp_s:.6f}"
        path = self.folder / f"{name}.jpg"
        partial = path.with_suffix(".part")
        try:
            Image.fromarray(picture).save(
                partial, "JPEG", quality=JPEG_QUALITY, exif=self._exif(record).tobytes()
            )
            _write(path.with_suffix(".json"), json.dumps(asdict(record), indent=1).encode())
            os.replace(partial, path)
            pose = " ".join(f"{x:.6f}" for x in (*record.position_m, *record.orientation_xyzw))
            _append(self.folder / "groundtruth.txt", f"{name} {pose}\n")
            _append(self.folder / "rgb.txt", f"{name} {path.name}\n")
        except OSError as error:
            partial.unlink(missing_ok=True)
            raise self._lost(error, f"The photograph of {name} s") from None
        return path

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


def read_photograph(path: Path) -> tuple[np.ndarray, PhotographRecord]:
    """Return a picture, uint8 (height, width, 3), and its record.

    Raises:
        PhotographError: the JPEG is cut or no picture, or its JSON is missing or damaged.
    """
    try:
        with Image.open(path) as image:
            picture = np.asarray(image.convert("RGB"))
    except (OSError, SyntaxError) as error:
        raise PhotographError(f"{path}: the picture is cut or damaged ({error}). Shoot it again.") from None
    try:
        values = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
        fields: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value for name, value in values.items()
        }
        record = PhotographRecord(**fields)
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise PhotographError(f"{path.with_suffix('.json')}: cannot be read ({error}).") from None
    return picture, record


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
    with path.open("a", encoding="utf-8") as file:
        file.write(line)
