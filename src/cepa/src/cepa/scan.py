"""A planar laser scan, and its normal form: a full turn of beams in ascending order, seen or unseen."""

from __future__ import annotations

import math
import numbers
import sys
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from cepa.errors import ScanError
from cepa.kernels.scan import normalise

FINEST_INCREMENT_RAD = math.radians(0.01)
EVEN_TOLERANCE_BEAMS = 0.001
"""How far a turn may be from a whole number of beams (the rounding of float32 is below this)."""


@dataclass(frozen=True, eq=False)
class LaserScan2D:
    """One scan as a lidar gives it; ranges mean what REP-117 says.

    Raises ScanError when the scan cannot be interpreted.
    """

    ranges: np.ndarray
    """(n,) m. +inf or above range_max: no return; -inf or below range_min: too near; NaN or <= 0: invalid."""
    angle_min: float
    """rad: direction of the first beam, counter-clockwise from the frame's x axis."""
    angle_increment: float
    """rad between beams; negative for a lidar that turns clockwise."""
    range_min: float
    """m"""
    range_max: float
    """m"""
    seen: np.ndarray | None = None
    """(n,) bool: False for beams that no sensor covers, such as padding. None: all are seen."""

    def __post_init__(self) -> None:
        self._check_numbers()
        ranges = _vector(self.ranges, np.float64, "ranges")
        seen = np.ones(ranges.size, np.bool_) if self.seen is None else _vector(self.seen, np.bool_, "seen")
        if ranges.size == 0:
            raise ScanError("The scan holds no beams; check the lidar's driver.")
        if seen.size != ranges.size:
            raise ScanError(f"The scan has {ranges.size} ranges but {seen.size} marks of what is seen.")
        object.__setattr__(self, "ranges", ranges)
        object.__setattr__(self, "seen", seen)
        if ranges.size > self.beams_per_turn + 1:
            raise ScanError(
                f"The scan covers more than a full turn: {ranges.size} beams of "
                f"{math.degrees(abs(self.angle_increment)):.4g} degrees."
            )

    def _check_numbers(self) -> None:
        for name in ("angle_min", "angle_increment", "range_min", "range_max"):
            value = getattr(self, name)
            if type(value) is not float and not isinstance(value, numbers.Real):
                raise ScanError(f"The scan's {name} must be a number, not {getattr(self, name)!r}.")
        if not abs(self.angle_min) <= sys.float_info.max:  # NaN fails this test too
            raise ScanError(f"The scan's angle_min must be finite, not {self.angle_min}.")
        if not FINEST_INCREMENT_RAD <= abs(self.angle_increment) <= math.pi:
            raise ScanError(
                "The scan's angle_increment must be between 0.01 degrees and half a turn, "
                f"not {self.angle_increment} rad."
            )
        if not 0.0 <= self.range_min < self.range_max:
            raise ScanError(
                f"The scan's range limits must fulfil 0 <= range_min < range_max, "
                f"not {self.range_min} and {self.range_max}."
            )

    @property
    def beams_per_turn(self) -> int:
        """Number of beams of this increment in a full turn."""
        return round(2.0 * math.pi / abs(self.angle_increment))

    def full_turn(self, dropout_beams: int, too_close_m: float = math.inf) -> Beams:
        """Return the normal form. Up to ``dropout_beams`` in a row take their neighbours' smaller range.

        What is too close is an obstacle at range_min, or at ``too_close_m`` if that is less.
        """
        descending = self.angle_increment < 0.0
        first = (
            self.angle_min + (self.ranges.size - 1) * self.angle_increment if descending else self.angle_min
        )
        count = self.beams_per_turn
        ranges, seen = np.empty(count), np.empty(count, np.bool_)
        limits = (
            float(self.range_min),
            float(self.range_max),
            float(min(self.range_min, too_close_m)),
        )
        assert self.seen is not None  # since __post_init__
        nearest = normalise(self.ranges, self.seen, descending, *limits, int(dropout_beams), ranges, seen)
        return Beams(ranges, seen, float(first), abs(float(self.angle_increment)), nearest)


class Beams(NamedTuple):
    """A full turn of beams in ascending order, beginning at ``angle_0``."""

    ranges: np.ndarray
    """(N,) m, +inf where nothing is seen."""
    seen: np.ndarray
    """(N,) bool"""
    angle_0: float
    """rad: direction of beam 0."""
    increment: float
    """rad, positive"""
    nearest: float
    """The least range, m."""

    @property
    def angles(self) -> np.ndarray:
        """The beams' directions (N,), rad."""
        return self.angle_0 + np.arange(self.ranges.size) * self.increment


class Grid:
    """Tables that depend only on the number of beams and their increment, computed once per lidar.

    Angles are relative to beam 0. The cushion of equation 6.7 is ``min(d, r / |sin psi|)`` for |psi| < 90
    degrees, and ``r`` elsewhere. With the table ``reach`` both are ``min(d, r * reach)``.
    """

    def __init__(self, count: int, increment: float):
        self.count = count
        self.increment = increment
        self.is_even = abs(count - 2.0 * math.pi / increment) < EVEN_TOLERANCE_BEAMS
        """Whether the increment divides the turn, so that the last and the first beam are neighbours too."""
        self.cos = np.cos(np.arange(count) * increment)
        self.sin = np.sin(np.arange(count) * increment)
        offset = np.abs(np.arange(1 - count, count)) * increment
        self.offset_angles = np.minimum(offset, np.abs(2.0 * math.pi - offset))
        """(2N-1,) rad: |psi| of beam j relative to beam i at [j - i + N - 1]."""
        with np.errstate(divide="ignore"):
            reach = 1.0 / np.sin(self.offset_angles)
        self.reach = np.where(self.offset_angles < math.pi / 2, reach, 1.0)
        """(2N-1,): 1 / |sin psi| ahead, 1 behind."""

    def matches(self, beams: Beams) -> bool:
        """Whether this grid is that of ``beams``."""
        return self.count == beams.ranges.size and self.increment == beams.increment

    def index(self, angle: float) -> int:
        """Beam nearest to ``angle`` (rad, relative to beam 0)."""
        turned = angle % (2.0 * math.pi)
        beam = round(turned / self.increment)
        if beam < self.count:
            return beam
        return (
            0 if 2.0 * math.pi - turned < abs(turned - (self.count - 1) * self.increment) else self.count - 1
        )


def _vector(values: Any, dtype: type, name: str) -> np.ndarray:
    try:
        vector: np.ndarray = np.asarray(values, dtype=dtype, order="C")
    except (TypeError, ValueError, OverflowError):
        raise ScanError(f"The scan's {name} must be numbers.") from None
    if vector.ndim != 1:
        raise ScanError(f"The scan's {name} must be one row, not an array of shape {vector.shape}.")
    return vector
