"""A free rigid body over flat ground, without PyBullet, and the airframes that fly in the tests."""

from __future__ import annotations

import math

from simulation_tools.autopilot import VehicleState
from simulation_tools.geometry import (
    Pose,
    cross,
    quaternion_from_rotation_vector,
    quaternion_from_rpy,
    quaternion_multiply,
    quaternion_normalised,
    rotate,
    rotate_inverse,
)
from simulation_tools.vehicle.airframe import Airframe
from simulation_tools.vehicle.rotor import Rotor

GRAVITY = 9.8
DT_S = 0.004


def reference_quad() -> Airframe:
    """The body of PX4's measured step responses: X configuration, arms of 0.165 m, linear rotors of 4 N."""
    a = 0.165 * math.sqrt(0.5)
    places = ((a, -a, 1.0), (-a, a, 1.0), (a, a, -1.0), (-a, -a, -1.0))
    rotors = [
        Rotor(
            joint=f"rotor_{i}",
            position_m=(x, y, 0.0),
            direction=turn,
            idle=0.0,
            top=1.0,
            time_constant_up_s=0.005,
            time_constant_down_s=0.005,
            thrust_quadratic=0.0,
            thrust_linear=4.0,
            moment_m=0.05 / 4.0,
        )
        for i, (x, y, turn) in enumerate(places)
    ]
    return Airframe(rotors, body_drag=0.01)


def iris() -> Airframe:
    """PX4's Iris with the model's figures."""
    places = ((0.13, -0.22, 1.0), (-0.13, 0.20, 1.0), (0.13, 0.22, -1.0), (-0.13, -0.20, -1.0))
    rotors = [
        Rotor(
            joint=f"rotor_{i}_joint",
            position_m=(x, y, 0.023),
            direction=turn,
            idle=100.0,
            top=1100.0,
            time_constant_up_s=0.0125,
            time_constant_down_s=0.025,
            thrust_quadratic=5.84e-6,
            thrust_linear=0.0,
            moment_m=0.06,
            rotor_drag=1.75e-4,
            rolling_moment=1e-6,
        )
        for i, (x, y, turn) in enumerate(places)
    ]
    return Airframe(rotors)


class RigidBody:
    """Newton and Euler for one body; the ground at z = 0 stops it dead and holds it level."""

    def __init__(self, mass_kg, inertia, position=(0.0, 0.0, 0.0), yaw=0.0):
        self.mass_kg = mass_kg
        self.inertia = inertia
        self.time_us = 0
        self.position = position
        self.velocity = (0.0, 0.0, 0.0)
        self.attitude = quaternion_from_rpy(0.0, 0.0, yaw)
        self.rates = (0.0, 0.0, 0.0)  # body
        self._force_n = (0.0, 0.0, mass_kg * GRAVITY)  # body, everything but gravity

    @classmethod
    def reference_quad(cls, **where):
        return cls(0.8, (0.005, 0.005, 0.009), **where)

    @classmethod
    def iris(cls, extra_kg=0.0, **where):
        return cls(1.5 + extra_kg, (0.029125, 0.029125, 0.055225), **where)

    @property
    def state(self):
        (fx, fy, fz), m = self._force_n, self.mass_kg
        pose = Pose(self.position, self.attitude)
        return VehicleState(self.time_us, pose, self.velocity, self.rates, (fx / m, fy / m, fz / m))

    @property
    def velocity_body(self):
        return rotate_inverse(self.attitude, self.velocity)

    def step(self, force, torque, dt=DT_S):
        """force, torque: body frame; semi-implicit Euler, the turn exact for constant rates."""
        (fx, fy, fz), m = rotate(self.attitude, force), self.mass_kg
        (x, y, z), (vx, vy, vz) = self.position, self.velocity
        vx, vy, vz = self.velocity = (vx + fx / m * dt, vy + fy / m * dt, vz + (fz / m - GRAVITY) * dt)
        self.position = (x + vx * dt, y + vy * dt, z + vz * dt)
        (ix, iy, iz), (p, q, r), (tx, ty, tz) = self.inertia, self.rates, torque
        gx, gy, gz = cross(self.rates, (ix * p, iy * q, iz * r))
        self.rates = (p + (tx - gx) / ix * dt, q + (ty - gy) / iy * dt, r + (tz - gz) / iz * dt)
        p, q, r = self.rates
        turn = quaternion_from_rotation_vector((p * dt, q * dt, r * dt))
        self.attitude = quaternion_normalised(quaternion_multiply(self.attitude, turn))
        self._force_n = force
        if self.position[2] <= 0.0:
            self._touch_ground(dt)
        self.time_us += round(1e6 * dt)

    def _touch_ground(self, dt):
        x, y, _ = self.position
        self.position = (x, y, 0.0)
        before, self.velocity = self.velocity, (0.0, 0.0, max(self.velocity[2], 0.0))
        self.rates = (0.0, 0.0, 0.0)
        self.attitude = quaternion_from_rpy(0.0, 0.0, Pose((0, 0, 0), self.attitude).yaw_rad)
        stopped = rotate_inverse(self.attitude, tuple((a - b) / dt for a, b in zip(self.velocity, before)))
        self._force_n = tuple(f + self.mass_kg * a for f, a in zip(self._force_n, stopped))
