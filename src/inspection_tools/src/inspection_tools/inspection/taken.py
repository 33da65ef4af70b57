"""Photographs that were taken: what is stored of each, and which of a plan a folder holds already."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from inspection_tools.geometry import Quaternion, Vector3
from inspection_tools.inspection.parameters import InspectionParameters
from inspection_tools.inspection.todo import Shot, Task
from inspection_tools.photographs.folder import PhotographRecord, photographs_in, read_record


@dataclass(frozen=True)
class StampedPose:
    """The UAV in the map. orientation_xyzw: with roll and pitch. covariance: 36 numbers, as in ROS."""

    stamp_s: float
    place_m: Vector3
    orientation_xyzw: Quaternion
    covariance: tuple[float, ...] = (0.0,) * 36


class Told(Protocol):
    """What the camera told of a photograph."""

    exposure: float
    iso: float
    lux: float
    blur: float


def record_of(
    task: Task, stamp_s: float, body: StampedPose, camera: tuple[Vector3, Quaternion], told: Told
) -> PhotographRecord:
    """Return the record of a photograph. camera: the optical frame in the UAV's frame."""
    turn = Rotation.from_quat(body.orientation_xyzw)
    place_m = np.array(body.place_m) + turn.apply(camera[0])
    optical = (turn * Rotation.from_quat(camera[1])).as_quat()
    x, y, z = place_m.tolist()
    qx, qy, qz, qw = optical.tolist()
    return PhotographRecord(
        stamp_s, (x, y, z), (qx, qy, qz, qw), told.exposure, told.iso, told.lux, told.blur, body.covariance,
        view=task.number,
    )  # fmt: skip


def shot_of(record: PhotographRecord) -> Shot:
    """Return by what a photograph is judged."""
    places = np.reshape(record.covariance, (6, 6))[:3, :3]
    deviation_m = float(np.sqrt(max(np.linalg.eigvalsh(places).max(), 0.0)))
    return Shot(record.blur_px, record.lux, record.iso, deviation_m)


def done_in(folder: Path, parameters: InspectionParameters) -> set[int]:
    """Return the numbers of the plan's photographs that a folder holds, and that are good.

    Raises:
        PhotographError: the record of one is damaged.
    """
    records = [read_record(path.with_suffix(".json")) for path in photographs_in(folder)]
    good = [record for record in records if record.view and not shot_of(record).fault(parameters)]
    return {record.view for record in good}
