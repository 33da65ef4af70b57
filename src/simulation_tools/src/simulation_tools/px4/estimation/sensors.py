"""The flight controller's own sensors, simulated: IMU, barometer, magnetometer, GNSS (NED, FRD)."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools.autopilot import VehicleState
from simulation_tools.geometry import Vector3, rotate_inverse
from simulation_tools.ned_frames import enu_to_ned, flu_to_frd
from simulation_tools.sensors.atmosphere import pressure_pa
from simulation_tools.sensors.schedule import Schedule


@dataclass(frozen=True)
class SensorErrors:
    """The errors of the sensors of a Pixhawk. Standard deviations; `*_density`: per root of 1 Hz.

    White noise of the IMU: data sheet of the ICM-20602 (InvenSense DS-000176), 0.004 deg/s and 100 ug per
    root of 1 Hz. Random walks of the biases: the MPU-6000's bias stabilities of 4.6 deg/h and 36 ug over 500
    and 800 s (D. R. Greenheck, "Design and characterization of a low cost MEMS IMU cluster for precision
    navigation", Marquette University, 2009). Biases at power-on: what a calibration leaves.
    Barometer: DPS310 (Infineon), 0.2 Pa. Magnetometer: as PX4's simulators. GNSS: so that a
    hover wanders as much as real PX4's; a fix is late by gnss_delay_s.
    """

    gyroscope_density: float = math.radians(0.004)  # rad/s
    accelerometer_density: float = 100e-6 * 9.80665  # m/s2
    gyroscope_walk_density: float = math.radians(4.6 / 3600.0) / math.sqrt(500.0)  # rad/s2
    accelerometer_walk_density: float = 36e-6 * 9.80665 / math.sqrt(800.0)  # m/s3
    gyroscope_bias_rad_s: float = 0.002
    accelerometer_bias_m_s2: float = 0.03
    pressure_noise_pa: float = 0.2
    magnetometer_noise_gauss: float = 0.002
    gnss_position_noise_m: float = 0.093
    gnss_velocity_noise_m_s: float = 0.005
    gnss_rate_hz: float = 20.0
    gnss_delay_s: float = 0.11
    magnetic_field_ned_gauss: Vector3 = (0.21523, 0.00771, 0.42741)
    altitude_m: float = 488.0

    @classmethod
    def none(cls) -> SensorErrors:
        """Return perfect sensors; GNSS is late all the same."""
        return cls(*(0.0,) * 10)

    @property
    def declination_rad(self) -> float:
        """Direction of the magnetic field, clockwise from true north."""
        north, east, _ = self.magnetic_field_ned_gauss
        return math.atan2(east, north)


class Fix(NamedTuple):
    """One GNSS fix: position (m from the local frame's origin) and velocity (m/s), NED, each (3,)."""

    position: np.ndarray
    velocity: np.ndarray


SAMPLE_RATE_HZ = 20.0
"""Of barometer and magnetometer; PX4 averages them to about this rate."""


@njit(cache=True)
def measure_imu(
    truth: np.ndarray,
    densities: np.ndarray,
    biases: np.ndarray,
    normals: np.ndarray,
    dt: float,
    rates: np.ndarray,
    force: np.ndarray,
) -> None:
    """Measure the mean of dt; fills rates (3,) rad/s and force (3,) m/s2, both FRD.

    truth (6,): rates and specific force, FLU. densities (4,): of the noise and of the random walk of
    gyroscope and accelerometer. biases (6,): gyroscope's and accelerometer's, moved on by their walk.
    """
    root = math.sqrt(dt)
    for i in range(3):
        sign = 1.0 if i == 0 else -1.0
        biases[i] += densities[2] * root * normals[6 + i]
        biases[3 + i] += densities[3] * root * normals[9 + i]
        rates[i] = sign * truth[i] + biases[i] + densities[0] / root * normals[i]
        force[i] = sign * truth[3 + i] + biases[3 + i] + densities[1] / root * normals[3 + i]


class OwnSensors:
    """Measures one vehicle's state. rng: source of all noise, which `restart` does not rewind."""

    def __init__(self, errors: SensorErrors, has_gnss: bool, rng: np.random.Generator) -> None:
        self._errors = errors
        self._rng = rng
        self._has_gnss = has_gnss
        self._densities = np.array(
            [
                errors.gyroscope_density,
                errors.accelerometer_density,
                errors.gyroscope_walk_density,
                errors.accelerometer_walk_density,
            ]
        )
        self._biases = np.empty(6)
        self._truth = np.empty(6)
        self._schedule, self._gnss_schedule = Schedule(SAMPLE_RATE_HZ), Schedule(errors.gnss_rate_hz or 1.0)
        self._field_enu = enu_to_ned(errors.magnetic_field_ned_gauss)
        self._standard_pa = pressure_pa(errors.altitude_m)
        self._metres_per_pa = 1.0 / (self._standard_pa - pressure_pa(errors.altitude_m + 1.0))
        self._late: deque[tuple[int, Fix]] = deque()

    def restart(self) -> None:
        """Switch on: new biases, and no fix under way."""
        usual = (self._errors.gyroscope_bias_rad_s,) * 3 + (self._errors.accelerometer_bias_m_s2,) * 3
        self._biases[:] = usual * self._rng.standard_normal(6)
        self._schedule.restart()
        self._gnss_schedule.restart()
        self._late.clear()

    def imu(self, state: VehicleState, dt_s: float, rates: np.ndarray, force: np.ndarray) -> None:
        """Fill rates (3,) and specific force (3,), FRD, of the last dt_s."""
        self._truth[:3] = state.angular_velocity_body_rad_s
        self._truth[3:] = state.specific_force_body_m_s2
        normals = self._rng.standard_normal(12)
        measure_imu(self._truth, self._densities, self._biases, normals, dt_s, rates, force)

    def is_due(self, time_us: int) -> bool:
        """Whether barometer and magnetometer measure at this step; call it once a step."""
        if time_us < self._schedule.due_us:
            return False
        self._schedule.fired(time_us)
        return True

    def height_m(self, state: VehicleState, origin_z_m: float) -> float:
        """Return the barometer's height over the origin by the standard atmosphere."""
        noise = self._errors.pressure_noise_pa * float(self._rng.standard_normal())
        return state.pose.position_m[2] - origin_z_m + self._metres_per_pa * noise

    def magnetic_field(self, state: VehicleState) -> np.ndarray:
        """Return the magnetic field, Gauss, FRD, (3,)."""
        true = np.array(flu_to_frd(rotate_inverse(state.pose.orientation_xyzw, self._field_enu)))
        return true + self._errors.magnetometer_noise_gauss * self._rng.standard_normal(3)

    def fix(self, state: VehicleState, origin_m: Vector3) -> Fix | None:
        """Return the GNSS fix that arrives at this step; call it once a step."""
        if not self._has_gnss:
            return None
        now_us, errors = state.time_us, self._errors
        if now_us >= self._gnss_schedule.due_us:
            self._gnss_schedule.fired(now_us)
            (x, y, z), (x0, y0, z0) = state.pose.position_m, origin_m
            position = np.array((y - y0, x - x0, z0 - z))
            position += errors.gnss_position_noise_m * self._rng.standard_normal(3)
            velocity = np.array(enu_to_ned(state.velocity_world_m_s))
            velocity += errors.gnss_velocity_noise_m_s * self._rng.standard_normal(3)
            self._late.append((now_us + round(1e6 * errors.gnss_delay_s), Fix(position, velocity)))
        if self._late and self._late[0][0] <= now_us:
            return self._late.popleft()[1]
        return None
