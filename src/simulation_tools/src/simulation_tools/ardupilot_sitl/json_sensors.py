"""What the answers to ArduPilot tell of its vehicle: a line of JSON in NED and FRD for each of its frames.

The physics is slower than ArduPilot's frames. So the lines between two states of the physics tell states
between them. ArduPilot makes GPS, compass and barometer of the pose itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable

import numpy as np

from flight_basics.checks import check_limits, limited
from simulation_tools.autopilot import VehicleState
from simulation_tools.errors import SimulationToolsError
from simulation_tools.ned_frames import attitude_to_ned, enu_to_ned, flu_to_frd
from simulation_tools.sensors.impacts import ImpactLimiter

_STRETCH = 1.0 + 1e-7
"""ArduPilot cuts each step to whole microseconds. A stretched step is not cut to one microsecond less."""
_LINE = (
    '\n{"timestamp":%.12f,"imu":{"gyro":[%.9g, %.9g, %.9g],"accel_body":[%.9g, %.9g, %.9g]},'
    '"position":[%.9g, %.9g, %.9g],"quaternion":[%.9g, %.9g, %.9g, %.9g],'
    '"velocity":[%.9g, %.9g, %.9g],%s"no_time_sync":1}\n'
)
"""no_time_sync: the simulator alone keeps ArduPilot in time with the wall clock. It must be a number."""
RANGE_US = 50_000
"""Between two readings of the range finder."""
NOTHING_MET_M = 1000.0
"""Is told where the range finder meets nothing: ArduPilot knows no inf."""


@dataclass(frozen=True)
class JsonSensorParameters:
    """The noise of gyroscope and accelerometer: standard deviations of white noise.

    Raises:
        SimulationToolsError: a value makes no sense.
    """

    accelerometer_noise_m_s2: float = limited(0.02, 0.0)
    """Noise of the accelerometer, m/s2."""
    gyroscope_noise_rad_s: float = limited(0.001, 0.0)
    """Noise of the gyroscope, rad/s."""
    accelerometer_limit_m_s2: float = limited(80.0, 0.0)
    """See `ImpactLimiter`, m/s2."""

    def __post_init__(self) -> None:
        check_limits(self, SimulationToolsError)


class JsonSensors:
    """Writes the answers for one vehicle. rng: source of all noise.

    Attributes:
        look_down: returns the range, m, of a range finder that looks down, by REP-117; None: there is none.
    """

    def __init__(self, parameters: JsonSensorParameters, rng: np.random.Generator) -> None:
        self._deviations = np.repeat(
            (parameters.gyroscope_noise_rad_s, parameters.accelerometer_noise_m_s2), 3
        )
        self._impacts = ImpactLimiter(parameters.accelerometer_limit_m_s2)
        self._rng = rng
        self.look_down: Callable[[], float] | None = None
        self._range, self._range_us = "", -RANGE_US

    def restart(self) -> None:
        """Forget what was measured."""
        self._range_us = -RANGE_US
        self._impacts.restart()

    def line(self, before: VehicleState, now: VehicleState, time_us: int) -> bytes:
        """Return the answer for a time after `before` and not after `now`.

        The specific force is the mean since `before`; everything else changes evenly.
        """
        lasted_us = now.time_us - before.time_us
        share = (time_us - before.time_us) / lasted_us if lasted_us > 0 else 1.0
        noise = (self._deviations * self._rng.standard_normal(6)).tolist()
        gyro = flu_to_frd(
            _between(before.angular_velocity_body_rad_s, now.angular_velocity_body_rad_s, share)
        )
        force = self._impacts.felt(np.array(flu_to_frd(now.specific_force_body_m_s2))).tolist()
        quaternion = attitude_to_ned(_turned(before.pose.orientation_xyzw, now.pose.orientation_xyzw, share))
        return (
            _LINE
            % (
                1e-6 * time_us * _STRETCH,
                *(a + b for a, b in zip((*gyro, *force), noise)),
                *enu_to_ned(_between(before.pose.position_m, now.pose.position_m, share)),
                *quaternion,
                *enu_to_ned(_between(before.velocity_world_m_s, now.velocity_world_m_s, share)),
                self._range_at(time_us),
            )
        ).encode("ascii")

    def _range_at(self, time_us: int) -> str:
        """Return the part of the answer with the range; it changes when a new reading is due."""
        if self.look_down is not None and time_us >= self._range_us + RANGE_US:
            range_m = min(max(self.look_down(), 0.0), NOTHING_MET_M)
            self._range, self._range_us = f'"rng_1":{range_m:.4f},', time_us
        return self._range


def _between(before: tuple[float, ...], now: tuple[float, ...], share: float) -> tuple[float, ...]:
    return tuple(a + share * (b - a) for a, b in zip(before, now))


def _turned(before: tuple[float, ...], now: tuple[float, ...], share: float) -> tuple[float, ...]:
    """Return the attitude between two close ones; q and -q are the same attitude."""
    sign = math.copysign(1.0, sum(a * b for a, b in zip(before, now)))
    mixed = _between(before, tuple(sign * b for b in now), share)
    length = math.sqrt(sum(c * c for c in mixed))
    return tuple(c / length for c in mixed)
