"""Poses by the times of the pictures, from SLAM's path and odometry of the flight."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Callable, Mapping, NamedTuple, Sequence

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from flight_basics.geometry import Quaternion, Vector3, yaw_of
from inspection.flight.slam_path import LevelPose, OdometryTrack, SlamPath, corrections
from inspection.photograph_poses.exif import Exif
from inspection.photograph_poses.pose import Pose, Poses
from inspection.photographs.listing import LeftOut
from inspection.photographs.record import PhotographError

GAP_S = 0.5
"""Between two poses that are farther apart, nobody knows where the UAV was."""


class Track(NamedTuple):
    """Poses of the UAV: stamps_s (n,), in order; places_m (n, 3); turns (n, 4), quaternions x, y, z, w."""

    stamps_s: np.ndarray
    places_m: np.ndarray
    turns: np.ndarray


@dataclass(frozen=True)
class Flight:
    """What a bag tells of a flight.

    path: SLAM's last one, in the map. odometry: in its own frame; None: there is none. mount: where the
    camera's optical frame was in the UAV's at a time, s; None: not known then.
    """

    path: Track
    odometry: Track | None
    mount: Callable[[float], tuple[Vector3, Quaternion] | None]

    def in_map(self) -> Track:
        """Return where the UAV was: odometry that follows SLAM's path; the path itself without odometry."""
        if self.odometry is None:
            return self.path
        track, odometry = OdometryTrack(), self.odometry
        for stamp_s, place_m, turn in zip(*odometry):
            x, y, z = place_m.tolist()
            track.note(float(stamp_s), LevelPose((x, y, z), yaw_of(tuple(turn.tolist()))))
        yaws = [yaw_of(tuple(each)) for each in self.path.turns.tolist()]
        slam_path = SlamPath(self.path.stamps_s, np.column_stack((self.path.places_m, yaws)))
        known_s, moves = corrections(slam_path, track)
        if not len(known_s):
            raise PhotographError("The bag's odometry and SLAM's path have no times in common.")
        inside = (odometry.stamps_s >= known_s[0]) & (odometry.stamps_s <= known_s[-1])
        stamps_s = odometry.stamps_s[inside]
        x, y, z, yaw = (np.interp(stamps_s, known_s, each) for each in moves.T)
        if not len(stamps_s):
            raise PhotographError(
                "The bag has no odometry between the first and the last pose of SLAM's path."
            )
        turned = Rotation.from_rotvec(np.column_stack((np.zeros((len(yaw), 2)), yaw)))
        shift = np.column_stack((x, y, np.where(np.isnan(z), 0.0, z)))
        places_m = turned.apply(odometry.places_m[inside]) + shift
        return Track(stamps_s, places_m, (turned * Rotation.from_quat(odometry.turns[inside])).as_quat())


def poses_of_flight(
    told: Mapping[Path, Exif], flight: Flight, clock_s: float = 0.0, is_level: bool = False
) -> Poses:
    """Return the poses of photographs by their times.

    clock_s: that the camera's clock is behind the bag's. is_level: a gimbal keeps the camera level, so that
        the UAV's roll and pitch do not count.

    Raises:
        PhotographError: no photograph was taken while the pose is known.
    """
    track, gap_s = flight.in_map(), GAP_S if flight.odometry is not None else 4.0 * GAP_S
    times = {path: each.taken for path, each in told.items() if each.taken is not None}
    left_out = [
        LeftOut(each.name, "It tells no time (EXIF's DateTimeOriginal).")
        for each in told
        if each not in times
    ]
    _check_times([each.value + clock_s for each in times.values()], track)
    poses = dict[Path, Pose]()
    for path, taken in times.items():
        taken_s = taken.value + clock_s
        here, mount = pose_at(track, taken_s, gap_s), flight.mount(taken_s)
        if here is None or mount is None:
            what = "where the UAV was" if here is None else "how the camera was mounted"
            left_out.append(LeftOut(path.name, f"The bag does not tell {what} at {taken_s:.3f} s."))
            continue
        beside = [pose_at(track, taken_s + sign * taken.deviation, gap_s) for sign in (-1.0, 1.0)]
        poses[path] = replace(
            _mounted(here, mount, is_level, taken_s),
            source=f"the flight at {taken.source}",
            deviation=max((float(np.linalg.norm(each[0] - here[0])) for each in beside if each), default=0.0),
            turned_rad=max(
                (float((each[1] * here[1].inv()).magnitude()) for each in beside if each), default=0.0
            ),
        )
    return Poses(poses, tuple(left_out))


def _check_times(times: Sequence[float], track: Track) -> None:
    first_s, last_s = float(track.stamps_s[0]), float(track.stamps_s[-1])
    if times and not any(first_s <= each <= last_s for each in times):
        raise PhotographError(
            f"The bag knows the UAV's pose from {first_s:.3f} to {last_s:.3f} s, and the photographs were "
            "taken from "
            f"{min(times):.3f} to {max(times):.3f} s. If the clocks differ, give "
            "--clock: the seconds that the camera's is behind."
        )


def pose_at(track: Track, stamp_s: float, gap_s: float = GAP_S) -> tuple[np.ndarray, Rotation] | None:
    """Return place (3,) and turn at a time, between two poses; None: the nearest ones are too far apart."""
    known_s = track.stamps_s
    if not known_s[0] <= stamp_s <= known_s[-1]:
        return None
    if len(known_s) == 1:
        return track.places_m[0], Rotation.from_quat(track.turns[0])
    later = int(np.clip(np.searchsorted(known_s, stamp_s), 1, len(known_s) - 1))
    pair = slice(later - 1, later + 1)
    if known_s[later] - known_s[later - 1] > gap_s and stamp_s not in known_s[pair]:
        return None
    place_m = np.array([np.interp(stamp_s, known_s[pair], each) for each in track.places_m[pair].T])
    return place_m, Slerp(known_s[pair], Rotation.from_quat(track.turns[pair]))(stamp_s)


def _mounted(
    here: tuple[np.ndarray, Rotation], mount: tuple[Vector3, Quaternion], is_level: bool, stamp_s: float
) -> Pose:
    place_m, turn = here
    if is_level:
        qx, qy, qz, qw = turn.as_quat().tolist()
        turn = Rotation.from_euler("z", yaw_of((qx, qy, qz, qw)))
    at_m = place_m + turn.apply(mount[0])
    pose = Pose.of_axes(at_m, (turn * Rotation.from_quat(mount[1])).as_matrix())
    return replace(pose, stamp_s=stamp_s)
