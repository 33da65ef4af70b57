"""Sliding median over neighbouring beams, and optionally over the last scans (thesis, 5.2.2).

Order of the readings (REP-117): -inf (too close) is smaller than every range, +inf (no return) larger,
and NaN (invalid) has no vote.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from flight_basics.checks import check_parameters, limited
from flight_basics.errors import ParameterError, ScanError
from inspection_tools.scan import ScanGeometry, check_range_limits

MAX_WINDOW_BEAMS = 31
MAX_SCANS = 15


@dataclass(frozen=True)
class MedianFilterParameters:
    """The size of the median's window.

    An obstacle that is k beams wide keeps its full width if k > window / 2. Otherwise it vanishes. So the
    default of 3 only loses single beams. Within 1.2 m, at 0.35 degrees, these are obstacles thinner than 1.5
    cm. The default reduces the lidar's Gaussian noise by a third: the median of three readings has 1 -
    sqrt(3) / pi of one reading's variance. A new obstacle is seen `scans // 2` scans later. The default of 1
    adds no delay.

    Raises:
        ParameterError: out of range, or an even window.
    """

    window: int = limited(3, 1, MAX_WINDOW_BEAMS)
    """Beams that the median is taken over, odd: the beam itself and (window - 1) / 2 on each side. An
    obstacle of no more than (window - 1) / 2 beams vanishes. 1 leaves out the neighbours.
    """
    scans: int = limited(1, 1, MAX_SCANS)
    """Scans that the median is taken over, this one and the scans - 1 before it. Something new is seen scans
    // 2 scans later.
    """

    def __post_init__(self) -> None:
        check_parameters(self)
        if self.window % 2 == 0:
            raise ParameterError(f"window is {self.window}; it must be odd, so that it has a middle.")


class LidarMedianFilter:
    """Median filter of one lidar's scans.

    In doubt it prefers the obstacle. Its rules:

    - The result is always one of the readings: with an even number of votes the nearer of the middle two.
    - A valid beam stays valid, however many of its neighbours are NaN.
    - A NaN takes the median of its window, unless invalid readings outnumber the valid ones there.
    - At the edges of a limited field of view the window is cut off. A full circle wraps.
    - Finite readings outside the limits: above range_max is no return (+inf), between 0 and range_min is too
      close (-inf), zero or less is a driver's error code (NaN).
    """

    def __init__(self, parameters: MedianFilterParameters | None = None):
        self._parameters = parameters or MedianFilterParameters()
        self._geometry: ScanGeometry | None = None
        self._history: deque[np.ndarray] = deque(maxlen=self._parameters.scans)  # cleaned, oldest first

    @property
    def parameters(self) -> MedianFilterParameters:
        """The present parameters. A change keeps the part of the history that still applies."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: MedianFilterParameters) -> None:
        self._parameters = parameters
        self._history = deque(self._history, maxlen=parameters.scans)

    def reset(self) -> None:
        """Forget the earlier scans, as after a clock that jumped back."""
        self._geometry = None
        self._history.clear()

    def filter(
        self, ranges: np.ndarray, geometry: ScanGeometry, range_min_m: float, range_max_m: float
    ) -> np.ndarray:
        """Return the filtered ranges.

        Args:
            ranges: (beams,) metres, REP-117; not changed.
            geometry: Of this scan. A geometry other than the last scan's clears the history.
            range_min_m: The lidar's least range.
            range_max_m: The lidar's greatest range.

        Returns:
            (beams,) float32, metres, REP-117.

        Raises:
            ScanError: wrong length or limits. The history does not change then.
        """
        check_range_limits(range_min_m, range_max_m)
        if np.shape(ranges) != (geometry.beams,):
            raise ScanError(f"The scan has {np.size(ranges)} ranges, but its geometry says {geometry.beams}.")
        if geometry != self._geometry:
            self.reset()
            self._geometry = geometry
        cleaned, is_plain = _clean(ranges, range_min_m, range_max_m)
        self._history.append(cleaned)
        window, wraps = self._parameters.window, geometry.closes_circle
        if is_plain and window == 3 and len(self._history) == 1 and cleaned.size > 2:
            return _median_of_three(cleaned, wraps)
        return _lower_median(self._history, window, wraps)


def _clean(ranges: np.ndarray, range_min_m: float, range_max_m: float) -> tuple[np.ndarray, bool]:
    """Bring finite readings outside the limits into REP-117's terms.

    Return a float32 copy, and whether all of it are ranges from range_min on, without NaN.
    """
    cleaned = np.array(ranges, dtype=np.float32)
    cleaned[cleaned > np.float32(range_max_m)] = np.inf
    least_m = np.minimum.reduce(cleaned)
    if least_m >= np.float32(range_min_m):  # false for NaN
        return cleaned, True
    too_small = cleaned < np.float32(range_min_m)
    if too_small.any():
        error_code = too_small & (cleaned <= 0.0) & np.isfinite(cleaned)
        cleaned[too_small] = -np.inf
        cleaned[error_code] = np.nan
    return cleaned, False


def _lower_median(scans: Sequence[np.ndarray], window: int, wraps: bool) -> np.ndarray:
    """Median of each beam's window over all `scans` ((beams,) each, the newest last)."""
    newest = scans[-1]
    beams = newest.size
    half = window // 2
    if wraps:
        half = min(half, (beams - 1) // 2)  # so that no beam votes twice
    votes = np.empty((len(scans) * (2 * half + 1), beams), np.float32)
    pairs = ((scan, shift) for scan in scans for shift in range(-half, half + 1))
    for row, (scan, shift) in zip(votes, pairs):
        _put_shifted(scan, shift, wraps, row)
    _sort(votes)
    median = votes[(len(votes) - 1) // 2]
    beam = np.flatnonzero(np.isnan(votes[-1]))  # all others have every vote
    valid = len(votes) - np.isnan(votes[:, beam]).sum(axis=0)
    found = votes[np.maximum(valid - 1, 0) // 2, beam]
    in_view = 2 * half + 1 if wraps else np.minimum(beam, half) + np.minimum(beams - 1 - beam, half) + 1
    found[np.isnan(newest[beam]) & (2 * valid < in_view * len(scans))] = np.nan
    median[beam] = found
    return median


def _median_of_three(scan: np.ndarray, wraps: bool) -> np.ndarray:
    """Return the same for windows of three beams in one scan (n > 2,) without NaN, in a tenth of the time."""
    median = np.empty_like(scan)
    left, own, right = scan[:-2], scan[1:-1], scan[2:]
    lower, upper = np.minimum(left, own), np.maximum(left, own)
    np.maximum(lower, np.minimum(upper, right, out=upper), out=median[1:-1])
    if wraps:
        for beam in (0, -1):
            neighbours = scan[beam - 1], scan[beam], scan[beam + 1]
            median[beam] = sorted(neighbours)[1]
    else:  # at an edge the nearer of the two
        median[0], median[-1] = min(scan[0], scan[1]), min(scan[-2], scan[-1])
    return median


def _sort(votes: np.ndarray) -> None:
    """Sort each column, NaN to the end."""
    if len(votes) > 5:
        votes.sort(axis=0)
        return
    spare = np.empty_like(votes[0])
    for last in range(len(votes) - 1, 0, -1):  # bubble sort of whole rows: for three a tenth of the time
        for low, high in zip(votes[:last], votes[1:]):
            np.maximum(low, high, out=spare)
            np.fmin(low, high, out=low)
            high[:] = spare


def _put_shifted(scan: np.ndarray, shift: int, wraps: bool, row: np.ndarray) -> None:
    """Fill a row (beams,) with each beam's neighbour, `shift` beams on.

    Beyond an end there is the other end of a full circle, else no beam: NaN.
    """
    if shift > 0:
        row[:-shift] = scan[shift:]
        row[-shift:] = scan[:shift] if wraps else np.nan
    elif shift < 0:
        row[-shift:] = scan[:shift]
        row[:-shift] = scan[shift:] if wraps else np.nan
    else:
        row[:] = scan
