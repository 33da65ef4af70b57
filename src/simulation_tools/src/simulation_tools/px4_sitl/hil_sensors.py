"""What PX4's sensors would measure, as the messages of its simulator protocol (NED, FRD)."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np
from pymavlink.dialects.v20 import common

from flight_basics.checks import check_limits, limited
from simulation_tools.autopilot import VehicleState
from simulation_tools.errors import SimulationToolsError
from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.geometry import rotate_inverse
from simulation_tools.ned_frames import attitude_to_ned, enu_to_ned, flu_to_frd
from simulation_tools.sensors.atmosphere import pressure_pa, temperature_k
from simulation_tools.sensors.impacts import ImpactLimiter
from simulation_tools.sensors.schedule import Schedule

# Accelerometer, gyroscope, magnetometer, pressure, pressure altitude and temperature; no airspeed.
FIELDS_UPDATED = 7167
GPS_FIX_3D = 3
GRAVITY_M_S2 = 9.80665
_KELVIN = 273.15


@dataclass(frozen=True)
class HilParameters:
    """The sensors of a PX4 in the loop. Noise: standard deviations of white noise.

    No noise may be zero, because PX4 declares a sensor dead if its value stays the same for 100 samples.

    Raises:
        SimulationToolsError: a value makes no sense.
    """

    origin: GeodeticOrigin = field(default_factory=GeodeticOrigin)
    """Where the world's origin lies on earth."""
    magnetic_field_ned_gauss: tuple[float, float, float] = (0.21523, 0.00771, 0.42741)
    """Of the earth there."""
    accelerometer_noise_m_s2: float = limited(0.02, above=0.0)
    """Noise of the accelerometer, m/s2."""
    accelerometer_limit_m_s2: float = limited(80.0, above=0.0)
    """See `ImpactLimiter`, m/s2. PX4's accelerometers measure up to 16 g (157 m/s2) and count a greater
    sample as clipped. The first of the three even reads it with the opposite sign.
    """
    gyroscope_noise_rad_s: float = limited(0.001, above=0.0)
    """Noise of the gyroscope, rad/s."""
    magnetometer_noise_gauss: float = limited(0.002, above=0.0)
    """Noise of the magnetometer, Gauss."""
    pressure_noise_pa: float = limited(1.0, above=0.0)
    """Noise of the barometer, Pa."""
    gps_rate_hz: float = limited(20.0, above=0.0)
    """Rate of the GPS, Hz."""
    gps_delay_s: float = limited(0.11, 0.0, 1.0)
    """Time by which the GPS is late, s. PX4 expects EKF2_GPS_DELAY, 0.11 s."""
    gnss: bool = True
    """False: no GPS is sent."""

    def __post_init__(self) -> None:
        check_limits(self, SimulationToolsError)


class HilSensors:
    """Measures one vehicle's state. Times are PX4's clock, microseconds; rng: source of all noise."""

    def __init__(self, parameters: HilParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._rng = rng
        self._past: deque[tuple[int, VehicleState]] = deque()
        self._gps_schedule = Schedule(parameters.gps_rate_hz)
        self._impacts = ImpactLimiter(parameters.accelerometer_limit_m_s2)

    def restart(self) -> None:
        """Forget what was measured: a PX4 that has just started has no past."""
        self._past.clear()
        self._impacts.restart()
        self._gps_schedule.restart()

    def sensor(self, state: VehicleState, time_us: int) -> common.MAVLink_hil_sensor_message:
        """Return HIL_SENSOR: m/s2 and rad/s (FRD), Gauss (FRD), hPa, m, degrees Celsius."""
        p = self._parameters
        force = self._impacts.felt(np.array(flu_to_frd(state.specific_force_body_m_s2))) + self._noise(
            p.accelerometer_noise_m_s2
        )
        rates = flu_to_frd(state.angular_velocity_body_rad_s) + self._noise(p.gyroscope_noise_rad_s)
        field_enu = enu_to_ned(p.magnetic_field_ned_gauss)
        magnetic = flu_to_frd(rotate_inverse(state.pose.orientation_xyzw, field_enu)) + self._noise(
            p.magnetometer_noise_gauss
        )
        altitude_m = p.origin.altitude_m + state.pose.position_m[2]
        pressure = pressure_pa(altitude_m) + p.pressure_noise_pa * self._rng.standard_normal()
        return common.MAVLink_hil_sensor_message(
            time_us,
            *force,
            *rates,
            *magnetic,
            abs_pressure=0.01 * pressure,
            diff_pressure=0.0,
            pressure_alt=altitude_m + (pressure_pa(altitude_m) - pressure) / _pascal_per_metre(altitude_m),
            temperature=temperature_k(altitude_m) - _KELVIN,
            fields_updated=FIELDS_UPDATED,
        )

    def gps(self, state: VehicleState, time_us: int) -> common.MAVLink_hil_gps_message | None:
        """Return HIL_GPS, if one is due, for the place of gps_delay_s ago. Call it at every step."""
        self._past.append((time_us, state))
        measured_us = time_us - round(1e6 * self._parameters.gps_delay_s)
        while len(self._past) > 1 and self._past[1][0] <= measured_us:
            self._past.popleft()
        if not self._parameters.gnss or time_us < self._gps_schedule.due_us:
            return None
        self._gps_schedule.fired(time_us)
        return self._fix(self._past[0][1], time_us)

    def _fix(self, state: VehicleState, time_us: int) -> common.MAVLink_hil_gps_message:
        east, north, up = state.pose.position_m
        latitude_deg, longitude_deg = self._parameters.origin.to_global(north, east)
        north_cm_s, east_cm_s, down_cm_s = (
            max(-32767, min(32767, round(100.0 * v))) for v in enu_to_ned(state.velocity_world_m_s)
        )
        return common.MAVLink_hil_gps_message(
            time_us,
            fix_type=GPS_FIX_3D,
            lat=round(1e7 * latitude_deg),
            lon=round(1e7 * longitude_deg),
            alt=round(1e3 * (self._parameters.origin.altitude_m + up)),
            eph=30,
            epv=40,
            vel=min(65534, round(math.hypot(north_cm_s, east_cm_s))),
            vn=north_cm_s,
            ve=east_cm_s,
            vd=down_cm_s,
            cog=round(100.0 * math.degrees(math.atan2(east_cm_s, north_cm_s))) % 36000,
            satellites_visible=10,
        )

    def truth(self, state: VehicleState, time_us: int) -> common.MAVLink_hil_state_quaternion_message:
        """Return HIL_STATE_QUATERNION: the true state, which PX4 logs beside its estimate."""
        east, north, up = state.pose.position_m
        latitude_deg, longitude_deg = self._parameters.origin.to_global(north, east)
        velocity_cm_s = [round(100.0 * v) for v in enu_to_ned(state.velocity_world_m_s)]
        speed_cm_s = round(math.hypot(*velocity_cm_s))
        milli_g = [round(1000.0 * a / GRAVITY_M_S2) for a in flu_to_frd(state.specific_force_body_m_s2)]
        return common.MAVLink_hil_state_quaternion_message(
            time_us,
            attitude_to_ned(state.pose.orientation_xyzw),
            *flu_to_frd(state.angular_velocity_body_rad_s),
            round(1e7 * latitude_deg),
            round(1e7 * longitude_deg),
            round(1e3 * (self._parameters.origin.altitude_m + up)),
            *_int16(velocity_cm_s),
            min(speed_cm_s, 65535),
            min(speed_cm_s, 65535),
            *_int16(milli_g),
        )

    def _noise(self, deviation: float) -> np.ndarray:
        return deviation * self._rng.standard_normal(3)


def _int16(values: list[int]) -> list[int]:
    return [max(-32768, min(32767, value)) for value in values]


def _pascal_per_metre(altitude_m: float) -> float:
    """Return how fast pressure falls with height at this altitude."""
    return pressure_pa(altitude_m - 0.5) - pressure_pa(altitude_m + 0.5)
