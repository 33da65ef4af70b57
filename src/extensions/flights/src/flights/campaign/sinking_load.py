"""Tells whether a UAV could have avoided a load that came down onto it.

From the first instant at which a beam could meet the load, the UAV is given all that it can have: it knows at
once where the load goes, and accelerates with its greatest tilt into the best direction. If it is under the
load all the same, no command could have avoided the contact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

import numpy as np

from simulation_tools.geometry import rotation_matrix
from simulation_tools.sdf.elements import Box
from simulation_tools.sdf.elements.sensors import RaySensor
from simulation_tools.sdf.parser import load_world
from simulation_tools.vehicle.uav import load_uav, mounted
from simulation_tools.world.scripted_motion import ScriptedMotion

ACCELERATION_M_S2 = 9.81
"""Horizontal, with PX4's greatest tilt: MPC_TILTMAX_AIR of 45 degrees and full lift."""
DIVE_M_S = 1.0
"""PX4's MPC_Z_VEL_MAX_DN."""
DIVE_M_S2 = 4.0
"""From a hover, by PX4's MPC_Z_VEL_P_ACC of 4 per s and that speed."""
DELAY_S = 0.048
"""From a command until the acceleration begins to change: response_delay of the Iris, as identified."""
BODY_M = 0.25
"""The Iris reaches so far from its middle in each direction, or farther: to its rotors' tips."""
ROTORS_ABOVE_M = 0.02
"""They turn so far above the origin of its model."""
FORESEEN_S, STEP_S = 4.0, 0.01


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

    lidar_m: its place in the model. looks_up: whether a range finder does.
    """

    elevations_rad: tuple[float, float]
    range_m: float
    lidar_m: tuple[float, float, float]
    looks_up: bool


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


def sight_of(model: str, lidar: str, looks_up: bool) -> Sight:
    """Return what a UAV sees with a lidar.

    Raises:
        SimulationToolsError: there is no such UAV or lidar.
    """
    found = [mounted(*pair) for pair in load_uav(model, lidar).model.sensors(RaySensor)]
    lows, highs = zip(*((m.sensor.vertical.min_angle_rad, m.sensor.vertical.max_angle_rad) for m in found))
    reach_m = max(m.sensor.range_max_m for m in found)
    return Sight((min(lows), max(highs)), reach_m, found[0].pose.position_m, looks_up)


def could_be_avoided(poses: np.ndarray, load: Load, sight: Sight) -> bool:
    """Return whether some command could have avoided a load, from a flight's poses (n, 8: t, xyz, xyzw)."""
    seen = next((k for k, pose in enumerate(poses) if _may_see(pose, load, sight)), None)
    if seen is None or seen == 0:
        return seen == 0
    before = max(0, seen - 5)
    velocity = (poses[seen, 1:4] - poses[before, 1:4]) / (poses[seen, 0] - poses[before, 0])
    return escapes(poses[seen, 0], poses[seen, 1:4], velocity, load)


def escapes(seen_s: float, place_m: np.ndarray, velocity_m_s: np.ndarray, load: Load) -> bool:
    """Return whether a UAV that sees a load from an instant on can be where the load is not.

    After t s it is within 1/2 a (t - delay)^2 of where it would coast to. If all of that is under the load
    when the load is at the rotors, however fast they sink, it cannot.
    """
    half_x, half_y, half_z = (0.5 * edge for edge in load.size_m)
    for t in np.arange(0.0, FORESEEN_S, STEP_S).tolist():
        coasting = place_m + velocity_m_s * t
        rotors_m = max(0.0, place_m[2] + ROTORS_ABOVE_M - dived_m(t))
        ((x, y, _),) = load.seen_from(seen_s + t, coasting[None])
        ((_, _, z),) = load.seen_from(seen_s + t, np.array([[*coasting[:2], rotors_m]]))
        if not -half_z < z < half_z:
            continue
        beyond = np.array((abs(x) - half_x, abs(y) - half_y))
        outside_m = math.hypot(*np.maximum(beyond, 0.0)) + min(0.0, float(beyond.max()))
        if BODY_M - outside_m >= 0.5 * ACCELERATION_M_S2 * max(0.0, t - DELAY_S) ** 2:
            return False
    return True


def dived_m(t: float) -> float:
    """Return how far a UAV that hovers can have dived after t s, m."""
    braked_s = DIVE_M_S / DIVE_M_S2  # until it has its full speed
    diving_s = max(0.0, t - DELAY_S)
    return 0.5 * DIVE_M_S2 * min(diving_s, braked_s) ** 2 + DIVE_M_S * max(0.0, diving_s - braked_s)


def _may_see(pose: Sequence[float], load: Load, sight: Sight) -> bool:
    """Return whether a beam could meet the load from a pose (8,), whatever is in between."""
    time_s, x, y, z, qx, qy, qz, qw = pose
    place, rotation = np.array((x, y, z)), rotation_matrix((qx, qy, qz, qw))
    half = 0.5 * np.array(load.size_m)
    above, up = load.seen_from(time_s, np.array((place, place + rotation[:, 2])))
    if sight.looks_up and _is_met(above, up - above, half):
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
