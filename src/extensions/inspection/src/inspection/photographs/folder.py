"""A folder of photographs: JPEG with EXIF, a JSON beside each, and the lists that other tools read.

`rgb.txt` and `groundtruth.txt` are those of TUM's RGB-D data sets, `calibration.yaml` is that of ROS's
camera_calibration_parsers. A file appears under its name only when it is whole, JPEG and JSON at once.
"""

from __future__ import annotations

import errno
import io
import json
import math
import os
import threading
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import yaml
from PIL import Image

from inspection.camera.survey_camera import SurveyCamera
from inspection.files.whole import write_whole
from inspection.photographs.calibration import calibration_of, read_camera
from inspection.photographs.listing import ORIENTATION, UPRIGHT, records_in
from inspection.photographs.record import PhotographError, PhotographRecord, check_record, stamp_of

JPEG_QUALITY = 92
POSES_HEAD = "# timestamp tx ty tz qx qy qz qw of the optical frame\n"
NAMES_HEAD = "# timestamp filename\n"
MAKE, MODEL, EXPOSURE_TIME, ISO_SPEED, FOCAL_35MM, EXIF_BLOCK = 0x010F, 0x0110, 0x829A, 0x8827, 0xA405, 0x8769
FOCAL_LENGTH, DATE, SUBSECONDS, OFFSET = 0x920A, 0x9003, 0x9291, 0x9011
FOCAL_PLANE_X, FOCAL_PLANE_Y, FOCAL_PLANE_UNIT, CM = 0xA20E, 0xA20F, 0xA210, 3
BODY_SERIAL, LENS_SERIAL = 0xA431, 0xA435
"""Tags of EXIF 2.31."""
FULL_FRAME_MM = 36.0
"""Width of the sensor for which the focal length is told."""
DIAGONAL_35MM = math.hypot(36.0, 24.0)
"""To which the 35 mm equivalent focal length belongs (CIPA DCG-001)."""


class PhotographFolder:
    """Stores photographs of one camera. A folder that is there already is continued.

    Args:
        serial, lens_serial: of the camera and its lens, for EXIF; empty: not known.

    Attributes:
        damaged: a sentence for each photograph there whose record is damaged; it counts as not taken.
    """

    def __init__(self, folder: Path, camera: SurveyCamera, serial: str = "", lens_serial: str = "") -> None:
        """Make the folder; raises PhotographError if that fails, or if it is another camera's."""
        self.folder, self._camera = folder, camera
        self._serials = {BODY_SERIAL: serial, LENS_SERIAL: lens_serial}
        self._lists = threading.Lock()
        self.damaged: list[str] = []
        calibration = folder / "calibration.yaml"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if calibration.exists():
                self._refuse_another_camera(calibration)
            else:
                write_whole({calibration: yaml.safe_dump(calibration_of(camera)).encode()})
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
        lists = {"groundtruth.txt": POSES_HEAD + poses, "rgb.txt": NAMES_HEAD + names}
        write_whole({self.folder / name: text.encode() for name, text in lists.items()})
        return max(
            (s for path in self.folder.glob("*.jpg") if (s := stamp_of(path)) is not None), default=None
        )

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
            check_record(record)
        except (ValueError, TypeError) as error:
            raise PhotographError(f"The photograph of {name} s is not stored: {error}.") from None
        jpeg = io.BytesIO()
        Image.fromarray(picture).save(jpeg, "JPEG", quality=JPEG_QUALITY, exif=self._exif(record).tobytes())
        try:
            pose, line = _lines(path, record)
            with self._lists:
                write_whole({path: jpeg.getvalue(), path.with_suffix(".json"): _json_of(record)})
                _append(self.folder / "groundtruth.txt", pose)
                _append(self.folder / "rgb.txt", line)
        except OSError as error:
            raise self._lost(error, f"The photograph of {name} s") from None
        self.last_stamp_s = max(record.stamp_s, self.last_stamp_s or record.stamp_s)
        return path

    def correct(self, path: Path, record: PhotographRecord) -> None:
        """Replace the record of a stored photograph; raises PhotographError if that fails: the old one stays.

        `correct_lists` brings the lists up to date.
        """
        try:
            write_whole({path.with_suffix(".json"): _json_of(record)})
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
        exif[ORIENTATION] = UPRIGHT
        exif[MAKE], exif[MODEL] = "inspection", f"{self._camera.width} x {self._camera.height}"
        block = exif.get_ifd(EXIF_BLOCK)
        if record.exposure_s is not None:
            block[EXPOSURE_TIME] = record.exposure_s
        if record.iso is not None:
            block[ISO_SPEED] = min(round(record.iso), 65_535)
        focal_mm = FULL_FRAME_MM * self._camera.focal_px / self._camera.width
        per_cm = 10.0 * self._camera.width / FULL_FRAME_MM
        of_35mm = self._camera.focal_px * DIAGONAL_35MM / math.hypot(self._camera.width, self._camera.height)
        block[FOCAL_LENGTH], block[FOCAL_35MM] = focal_mm, round(of_35mm)
        block[FOCAL_PLANE_X], block[FOCAL_PLANE_Y], block[FOCAL_PLANE_UNIT] = per_cm, per_cm, CM
        block.update({tag: value for tag, value in self._serials.items() if value})
        taken = datetime.fromtimestamp(max(record.stamp_s, 0.0), UTC)
        block[DATE], block[SUBSECONDS] = f"{taken:%Y:%m:%d %H:%M:%S}", f"{taken:%f}"
        block[OFFSET] = "+00:00"
        return exif

    def _lost(self, error: OSError, what: str) -> PhotographError:
        why = "the disk is full; free some space" if error.errno == errno.ENOSPC else error.strerror
        return PhotographError(f"{what} cannot be stored in {self.folder}: {why}. Earlier ones are whole.")


def _json_of(record: PhotographRecord) -> bytes:
    return json.dumps(asdict(record), indent=1, allow_nan=False).encode()


def _lines(path: Path, record: PhotographRecord) -> tuple[str, str]:
    """Return a photograph's lines in groundtruth.txt and rgb.txt."""
    pose = " ".join(f"{x:.6f}" for x in (*record.position_m, *record.orientation_xyzw))
    stamp = f"{record.stamp_s:.6f}" if stamp_of(path) is None else path.stem
    return f"{stamp} {pose}\n", f"{stamp} {path.name}\n"


def _append(path: Path, line: str) -> None:
    """Append a line, whole or not at all."""
    length = path.stat().st_size if path.exists() else 0
    try:
        with path.open("a", encoding="utf-8") as file:
            file.write(line)
    except OSError:
        os.truncate(path, length)
        raise
