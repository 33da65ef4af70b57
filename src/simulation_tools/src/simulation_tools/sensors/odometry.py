"""Odometry that drifts like a real one: without bound, but never in jumps.

The UAV's own motion is measured with a scale error, a heading bias and white noise, all of which grow with
the way travelled, not with time: a UAV that hovers does not drift. Height, roll and pitch
are exact, as a barometer and an accelerometer would keep them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flight_basics.checks import check_limits, limited
from kernel_cache.compiler import njit
from simulation_tools.compiled_geometry import quaternion_from_rpy, quaternion_multiply, yaw_from_quaternion
from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Pose, Quaternion, Vector3

TELEPORT_SPEED_M_S = 100.0
"""A faster move comes from a call (``/gazebo/set_model_state``), and odometry does not measure it."""


class OdometryError(SimulationToolsError):
    """The parameters of the drift are not sensible."""


@dataclass(frozen=True)
class OdometryParameters:
    """How odometry drifts.

    Raises:
        OdometryError: a value makes no sense.
    """

    scale_error: float = limited(0.01, above=-1.0)
    """Measured way over true way, less one."""
    heading_bias_rad_per_m: float = limited(0.002)
    """Measured turn to the left while flying straight, rad per m."""
    position_noise_m_per_sqrt_m: float = limited(0.02, 0.0)
    """Standard deviation along x and along y after one metre, m."""
    heading_noise_rad_per_sqrt_m: float = limited(0.01, 0.0)
    """Standard deviation of the heading after one metre travelled, rad."""
    heading_noise_rad_per_sqrt_rad: float = limited(0.02, 0.0)
    """Standard deviation of the heading after one radian turned, rad."""

    def __post_init__(self) -> None:
        check_limits(self, OdometryError, "The odometry's {}")

    @classmethod
    def none(cls) -> OdometryParameters:
        """Return the parameters of an odometry without drift."""
        return cls(0.0, 0.0, 0.0, 0.0, 0.0)


class OdometrySample(NamedTuple):
    """pose: of the body in `odom`. Velocities in body axes, as ``nav_msgs/Odometry`` has them."""

    pose: Pose
    linear_velocity_m_s: Vector3
    angular_velocity_rad_s: Vector3


class DriftingOdometry:
    """Integrates the true motion between updates, with errors. The frame `odom` starts where `world` is."""

    def __init__(self, parameters: OdometryParameters, initial_pose: Pose, rng: np.random.Generator) -> None:
        """Start at the true initial_pose (world frame); rng: source of the noise."""
        self._exact = parameters == OdometryParameters.none()
        self._scale = 1.0 + parameters.scale_error
        variances = parameters.heading_noise_rad_per_sqrt_m**2, parameters.heading_noise_rad_per_sqrt_rad**2
        bias, noise_m = parameters.heading_bias_rad_per_m, parameters.position_noise_m_per_sqrt_m
        self._errors = np.array((self._scale, bias, noise_m, *variances))
        self._initial_pose = initial_pose
        self._rng = rng
        self._track = np.zeros(6)  # x, y and yaw: the true ones, then those of odometry
        self.reset()

    def reset(self) -> None:
        """Forget the path so far and start at the initial pose again."""
        x, y, _ = self._initial_pose.position_m
        self._true_xy = x, y
        self._track[:] = (x, y, self._initial_pose.yaw_rad) * 2

    def update(self, truth: OdometrySample, dt_s: float) -> OdometrySample:
        """Take in the truth (pose in `world`) dt_s after the last update; return what odometry says."""
        if self._exact:
            return truth
        pose, (vx, vy, vz), turning = truth
        (x, y, z), q = pose.position_m, pose.orientation_xyzw
        way_m = math.hypot(x - self._true_xy[0], y - self._true_xy[1])
        self._true_xy = x, y
        counts = way_m <= TELEPORT_SPEED_M_S * dt_s + 0.01
        normals = self._rng.standard_normal(3)
        xy, orientation = _drift(self._track, self._errors, x, y, q, way_m, counts, normals)
        return OdometrySample(
            Pose((xy[0], xy[1], z), orientation), (self._scale * vx, self._scale * vy, vz), turning
        )


@njit(cache=True)
def _drift(
    track: np.ndarray,
    errors: np.ndarray,
    x: float,
    y: float,
    q: Quaternion,
    way: float,
    counts: bool,
    normals: np.ndarray,
) -> tuple[tuple[float, float], Quaternion]:
    """Advance the track (6,) to the true x, y and orientation q; return x, y and orientation in `odom`.

    errors: scale, heading bias, noise of the position, variances of the heading by the way and by the turn.
    way: from the last place. counts: false after a teleport, which odometry does not measure.
    """
    dx, dy, true_yaw_before = x - track[0], y - track[1], track[2]
    true_yaw = yaw_from_quaternion(q)
    track[0], track[1], track[2] = x, y, true_yaw
    if counts:
        scale, bias, position_noise = errors[0], errors[1], errors[2]
        turned = true_yaw - true_yaw_before  # within two half turns of zero
        if turned > math.pi:
            turned -= 2.0 * math.pi
        elif turned <= -math.pi:
            turned += 2.0 * math.pi
        step_noise = position_noise * math.sqrt(way)
        # Turn the true step from the true heading to the measured heading.
        error = track[5] - true_yaw_before
        c, s = math.cos(error), math.sin(error)
        track[3] = track[3] + scale * (c * dx - s * dy) + step_noise * normals[0]
        track[4] = track[4] + scale * (s * dx + c * dy) + step_noise * normals[1]
        variance = errors[3] * way + errors[4] * abs(turned)
        track[5] += turned + bias * way + math.sqrt(variance) * normals[2]
    drift = quaternion_from_rpy(0.0, 0.0, track[5] - true_yaw)
    return (track[3], track[4]), quaternion_multiply(drift, q)
