"""Every parameter of loop closure, checked once."""

from __future__ import annotations

import sys
from dataclasses import dataclass, fields

from gridslam.errors import ParameterError

NOT_NEGATIVE = (
    "odometry_m_per_sqrt_m",
    "odometry_rad_per_sqrt_m",
    "odometry_rad_per_sqrt_rad",
    "drift_share",
)
SHARES = ("score_min", "overlap_min", "rival_overlap_min", "rival_share_max")


@dataclass(frozen=True)
class LoopClosureParameters:
    """When a place counts as revisited, and what odometry and matches are trusted with.

    Raises ParameterError, in one sentence, for values that make no sense alone or together.
    """

    search_every_m: float = 0.5
    """m: a revisited place is looked for after this much travel."""
    search_agreed_m: float = 8.0
    """m: ... or after this much, where the last one was found again within correction_min_m of the path."""
    separation_m: float = 20.0
    """m: only places left behind on the path by this much can be revisited; more than twice stretch_m."""
    place_radius_m: float = 5.0
    """m: how near, by the estimate so far, the path must have come to such a place."""
    places_max: int = 3
    """So many earlier passes of a place are compared at most, nearest first."""
    stretch_m: float = 8.0
    """m: length of path from which a local map is built."""
    range_m: float = 15.0
    """m: beams are used up to here."""
    resolution_m: float = 0.05
    """m: cells of local maps."""
    blur_m: float = 0.1
    """m: a point this far from a local map's surface fits by exp(-1/2)."""

    window_sigmas: float = 3.0
    """The window that is searched reaches this many standard deviations of the path since then ..."""
    window_min_m: float = 1.0
    """m: ... at least this far ..."""
    window_max_m: float = 5.0
    """m: ... and at most this far."""
    window_max_rad: float = 0.5
    """rad: the same for the heading."""

    score_min: float = 0.7
    """A match whose comparisons agree to a lesser share is none."""
    overlap_min: float = 0.2
    """Share of the recent local map that must be comparable."""
    rival_distance_m: float = 0.6
    """m: what fits this far from the best pose is a rival."""
    rival_overlap_min: float = 0.05
    """For a rival this share is enough: of the true place little may have been seen again so far."""
    rival_share_max: float = 0.85
    """A match is ambiguous when its best rival reaches more than this share of its score."""
    weakest_sigma_max_m: float = 0.15
    """m: a match is degenerate when its standard deviation in any direction exceeds this."""
    chi_square_max: float = 11.34
    """Contradictions above this end a match; 99 % of a chi-square distribution with 3 degrees of freedom."""
    support_m: float = 10.0
    """m: a match counts only when another one within this much travel agrees with it."""

    odometry_m_per_sqrt_m: float = 0.03
    """m: odometry's standard deviation along and across after one metre."""
    odometry_rad_per_sqrt_m: float = 0.015
    """rad: odometry's standard deviation of the heading after one metre."""
    odometry_rad_per_sqrt_rad: float = 0.03
    """rad: the same after one radian turned."""
    drift_share: float = 0.005
    """Systematic part of the path's error that neither noise nor matching explains, m per m."""
    step_share: float = 0.5
    """How firmly steps hold against closures: their deviations, as a share of a lone match's."""
    match_sigma_m: float = 0.03
    """m: standard deviation of a matched point from its surface."""
    match_points: float = 20.0
    """A match's points count as so many independent ones at most: their errors are alike."""
    closure_sigma_m: float = 0.02
    """m: a closure is not trusted beyond this ..."""
    closure_sigma_rad: float = 0.003
    """rad: ... and this, whatever its points say: the local maps are themselves a little bent."""
    correction_min_m: float = 0.03
    """m: the path is corrected when it is off from a new closure by more than this, or when the log ends."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            number = isinstance(value, (int, float)) and not isinstance(value, bool)
            if not number or not abs(value) <= sys.float_info.max:  # NaN fails this test too
                raise ParameterError(f"{field.name} must be a finite number, not {value!r}.")
            if field.name in NOT_NEGATIVE:
                if value < 0.0:
                    raise ParameterError(f"{field.name} must be at least 0, not {value}.")
            elif not value > 0.0:
                raise ParameterError(f"{field.name} must be greater than 0, not {value}.")
        for name in SHARES:
            if getattr(self, name) > 1.0:
                raise ParameterError(f"{name} must be at most 1, not {getattr(self, name)}.")
        if self.window_min_m > self.window_max_m:
            raise ParameterError(
                f"window_min_m must be at most window_max_m, but {self.window_min_m} > {self.window_max_m}."
            )
        if self.separation_m <= 2.0 * self.stretch_m:
            raise ParameterError(
                f"separation_m must be greater than twice stretch_m, or a local map is compared with one of "
                f"the same scans, but {self.separation_m} <= 2 x {self.stretch_m}."
            )
        if self.search_agreed_m > self.support_m:
            raise ParameterError(
                f"search_agreed_m must be at most support_m, or no match that agrees with the path ever has "
                f"another one near, but {self.search_agreed_m} > {self.support_m}."
            )
        if not 2.0 * self.resolution_m <= self.rival_distance_m <= self.window_max_m:
            raise ParameterError(
                f"rival_distance_m must be between two cells ({2.0 * self.resolution_m:g}) and window_max_m "
                f"({self.window_max_m:g}), not {self.rival_distance_m}."
            )
