"""The IMU's readings: the lean at a scan's instant, and the motion from scan to scan."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple, Sequence

import numpy as np

from gridslam.errors import ScanError
from gridslam.inputs.attitude import matrix_of_lean, matrix_of_quaternion, roll_pitch_yaw_of

GRAVITY_MPS2 = 9.80665
KEPT_S = 2.0
SILENT_S = 0.2
"""If the last reading is older, the IMU is silent."""
SHOCK_MPS2 = 15.0
"""A greater acceleration is a shock, as at a touch-down, and no change of speed."""
BACK_S = 0.5
"""If a stamp is older than the last by this much, the clock went back."""


@dataclass(frozen=True)
class Lean:
    """Attitude and rates of the base frame at an instant."""

    roll_rad: float
    pitch_rad: float
    rates_rad_s: tuple[float, float, float]
    """About the base's own axes."""


class Motion(NamedTuple):
    """What the IMU felt between two scans."""

    turn_rad: float
    """About the vertical."""
    acceleration_xy: np.ndarray | None
    """(2,) m/s2, mean, in the levelled base frame; None: the IMU gives none."""


class InertialReading:
    """One reading of the IMU, in the axes of the base frame.

    Args:
        stamp_s: its time.
        orientation_xyzw: of the base frame; only roll and pitch are used.
        rates_rad_s: (3,) about the base's axes.
        acceleration_m_s2: (3,) specific force: (0, 0, 9.81) at rest; None: not measured.

    Raises:
        ScanError: a number is not finite, or the orientation is not a rotation.
    """

    def __init__(
        self,
        stamp_s: float,
        orientation_xyzw: Sequence[float],
        rates_rad_s: Sequence[float],
        acceleration_m_s2: Sequence[float] | None = None,
    ) -> None:
        force = () if acceleration_m_s2 is None else acceleration_m_s2
        numbers = (stamp_s, *orientation_xyzw, *rates_rad_s, *force)
        if not all(math.isfinite(number) for number in numbers):
            raise ScanError("The IMU's reading is not finite; it is left out.")
        self.stamp_s = stamp_s
        self.roll_rad, self.pitch_rad, _ = roll_pitch_yaw_of(matrix_of_quaternion(orientation_xyzw))
        p, q, r = (float(rate) for rate in rates_rad_s)
        self.rates_rad_s = (p, q, r)
        sin, cos = math.sin(self.roll_rad), math.cos(self.roll_rad)
        across = q * sin + r * cos
        self.yaw_rate = across / max(math.cos(self.pitch_rad), 0.1)
        self.roll_rate = p + across * math.tan(self.pitch_rad)
        self.pitch_rate = q * cos - r * sin
        self.levelled: np.ndarray | None = None
        if len(force):
            levelling = matrix_of_lean(self.roll_rad, self.pitch_rad)
            levelled = levelling @ np.asarray(force, float) - (0.0, 0.0, GRAVITY_MPS2)
            if np.linalg.norm(levelled) <= SHOCK_MPS2:
                self.levelled = levelled


class InertialHistory:
    """The readings of the last seconds. A reading holds until the next one."""

    def __init__(self) -> None:
        self._readings: deque[InertialReading] = deque()

    @property
    def newest_s(self) -> float:
        """Stamp of the last reading; -inf without one."""
        return self._readings[-1].stamp_s if self._readings else -math.inf

    def is_back(self, reading: InertialReading) -> bool:
        """Whether the clock went back before this reading."""
        return reading.stamp_s < self.newest_s - BACK_S

    def add(self, reading: InertialReading) -> bool:
        """Take a reading. Return False, and leave it out, if it is not newer than the last."""
        if reading.stamp_s <= self.newest_s:
            return False
        self._readings.append(reading)
        while self._readings[-1].stamp_s - self._readings[0].stamp_s > KEPT_S:
            self._readings.popleft()
        return True

    def _before(self, stamp_s: float) -> InertialReading | None:
        return next((r for r in reversed(self._readings) if r.stamp_s <= stamp_s), None)

    def lean_at(self, stamp_s: float) -> Lean | None:
        """Return the lean by the last reading up to an instant; None if that one is too old."""
        reading = self._before(stamp_s)
        if reading is None or stamp_s - reading.stamp_s > SILENT_S:
            return None
        past_s = stamp_s - reading.stamp_s
        return Lean(
            reading.roll_rad + past_s * reading.roll_rate,
            reading.pitch_rad + past_s * reading.pitch_rate,
            reading.rates_rad_s,
        )

    def motion(self, from_s: float, to_s: float) -> Motion:
        """Integrate the readings between two instants. Without a reading nothing is known to turn."""
        turn_rad, change, known_s = 0.0, np.zeros(2), 0.0
        end_s = to_s
        for reading in reversed(self._readings):
            if reading.stamp_s >= end_s:
                continue
            begin_s = max(reading.stamp_s, from_s)
            held_s = min(end_s - begin_s, SILENT_S)
            turn_rad += held_s * reading.yaw_rate
            if reading.levelled is not None:
                change += held_s * reading.levelled[:2]
                known_s += held_s
            if reading.stamp_s <= from_s:
                break
            end_s = begin_s
        return Motion(turn_rad, change / known_s if known_s > 0.5 * (to_s - from_s) > 0.0 else None)
