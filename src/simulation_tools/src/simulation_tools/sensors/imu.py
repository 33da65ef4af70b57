"""An inertial measurement unit: gyroscopes and accelerometers with white noise.

Accelerometers feel *specific force*: acceleration less gravity, so (0, 0, +g) at rest and zero in free fall.
That is what ``sensor_msgs/Imu.linear_acceleration`` holds.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools import compiled_geometry
from simulation_tools.geometry import ORIGIN, Pose, Quaternion, Vector3, rotate_inverse
from simulation_tools.sdf.elements import ImuSensor


class ImuSample(NamedTuple):
    """One measurement in the axes of the IMU's own frame. orientation: of that frame in the world, exact."""

    orientation_xyzw: Quaternion
    angular_velocity_rad_s: Vector3
    linear_acceleration_m_s2: Vector3


class Imu:
    """One IMU on a body. period_us: microseconds between samples, 0 for every step."""

    def __init__(self, sensor: ImuSensor, pose_in_body: Pose, rng: np.random.Generator) -> None:
        """Place it. pose_in_body: of the IMU's frame in the body (model) frame; rng: source of the noise."""
        self.name = sensor.name
        self.period_us = round(1e6 / sensor.update_rate_hz) if sensor.update_rate_hz > 0.0 else 0
        self.pose_in_body = pose_in_body
        noises = (*sensor.gyroscope_noise, *sensor.accelerometer_noise)
        self._mean = np.array([noise.mean for noise in noises])
        self._stddev = np.array([noise.stddev for noise in noises])
        self._rng = rng

    def sample(
        self,
        orientation_xyzw: Quaternion,
        specific_force_m_s2: Vector3,
        angular_velocity_rad_s: Vector3,
        angular_acceleration_rad_s2: Vector3 = ORIGIN,
    ) -> ImuSample:
        """Measure. orientation: of the body in the world.

        The other values: at the body's origin, in body axes.
        """
        arm, axes = self.pose_in_body.position_m, self.pose_in_body.orientation_xyzw
        motion = specific_force_m_s2, angular_velocity_rad_s, angular_acceleration_rad_s2
        noise = self._mean, self._stddev, self._rng.standard_normal(6)
        return ImuSample(*_sample(orientation_xyzw, axes, arm, *motion, *noise))


@njit(cache=True)
def _sample(
    q: Quaternion,
    axes: Quaternion,
    arm: Vector3,
    force: Vector3,
    spin: Vector3,
    spin_up: Vector3,
    mean: np.ndarray,
    stddev: np.ndarray,
    normals: np.ndarray,
) -> tuple[Quaternion, Vector3, Vector3]:
    """Return an `ImuSample`. q: of the body. axes, arm: of the IMU in the body. The errors: rates first."""
    (fx, fy, fz) = force
    (tx, ty, tz) = compiled_geometry.cross(spin_up, arm)
    (cx, cy, cz) = compiled_geometry.cross(spin, compiled_geometry.cross(spin, arm))
    (rx, ry, rz) = compiled_geometry.rotate_inverse(axes, spin)
    (ax, ay, az) = compiled_geometry.rotate_inverse(axes, (fx + tx + cx, fy + ty + cy, fz + tz + cz))
    rates = (
        rx + mean[0] + stddev[0] * normals[0],
        ry + mean[1] + stddev[1] * normals[1],
        rz + mean[2] + stddev[2] * normals[2],
    )
    forces = (
        ax + mean[3] + stddev[3] * normals[3],
        ay + mean[4] + stddev[4] * normals[4],
        az + mean[5] + stddev[5] * normals[5],
    )
    return compiled_geometry.quaternion_multiply(q, axes), rates, forces


def specific_force(
    velocity_before_m_s: Vector3,
    velocity_after_m_s: Vector3,
    dt_s: float,
    gravity_m_s2: Vector3,
    orientation_xyzw: Quaternion,
) -> Vector3:
    """Return the mean specific force over a step, body axes, from world frame velocities and gravity."""
    (x0, y0, z0), (x1, y1, z1), (gx, gy, gz) = velocity_before_m_s, velocity_after_m_s, gravity_m_s2
    felt = (x1 - x0) / dt_s - gx, (y1 - y0) / dt_s - gy, (z1 - z0) / dt_s - gz
    return rotate_inverse(orientation_xyzw, felt)
