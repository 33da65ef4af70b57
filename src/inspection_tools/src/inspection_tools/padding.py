"""Extends a scan of any field of view to 360 degrees, and marks the added beams as unseen (thesis, 5.2.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flight_basics.checks import check_number
from flight_basics.errors import ParameterError, ScanError
from inspection_tools.scan import ScanGeometry, check_range_limits

MAX_VALUE_M = 1000.0


@dataclass(frozen=True)
class PaddingParameters:
    """The value of the added beams.

    Raises:
        ParameterError: anything else.
    """

    value: str | float = "nan"
    """"range_max" (the lidar's greatest range), "inf" (no return), "nan" (invalid), or a range in metres, as
    a number or text.
    """

    def __post_init__(self) -> None:
        if self.value in ("range_max", "inf", "nan"):
            return
        try:
            number = float(self.value)
        except (TypeError, ValueError, OverflowError):
            raise ParameterError(
                f'value is {self.value!r}; it must be "range_max", "inf", "nan" or a range in metres.'
            ) from None
        check_number("value", number, 0.0, MAX_VALUE_M)

    def range_m(self, range_max_m: float) -> float:
        """Return the range of an added beam of a lidar with the range `range_max_m`."""
        return range_max_m if self.value == "range_max" else float(self.value)


@dataclass(frozen=True)
class PaddedScan:
    """A full turn of beams, on the grid of the scan it came from.

    Attributes:
        ranges: (n,) float32, metres.
        seen: (n,) bool; False where a beam was added.
        geometry: Of the n beams. It starts within one beam of -180 degrees (+180 for a negative increment),
            unless that would split the source's beams.
        first_beam: Index of the source's first beam.
    """

    ranges: np.ndarray
    seen: np.ndarray
    geometry: ScanGeometry
    first_beam: int

    @property
    def angle_max_rad(self) -> float:
        """Direction of the last beam."""
        return self.geometry.angle_min_rad + (self.geometry.beams - 1) * self.geometry.angle_increment_rad


class _Turn(NamedTuple):
    """What the padded scans of one geometry have in common."""

    of: tuple[ScanGeometry, PaddingParameters, float]
    """The source's geometry, the parameters and range_max; the range of an added beam may be NaN."""
    empty: np.ndarray
    """(n,) float32, m: added beams only."""
    seen: np.ndarray
    """(n,) bool."""
    geometry: ScanGeometry
    first_beam: int
    kept: int
    """Number of the source's beams up to one turn."""


class LidarPadding:
    """Pads the scans of one lidar. The outcome depends on the scan and the parameters only."""

    def __init__(self, parameters: PaddingParameters | None = None):
        self.parameters = parameters or PaddingParameters()
        self._turn: _Turn | None = None  # of the last scan

    def pad(
        self, ranges: np.ndarray, geometry: ScanGeometry, range_min_m: float, range_max_m: float
    ) -> PaddedScan:
        """Return a full turn that contains `ranges` unchanged.

        In a scan of more than a turn (for example, with the first beam repeated at the end) repeated
        directions are merged: the nearer reading counts, and NaN never counts. The increment is kept. If it
        does not divide 360 degrees, the step across the seam is shorter or longer by up to half of it.

        Args:
            ranges: (beams,) metres, REP-117.
            geometry: Of this scan.
            range_min_m: The lidar's least range.
            range_max_m: The lidar's greatest range.

        Raises:
            ScanError: wrong length or limits, more than two turns.
        """
        check_range_limits(range_min_m, range_max_m)
        if np.shape(ranges) != (geometry.beams,):
            raise ScanError(f"The scan has {np.size(ranges)} ranges, but its geometry says {geometry.beams}.")
        turn = self._turn_of(geometry, range_max_m)
        padded, kept = turn.empty.copy(), turn.kept
        padded[turn.first_beam : turn.first_beam + kept] = ranges[:kept]
        repeated = geometry.beams - kept
        if repeated:
            padded[:repeated] = np.fmin(padded[:repeated], np.asarray(ranges[kept:], dtype=np.float32))
        return PaddedScan(padded, turn.seen.copy(), turn.geometry, turn.first_beam)

    def _turn_of(self, geometry: ScanGeometry, range_max_m: float) -> _Turn:
        """Return what scans of a geometry have in common. It is that of the last scan, as a rule."""
        of = geometry, self.parameters, range_max_m
        if self._turn is None or self._turn.of != of:
            self._turn = _turn_of(*of)
        return self._turn


def _turn_of(geometry: ScanGeometry, parameters: PaddingParameters, range_max_m: float) -> _Turn:
    beams = geometry.beams_per_turn
    if geometry.beams > 2 * beams:
        raise ScanError(
            f"The scan's {geometry.beams} beams go round more than twice; check its angle_increment."
        )
    before, kept = _beams_before(geometry, beams), min(geometry.beams, beams)
    empty = np.full(beams, parameters.range_m(range_max_m), dtype=np.float32)
    seen = np.zeros(beams, dtype=bool)
    seen[before : before + kept] = True
    start_rad = geometry.angle_min_rad - before * geometry.angle_increment_rad
    whole = ScanGeometry(beams, start_rad, geometry.angle_increment_rad)
    return _Turn((geometry, parameters, range_max_m), empty, seen, whole, before, kept)


def _beams_before(geometry: ScanGeometry, turn: int) -> int:
    """Number of beams to add before the first, so that the turn starts at -180 degrees if possible."""
    missing = max(turn - geometry.beams, 0)
    sign = math.copysign(1.0, geometry.angle_increment_rad)
    room_rad = math.pi + sign * geometry.angle_min_rad
    rounding = 0.001  # beams; rounded float32 angles must not lose the last beam
    return min(max(math.floor(room_rad / abs(geometry.angle_increment_rad) + rounding), 0), missing)
