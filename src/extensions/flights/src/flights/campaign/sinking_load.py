"""Tells whether a UAV could have avoided a load that came down onto it.

The rule: a contact is unavoidable if no command that the UAV can fly avoids the load, from the first beam on
that could meet the load. The UAV needs one period of its lidar to see it. Then it knows where the load goes,
and flies by its own response, with the numbers that CEPA counts on (`flights.campaign.evasion`). What it
flies until then, it has been told before: that is taken from the flight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

import numpy as np

from cepa.identification.response import ResponseModel
from flights.campaign.evasion import Start, heights_m, level_flights, lifted_m, times_s
from simulation_tools.geometry import rotation_matrix
from simulation_tools.sdf.elements import Box, Cylinder, Geometry
from simulation_tools.sdf.elements.sensors import RaySensor
from simulation_tools.sdf.parser import load_world
from simulation_tools.vehicle.uav import load_uav, mounted
from simulation_tools.world.scripted_motion import ScriptedMotion

FINDER = "range_finder_up"
NO_BEAMS = np.empty((0, 2, 3))
LAST_S, LOOK_AGAIN_S = 0.1, 0.05
"""Of a contact: a command that shows its effect so shortly before changes nothing. Between two looks."""
FARTHEST_PART_M = 0.5
"""No part of the UAV is farther from its middle."""
FITTED_S = 0.12
"""From so much of a flight its velocity and acceleration are taken."""


@dataclass(frozen=True)
class Load:
    """A box that moves by its script. It stands upright."""

    size_m: tuple[float, float, float]
    motion: ScriptedMotion

    def seen_from(self, time_s: float, places: np.ndarray) -> np.ndarray:
        """Return places (n, 3), m in `world`, along the load's axes from its middle at a time."""
        state = self.motion.state(time_s)
        assert state is not None  # the scripts of drawn worlds begin at once and do not end before the flight
        return (places - state.pose.position_m - (0.0, 0.0, 0.5 * self.size_m[2])) @ rotation_matrix(
            state.pose.orientation_xyzw
        )


@dataclass(frozen=True)
class Sight:
    """Which directions the UAV's beams have. elevations_rad: of the lowest and the highest channel.

    lidar_m: its place in the model. finder: beams of a range finder that looks up (n, 2, 3): start, m, and
    direction in the model. period_s: of the lidar.
    """

    elevations_rad: tuple[float, float]
    range_m: float
    lidar_m: tuple[float, float, float]
    finder: np.ndarray
    period_s: float


@dataclass(frozen=True)
class Uav:
    """What it sees, where it may be touched, and how it follows.

    cylinders_m: (n, 5) within its shapes: the middle in the model, radius, and half of the height.
    """

    sight: Sight
    cylinders_m: np.ndarray
    response: ResponseModel


def load_in(world: Path) -> Load | None:
    """Return the first box that a script moves in a world's file, or None.

    Raises:
        SimulationToolsError: the file cannot be read.
    """
    for model in load_world(str(world)).models:
        for link in model.links:
            for shape in link.collisions:
                if model.script is not None and isinstance(shape.geometry, Box):
                    return Load(shape.geometry.size_m, ScriptedMotion(model.script))
    return None


def uav_of(model: str, lidar: str, looks_up: bool, response: ResponseModel) -> Uav:
    """Return a UAV with a lidar.

    Raises:
        SimulationToolsError: there is no such UAV or lidar.
    """
    uav = load_uav(model, lidar).model
    found = [mounted(*pair) for pair in uav.sensors(RaySensor)]
    lows, highs = zip(*((m.sensor.vertical.min_angle_rad, m.sensor.vertical.max_angle_rad) for m in found))
    reach_m, lidar_m = max(m.sensor.range_max_m for m in found), found[0].pose.position_m
    period_s = 1.0 / max(m.sensor.update_rate_hz for m in found)
    finder = _beams_of_finder(model) if looks_up else NO_BEAMS
    sight = Sight((min(lows), max(highs)), reach_m, lidar_m, finder, period_s)
    shapes = [(link.pose @ shape.pose, shape.geometry) for link in uav.links for shape in link.collisions]
    within = [(*pose.position_m, *_cylinder_in(shape)) for pose, shape in shapes]
    return Uav(sight, np.array(within), response)


def _beams_of_finder(model: str) -> np.ndarray:
    """Return the outermost beams (n, 2, 3) of the range finder that looks up, and its middle one."""
    beams = []
    for link, sensor in load_uav(model, sensors=(FINDER,)).model.sensors(RaySensor):
        pose, (across, along) = mounted(link, sensor).pose, (sensor.horizontal, sensor.vertical)
        for a in (across.min_angle_rad, 0.0, across.max_angle_rad):
            for b in (along.min_angle_rad, 0.0, along.max_angle_rad):
                ahead = np.array((math.cos(b) * math.cos(a), math.cos(b) * math.sin(a), math.sin(b)))
                beams.append((pose.position_m, rotation_matrix(pose.orientation_xyzw) @ ahead))
    return np.array(beams)


def _cylinder_in(shape: Geometry) -> tuple[float, float]:
    """Return radius and half height, m, of an upright cylinder in an upright shape; 0: of another shape."""
    if isinstance(shape, Cylinder):
        return shape.radius_m, 0.5 * shape.length_m
    return (0.5 * min(shape.size_m[:2]), 0.5 * shape.size_m[2]) if isinstance(shape, Box) else (0.0, 0.0)


def could_be_avoided(poses: np.ndarray, load: Load, uav: Uav) -> bool:
    """Return whether some command could have avoided a load, from a flight's poses (n, 8: t, xyz, xyzw).

    A UAV may lean more and faster than CEPA counts on. So what it has flown counts as what it can fly, too:
    if it can escape from where it was later, it could.
    """
    seen = next((k for k, pose in enumerate(poses) if _may_see(pose, load, uav.sight)), None)
    if seen is None or seen == 0:
        return seen == 0
    acts_s = poses[seen, 0] + uav.sight.period_s + uav.response.delay_s
    if acts_s > poses[-1, 0]:
        return False
    later_s = np.arange(acts_s + LOOK_AGAIN_S, poses[-1, 0] - LAST_S, LOOK_AGAIN_S).tolist()
    return any(escapes(start_at(time_s, poses), load, uav) for time_s in (acts_s, *later_s))


def escapes(start: Start, load: Load, uav: Uav) -> bool:
    """Return whether a UAV that knows a load can be where the load is not, from `start` on.

    It keeps its yaw. Its cylinders count as upright, and its lean lifts those that are nearer to the load.
    """
    half = 0.5 * np.array(load.size_m)
    (paths_m, accelerations), all_m = level_flights(start, uav.response), heights_m(start)
    c, s = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
    is_hit = np.zeros((len(all_m), len(paths_m)), np.bool_)
    for k, t in enumerate(times_s().tolist()):
        low_m = float(load.seen_from(start.time_s + t, np.zeros((1, 3)))[0, 2])
        if low_m + all_m[:, k].max() < -half[2] - FARTHEST_PART_M:
            continue  # all of the load is still over the UAV
        for x, y, z, radius_m, half_m in uav.cylinders_m.tolist():
            offset_m = np.array((c * x - s * y, s * x + c * y))
            lifted = lifted_m(offset_m, accelerations[:, k])
            is_level = np.abs(low_m + z + all_m[:, k, None] + lifted) < half[2] + half_m
            (near,) = np.nonzero((is_level & ~is_hit).any(axis=0))
            places = np.column_stack((paths_m[near, k] + offset_m, np.zeros(len(near))))
            beyond = np.abs(load.seen_from(start.time_s + t, places)[:, :2]) - half[:2]
            outside_m = np.hypot(*np.maximum(beyond, 0.0).T) + np.minimum(0.0, beyond.max(axis=1))
            is_hit[:, near] |= is_level[:, near] & (outside_m < radius_m)
    return not is_hit.all()


def start_at(time_s: float, poses: np.ndarray) -> Start:
    """Return how a UAV flies at a time of a flight (n, 8)."""
    last = int(np.searchsorted(poses[:, 0], time_s, side="right"))
    first = int(np.searchsorted(poses[:, 0], time_s - FITTED_S))
    fit = np.polyfit(poses[first:last, 0] - time_s, poses[first:last, 1:4], min(3, last - first - 1))
    rates = [np.polyder(column, k) for k in range(3) for column in fit.T]
    place, velocity, acceleration = np.array([np.polyval(rate, 0.0) for rate in rates]).reshape(3, 3)
    qx, qy, qz, qw = poses[last - 1, 4:].tolist()
    ahead, aside, _ = rotation_matrix((qx, qy, qz, qw))[:, 0]
    return Start(time_s, place, velocity, acceleration, math.atan2(aside, ahead))


def _may_see(pose: Sequence[float], load: Load, sight: Sight) -> bool:
    """Return whether a beam could meet the load from a pose (8,), whatever is in between."""
    time_s, x, y, z, qx, qy, qz, qw = pose
    place, rotation = np.array((x, y, z)), rotation_matrix((qx, qy, qz, qw))
    half = 0.5 * np.array(load.size_m)
    for start, direction in sight.finder:
        above, further = load.seen_from(time_s, place + np.array((start, start + direction)) @ rotation.T)
        if _is_met(above, further - above, half):
            return True
    origin, *axes = load.seen_from(time_s, place + np.vstack((np.zeros(3), np.eye(3))) @ rotation.T)
    from_lidar = (_surface(half) - origin) @ (np.array(axes) - origin).T - sight.lidar_m
    level_m = np.hypot(from_lidar[:, 0], from_lidar[:, 1])
    elevations = np.arctan2(from_lidar[:, 2], level_m)[level_m < sight.range_m]
    low, high = sight.elevations_rad
    return bool(len(elevations)) and bool(elevations.min() <= high and elevations.max() >= low)


def _is_met(start: np.ndarray, direction: np.ndarray, half: np.ndarray) -> bool:
    """Return whether a ray from ``start`` (3,) meets a box of half edges ``half`` (3,) around the origin."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort(np.array((-half - start, half - start)) / direction, axis=0)
    return bool(np.nanmax(ends[0]) <= np.nanmin(ends[1]) and np.nanmin(ends[1]) >= 0.0)


def _surface(half: np.ndarray) -> np.ndarray:
    """Return points (n, 3) on the upright edges and faces of a box, bottom to top."""
    steps = np.linspace(-1.0, 1.0, 9)
    x, y, z = (axis.ravel() for axis in np.meshgrid(steps, steps, steps))
    is_on = np.maximum(np.abs(x), np.maximum(np.abs(y), np.abs(z))) == 1.0
    return np.column_stack((x, y, z))[is_on] * half
