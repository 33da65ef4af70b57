"""How a body turns and speeds up by its IMU alone, from any beginning."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cepa.errors import MotionError
from cepa.motion import Quaternion, Vector3

NOT_MEASURED: Vector3 = (math.nan, math.nan, math.nan)
SHARE_OF_FIRST = 1.0 / 3.0
"""Of two specific forces, in the way over the time between them: the force changes evenly."""


@dataclass(frozen=True)
class InertialReading:
    """One reading of an IMU, in the axes of the body. Raises MotionError for a rate that is not finite."""

    rates_rad_s: Vector3
    """About the body's axes."""
    force_m_s2: Vector3 = NOT_MEASURED
    """Specific force: (0, 0, 9.81) at rest. NaN: not measured."""

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, self.rates_rad_s)):
            raise MotionError(f"The IMU's rates are not finite: {self.rates_rad_s}; check its driver.")


class InertialPath:
    """Integrates the readings: where they lead in the axes in which the body stood at the beginning.

    Without gravity and without the speed at the beginning, which nobody knows here.
    """

    def __init__(self, stamp_ns: int, reading: InertialReading) -> None:
        self.read_ns = self._stamp_ns = stamp_ns  # of the newest reading, and of the path's end
        self._reading = reading
        self._turned: Quaternion = (0.0, 0.0, 0.0, 1.0)
        self._gain_m_s, self._way_m = np.zeros(3), np.zeros(3)

    def take(self, stamp_ns: int, reading: InertialReading) -> None:
        """Go on to a reading's stamp."""
        self.read_ns = stamp_ns
        self._go_on(stamp_ns, reading)

    def go_on(self, stamp_ns: int, later: tuple[int, InertialReading] | None) -> None:
        """Go on to a stamp before a ``later`` reading; None: the newest reading holds on."""
        self._go_on(stamp_ns, self._between(stamp_ns, *later) if later else self._reading)

    def _go_on(self, stamp_ns: int, reading: InertialReading) -> None:
        passed_s = 1e-9 * (stamp_ns - self._stamp_ns)
        rates = 0.5 * (np.array(self._reading.rates_rad_s) + reading.rates_rad_s)
        first = _rotated(self._turned, self._reading.force_m_s2)
        self._turned = _turned_by(self._turned, rates * passed_s)
        last = _rotated(self._turned, reading.force_m_s2)
        mean = SHARE_OF_FIRST * (2.0 * first + last)
        self._way_m = self._way_m + passed_s * self._gain_m_s + 0.5 * passed_s**2 * mean
        self._gain_m_s = self._gain_m_s + 0.5 * passed_s * (first + last)
        self._stamp_ns, self._reading = stamp_ns, reading

    def next_leg(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the speed gained, m/s, and the way, m, since the last call (3,), as if it began at rest."""
        leg = self._gain_m_s, self._way_m
        self._gain_m_s, self._way_m = np.zeros(3), np.zeros(3)
        return leg

    def axes(self) -> np.ndarray:
        """Return the body's axes now (3, 3), in those of the beginning, as columns."""
        return np.stack([_rotated(self._turned, axis) for axis in np.eye(3).tolist()], axis=1)

    def _between(self, stamp_ns: int, later_ns: int, later: InertialReading) -> InertialReading:
        """Return the reading at a time between the newest one and a later one."""
        share = (stamp_ns - self._stamp_ns) / (later_ns - self._stamp_ns)
        return InertialReading(
            _between(self._reading.rates_rad_s, later.rates_rad_s, share),
            _between(self._reading.force_m_s2, later.force_m_s2, share),
        )


def _between(one: Vector3, other: Vector3, share: float) -> Vector3:
    (a, b, c), (x, y, z) = one, other
    return a + share * (x - a), b + share * (y - b), c + share * (z - c)


def _rotated(turn: Quaternion, vector: Vector3 | list[float]) -> np.ndarray:
    """Return a vector (3,) turned by a unit quaternion."""
    x, y, z, w = turn
    a, b, c = vector
    p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return np.array([a + w * p + y * r - z * q, b + w * q + z * p - x * r, c + w * r + x * q - y * p])


def _turned_by(turn: Quaternion, angles_rad: np.ndarray) -> Quaternion:
    """Return an orientation turned on by a rotation vector (3,) about its own axes."""
    angle = math.sqrt(float(angles_rad @ angles_rad))
    scale = 0.5 if angle < 1e-9 else math.sin(0.5 * angle) / angle
    (x, y, z, w), (a, b, c) = turn, (scale * angles_rad).tolist()
    d = math.cos(0.5 * angle)
    product = (
        w * a + x * d + y * c - z * b,
        w * b - x * c + y * d + z * a,
        w * c + x * b - y * a + z * d,
        w * d - x * a - y * b - z * c,
    )
    length = math.hypot(*product)
    return product[0] / length, product[1] / length, product[2] / length, product[3] / length
