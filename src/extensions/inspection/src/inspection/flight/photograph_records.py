"""What is stored of each photograph that was taken, and which of a plan a folder holds already."""

from __future__ import annotations

import math
import threading
from collections import deque
from dataclasses import MISSING, dataclass, replace
from pathlib import Path
from typing import Sequence

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

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

KEPT_S = 30.0
"""So long poses are kept: a camera may answer 20 s after its shutter."""
GAP_S = 0.5
"""Between two poses that are farther apart, nobody knows where the UAV was."""
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
        self._poses: deque[StampedPose] = deque()
        self._matches: deque[tuple[float, tuple[float, ...]]] = deque()
        self._lock = threading.Lock()

    def note(self, pose: StampedPose) -> None:
        """Take a pose. Those of its stamp or a later one do not count any more: the clock was set back."""
        known = replace(pose, covariance=covariance_of(pose.covariance))
        with self._lock:
            while self._poses and self._poses[-1].stamp_s >= pose.stamp_s:
                self._poses.pop()
            self._poses.append(known)
            while self._poses[0].stamp_s < pose.stamp_s - KEPT_S:
                self._poses.popleft()

    def note_match(self, stamp_s: float, covariance: tuple[float, ...]) -> None:
        """Take how well the scan of this stamp matched, 36 numbers as in ROS.

        It counts in place of the pose's own covariance: that of odometry has its drift, which SLAM corrects.
        """
        known = covariance_of(covariance)
        with self._lock:
            self._matches.append((stamp_s, known))
            while self._matches[0][0] < stamp_s - KEPT_S:
                self._matches.popleft()

    def at(self, stamp_s: float) -> StampedPose:
        """Return the pose at a stamp, between two poses. There must be one.

        Where there are none around it, it is the nearest one, and may be off by as far as the UAV flies
        meanwhile; farther than `GAP_S` from it nobody knows the place.
        """
        with self._lock:
            poses = list(self._poses)
            matches = [each for each in self._matches if abs(each[0] - stamp_s) <= MATCH_S]
        pose, off_m = _between(poses, stamp_s)
        covariance = min(matches, key=lambda each: abs(each[0] - stamp_s))[1] if matches else pose.covariance
        return replace(pose, covariance=_widened(covariance, math.hypot(pose.deviation_m, off_m)))


def _between(poses: Sequence[StampedPose], stamp_s: float) -> tuple[StampedPose, float]:
    """Return the pose at a stamp, of poses in their order, and how far it may be off, m."""
    k = int(np.clip(np.searchsorted([each.stamp_s for each in poses], stamp_s), 1, max(len(poses) - 1, 1)))
    pair = poses[k - 1 : k + 1]
    nearest = min(pair, key=lambda each: abs(each.stamp_s - stamp_s))
    away_s = abs(nearest.stamp_s - stamp_s)
    if away_s == 0.0:
        return nearest, 0.0
    if away_s > GAP_S or len(pair) < 2:
        return nearest, math.sqrt(UNKNOWN_M2) if away_s > GAP_S else 0.0
    first, second = pair
    length_s = second.stamp_s - first.stamp_s
    share = (stamp_s - first.stamp_s) / length_s
    if length_s > GAP_S or not 0.0 < share < 1.0 or first.odom_in_map != second.odom_in_map:
        return nearest, math.dist(first.place_m, second.place_m) * away_s / length_s
    x, y, z = (a + share * (b - a) for a, b in zip(first.place_m, second.place_m))
    ends = Rotation.from_quat([first.orientation_xyzw, second.orientation_xyzw])
    qx, qy, qz, qw = Slerp([0.0, 1.0], ends)(share).as_quat().tolist()
    return replace(nearest, place_m=(x, y, z), orientation_xyzw=(qx, qy, qz, qw)), 0.0


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
        viewpoint=row_of(task.view), source="odometry" if body.odom_in_map is None else "SLAM",
    )  # fmt: skip


def quality_of(record: PhotographRecord) -> PhotographQuality:
    """Return by what a photograph is judged."""
    deviation_m, _ = record.deviations
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
