"""Odometry that drifts like a real one: without bound, but never in jumps.

The UAV's own motion is measured with a scale error, a heading bias and white noise, all of which grow with
the way travelled, not with time: a UAV that hovers does not drift. Height, roll and pitch
are exact, as a barometer and an accelerometer would keep them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import (
    Pose,
    Vector3,
    quaternion_from_rpy,
    quaternion_multiply,
    rotate_inverse,
    wrap_angle,
)
from simulation_tools.world.kinematics import BodyState

TELEPORT_SPEED_M_S = 100.0
"""A faster move comes from a call (``/gazebo/set_model_state``), and odometry does not measure it."""


class OdometryError(SimulationToolsError):
    """The parameters of the drift are not sensible."""


@dataclass(frozen=True)
class OdometryParameters:
    """How odometry drifts.

    scale_error: measured way over true way, less one. heading_bias_rad_per_m: measured turn to the left
    while flying straight. position_noise_m_per_sqrt_m: standard deviation along x and along y after one
    metre. heading_noise_rad_per_sqrt_m and heading_noise_rad_per_sqrt_rad: standard deviation of the heading
    after one metre travelled, and after one radian turned.
    """

    scale_error: float = 0.01
    heading_bias_rad_per_m: float = 0.002
    position_noise_m_per_sqrt_m: float = 0.02
    heading_noise_rad_per_sqrt_m: float = 0.01
    heading_noise_rad_per_sqrt_rad: float = 0.02

    def __post_init__(self) -> None:
        for field in fields(self):
            if not math.isfinite(getattr(self, field.name)):
                raise OdometryError(f"The odometry's {field.name} must be a finite number.")
        if self.scale_error <= -1.0:
            raise OdometryError(f"The odometry's scale_error must be above -1, not {self.scale_error:g}.")
        noises = (
            self.position_noise_m_per_sqrt_m,
            self.heading_noise_rad_per_sqrt_m,
            self.heading_noise_rad_per_sqrt_rad,
        )
        if min(noises) < 0.0:
            raise OdometryError("The odometry's noises must not be negative.")

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
        self._parameters = parameters
        self._exact = parameters == OdometryParameters.none()
        self._initial_pose = initial_pose
        self._rng = rng
        self.reset()

    def reset(self) -> None:
        """Forget the path so far and start at the initial pose again."""
        x, y, _ = self._initial_pose.position_m
        self._true_xy = self._xy = (x, y)
        self._true_yaw = self._yaw = self._initial_pose.yaw_rad

    def update(self, true_state: BodyState, dt_s: float) -> OdometrySample:
        """Take in the true state (world frame) dt_s after the last update; return what odometry says."""
        pose = true_state.pose
        q = pose.orientation_xyzw
        velocity = rotate_inverse(q, true_state.linear_velocity_m_s)
        spin = rotate_inverse(q, true_state.angular_velocity_rad_s)
        if self._exact:
            return OdometrySample(pose, velocity, spin)
        self._advance(pose, dt_s)
        drift = quaternion_from_rpy(0.0, 0.0, self._yaw - self._true_yaw)
        measured = Pose((*self._xy, pose.position_m[2]), quaternion_multiply(drift, q))
        scale = 1.0 + self._parameters.scale_error
        vx, vy, vz = velocity
        return OdometrySample(measured, (scale * vx, scale * vy, vz), spin)

    def _advance(self, pose: Pose, dt_s: float) -> None:
        x, y, _ = pose.position_m
        yaw = pose.yaw_rad
        dx, dy = x - self._true_xy[0], y - self._true_xy[1]
        turned = wrap_angle(yaw - self._true_yaw)
        start_yaw = self._true_yaw
        self._true_xy, self._true_yaw = (x, y), yaw
        way = math.hypot(dx, dy)
        along_noise, across_noise, heading_noise = self._rng.standard_normal(3).tolist()
        if way > TELEPORT_SPEED_M_S * dt_s + 0.01:
            return
        p = self._parameters
        root = math.sqrt(way)
        step_noise = p.position_noise_m_per_sqrt_m * root
        # Turn the true step from the true heading to the measured heading.
        error = self._yaw - start_yaw
        c, s = math.cos(error), math.sin(error)
        scale = 1.0 + p.scale_error
        ox, oy = self._xy
        self._xy = (
            ox + scale * (c * dx - s * dy) + step_noise * along_noise,
            oy + scale * (s * dx + c * dy) + step_noise * across_noise,
        )
        variance = p.heading_noise_rad_per_sqrt_m**2 * way + p.heading_noise_rad_per_sqrt_rad**2 * abs(turned)
        self._yaw += turned + p.heading_bias_rad_per_m * way + math.sqrt(variance) * heading_noise
