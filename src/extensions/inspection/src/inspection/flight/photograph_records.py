"""What is stored of each photograph that was taken, and which of a plan a folder holds already."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import MISSING, dataclass, replace
from pathlib import Path
from typing import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from flight_basics.checks import check_limits, limited
from flight_basics.errors import ParameterError
from flight_basics.geometry import Quaternion, Vector3
from inspection.flight.parameters import InspectionParameters
from inspection.flight.photograph_quality import PhotographQuality
from inspection.flight.photograph_queue import Task
from inspection.flight.slam_path import LevelPose
from inspection.flight.viewpoints import Viewpoints, row_of
from inspection.photographs.listing import records_in
from inspection.photographs.record import PhotographRecord
from inspection.survey.views.candidates import View

POSES = 100
PLACE_VARIANCES = (0, 7, 14)
"""Of x, y and z in a covariance of 6 x 6, row by row."""
MATCH_S = 0.5
"""A scan's match tells of poses that are at most so far from its stamp."""
UNKNOWN_M2 = 1e6
"""Variance of a place that nobody knows: a kilometre."""
UNKNOWN = tuple(float(value) for value in np.diag(np.full(6, UNKNOWN_M2)).ravel())
"""In place of a covariance that is none, 36 numbers."""


@dataclass(frozen=True)
class StampedPose:
    """The UAV in the map. orientation_xyzw: with roll and pitch. covariance: 36 numbers, as in ROS.

    deviation_m: standard deviation of the place that the covariance does not know of: SLAM is not sure, or
    has just moved the pose. odom_in_map: with which the pose was made; None: the pose is not SLAM's.
    """

    stamp_s: float
    place_m: Vector3
    orientation_xyzw: Quaternion
    covariance: tuple[float, ...] = (0.0,) * 36
    deviation_m: float = 0.0
    odom_in_map: LevelPose | None = None


class RecentPoses:
    """The UAV's last poses, so that a photograph finds the one of its stamp. Any thread may call."""

    def __init__(self) -> None:
        self._poses: deque[StampedPose] = deque(maxlen=POSES)
        self._matches: deque[tuple[float, tuple[float, ...]]] = deque(maxlen=POSES)
        self._lock = threading.Lock()

    def note(self, pose: StampedPose) -> None:
        """Take a pose. After a clock that was set back, those of the same stamps do not count any more."""
        known = replace(pose, covariance=covariance_of(pose.covariance))
        with self._lock:
            while self._poses and self._poses[-1].stamp_s > pose.stamp_s:
                self._poses.pop()
            self._poses.append(known)

    def note_match(self, stamp_s: float, covariance: tuple[float, ...]) -> None:
        """Take how well the scan of this stamp matched, 36 numbers as in ROS.

        It counts in place of the pose's own covariance: that of odometry has its drift, which SLAM corrects.
        """
        known = covariance_of(covariance)
        with self._lock:
            self._matches.append((stamp_s, known))

    def at(self, stamp_s: float) -> StampedPose:
        """Return the pose nearest to a stamp. There must be one."""
        with self._lock:
            pose = min(self._poses, key=lambda each: abs(each.stamp_s - stamp_s))
            matches = [each for each in self._matches if abs(each[0] - stamp_s) <= MATCH_S]
        covariance = min(matches, key=lambda each: abs(each[0] - stamp_s))[1] if matches else pose.covariance
        return replace(pose, covariance=_widened(covariance, pose.deviation_m))


def _widened(covariance: tuple[float, ...], deviation_m: float) -> tuple[float, ...]:
    """Return a covariance, 36 numbers, of a place that has another deviation beside, m."""
    return tuple(
        value + deviation_m**2 * (index in PLACE_VARIANCES) for index, value in enumerate(covariance)
    )


def covariance_of(told: Sequence[float]) -> tuple[float, ...]:
    """Return a covariance, 36 numbers as in ROS; `UNKNOWN` for what is none.

    What is not finite, negative, or greater than that says that the pose is not known.
    """
    values = np.asarray(told, float)
    if values.shape != (36,) or not (np.abs(values) <= UNKNOWN_M2).all() or (values[::7] < 0.0).any():
        return UNKNOWN
    return tuple(values.tolist())


@dataclass(frozen=True)
class ShutterAnswer:
    """What the camera told of a photograph. position_m, orientation_xyzw: of the optical frame in the UAV's.

    The others are those of Shoot.srv.

    Raises:
        ParameterError: one of them is negative, or no number.
    """

    stamp_s: float
    position_m: Vector3
    orientation_xyzw: Quaternion
    exposure: float = limited(MISSING, 0.0)
    iso: float = limited(MISSING, 0.0)
    lux: float = limited(MISSING, 0.0)
    blur: float = limited(MISSING, 0.0)
    shift: float = limited(MISSING, 0.0)
    turn: float = limited(MISSING, 0.0)

    def __post_init__(self) -> None:
        check_limits(self, ParameterError)


def record_of(task: Task, body: StampedPose, told: ShutterAnswer) -> PhotographRecord:
    """Return the record of a photograph."""
    turn = Rotation.from_quat(body.orientation_xyzw)
    place_m = np.array(body.place_m) + turn.apply(told.position_m)
    optical = (turn * Rotation.from_quat(told.orientation_xyzw)).as_quat()
    x, y, z = place_m.tolist()
    qx, qy, qz, qw = optical.tolist()
    return PhotographRecord(
        told.stamp_s, (x, y, z), (qx, qy, qz, qw), told.exposure, told.iso, told.lux, told.blur,
        body.covariance, view=task.number, shift_m=told.shift, turn_rad=told.turn,
        viewpoint=row_of(task.view),
    )  # fmt: skip


def quality_of(record: PhotographRecord) -> PhotographQuality:
    """Return by what a photograph is judged."""
    places = np.reshape(record.covariance, (6, 6))[:3, :3]
    deviation_m = float(np.sqrt(max(np.linalg.eigvalsh(places).max(), 0.0)))
    lux, iso = record.lux or 0.0, record.iso or 0.0  # where nobody told the light, it counts as dark
    return PhotographQuality(record.blur_px, lux, iso, deviation_m, record.shift_m, record.turn_rad)


def done_in(folder: Path, parameters: InspectionParameters, views: Sequence[View]) -> set[int]:
    """Return the numbers of a plan's photographs that a folder holds, and that are good.

    Closer looks have numbers below 0. A photograph whose record is damaged is not good. One that was taken
    for a viewpoint that the plan does not have belongs to another plan, or to this one before it was edited.

    views: of the plan, in its order.
    """
    viewpoints, done = Viewpoints(views, parameters.far), set[int]()
    for _, record in records_in(folder)[0]:
        if not _fault(record, parameters):
            done |= {record.view} if record.view < 0 else viewpoints.shown_by(record)
    return done


def _fault(record: PhotographRecord, parameters: InspectionParameters) -> str:
    return quality_of(record).fault(parameters, is_closer=record.view < 0)
