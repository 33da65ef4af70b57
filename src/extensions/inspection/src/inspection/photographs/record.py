"""What is known of a photograph: the JSON beside it."""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flight_basics.errors import FlightBasicsError
from input_schemas import read_made, structured
from inspection.camera.photograph_pose import PhotographPose


class PhotographError(FlightBasicsError):
    """A photograph cannot be stored or read."""


@dataclass(frozen=True)
class PhotographRecord:
    """What is known of a photograph.

    position_m, orientation_xyzw: of the optical frame (x right, y down, z ahead) in the map. covariance: 36
    numbers, row by row, of x, y, z and the rotation about x, y, z. exposure_s, iso, lux: of the picture,
    lux in its middle; None: not known. blur_px: by motion and turning during the exposure, the longest.
    patches: of the surface, seen in it. view: number of the photograph in the plan that it was taken for;
    0: none. shift_m, turn_rad: that the camera moved and turned during the exposure; None: only blur_px is
    known. viewpoint: for which it was taken: x, y, z in m, yaw and tilt in rad, in the map; None: not
    known. A plan that is edited gives other numbers, so this tells what a photograph was taken for.
    told_position_m, told_orientation_xyzw: the pose as it was told first, before SLAM's path moved the
    photograph; None: it did not. source: of the pose, in words; empty: not told.
    """

    stamp_s: float
    position_m: tuple[float, float, float]
    orientation_xyzw: tuple[float, float, float, float]
    exposure_s: float | None = None
    iso: float | None = None
    lux: float | None = None
    blur_px: float = 0.0
    covariance: tuple[float, ...] = (0.0,) * 36
    patches: tuple[int, ...] = ()
    view: int = 0
    shift_m: float | None = None
    turn_rad: float | None = None
    viewpoint: tuple[float, float, float, float, float] | None = None
    told_position_m: tuple[float, float, float] | None = None
    told_orientation_xyzw: tuple[float, float, float, float] | None = None
    source: str = ""

    @property
    def pose(self) -> PhotographPose:
        """Where the camera was, and how the picture is blurred."""
        taken = PhotographPose.of_pose(self.position_m, self.orientation_xyzw, self.blur_px)
        off_m, off_rad = self.deviations
        return replace(taken.moved(self.shift_m, self.turn_rad), off_m=off_m, off_rad=off_rad)

    @property
    def deviations(self) -> tuple[float, float]:
        """Standard deviations of the place, m, and of the direction, along the axes that are known least."""
        covariance = np.reshape(self.covariance, (6, 6))
        blocks = covariance[:3, :3], covariance[3:, 3:]
        place_m, turn = (float(np.sqrt(max(np.linalg.eigvalsh(each).max(), 0.0))) for each in blocks)
        return place_m, turn


def read_record(path: Path) -> PhotographRecord:
    """Return what a photograph's JSON tells; raises PhotographError if it is missing or damaged.

    Keys that are not known here are ignored: a newer program may have written the folder.
    """

    def made(content: object) -> PhotographRecord:
        if isinstance(content, dict) and content.get("stamp_s") is None:
            content = {**content, "stamp_s": stamp_of(path) or 0.0}
        record = structured(content, PhotographRecord, PhotographError, other_keys=True)
        try:
            check_record(record)
        except (ValueError, TypeError) as error:
            raise PhotographError(f"{error}.") from None
        return record

    return read_made(path, "The record", made, PhotographError)


def stamp_of(path: Path) -> float | None:
    """Return the stamp, s, in a file's name; None: it is no number. 20260501_101500 is none."""
    if "_" in path.stem:
        return None
    with contextlib.suppress(ValueError):
        if math.isfinite(stamp_s := float(path.stem)):
            return stamp_s
    return None


def check_record(record: PhotographRecord) -> None:
    """Raise ValueError or TypeError if the record has no pose and no numbers."""
    sizes = [("position_m", 3), ("orientation_xyzw", 4), ("covariance", 36)]
    if record.viewpoint is not None:
        sizes.append(("viewpoint", 5))
    for name, size in sizes:
        values = np.array(getattr(record, name), float)
        if values.shape != (size,) or not np.isfinite(values).all():
            raise ValueError(f"{name} must be {size} finite numbers")
    if abs(np.linalg.norm(record.orientation_xyzw) - 1.0) > 0.01:
        raise ValueError("orientation_xyzw must be a unit quaternion")
    for name in ("stamp_s", "exposure_s", "iso", "lux", "blur_px", "view"):
        value = getattr(record, name)
        is_optional = name in ("exposure_s", "iso", "lux")
        if not (value is None and is_optional) and not math.isfinite(float(value)):
            raise ValueError(f"{name} must be a finite number")
    for name in ("blur_px", "shift_m", "turn_rad"):
        value = getattr(record, name)
        if value is not None and not 0.0 <= value < math.inf:
            raise ValueError(f"{name} must be a finite number, not negative")
