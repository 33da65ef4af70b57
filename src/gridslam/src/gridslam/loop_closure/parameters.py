"""Every parameter of loop closure, checked once."""

from __future__ import annotations

import sys
from dataclasses import dataclass, fields

from gridslam.errors import ParameterError

NOT_NEGATIVE = (
    "odometry_m_per_sqrt_m",
    "odometry_rad_per_sqrt_m",
    "odometry_rad_per_sqrt_rad",
    "climb_m_per_sqrt_m",
    "drift_share",
)
SHARES = (
    "score_min",
    "overlap_min",
    "rival_overlap_min",
    "rival_share_max",
    "link_share_min",
    "link_pass_share_min",
)


@dataclass(frozen=True)
class LoopClosureParameters:
    """When a place counts as revisited, and how far odometry and matches are trusted.

    Raises ParameterError, in one sentence, for values that make no sense alone or together.
    """

    answer_s: float = 0.5
    """s: a correction is taken over this long after the scan that led to it, by the scans' stamps."""
    rest_s: float = 10.0
    """s: after so long without a new node, as after a landing, what is pending is decided."""
    search_every_m: float = 0.5
    """m: search for a revisited place after this much travel."""
    search_agreed_m: float = 8.0
    """m: ... or after this much, if the last one was found within correction_min_m of the path."""
    separation_m: float = 20.0
    """m: only places at least this far back on the path can be revisited; more than twice stretch_m."""
    height_band_m: float = 0.5
    """m: a place seen from a height that differs by more is not recognised, because the scans are other
    slices."""
    place_radius_m: float = 5.0
    """m: greatest distance of the path from such a place, by the present estimate."""
    places_max: int = 3
    """Greatest number of earlier passes of a place to compare, nearest first."""
    search_far_m: float = 4.0
    """m: if no place near is found, search as far as the path may be off after this much travel."""
    stretch_m: float = 8.0
    """m: length of path in a local map."""
    range_m: float = 15.0
    """m: beams are used up to here."""
    resolution_m: float = 0.05
    """m: cells of local maps."""
    blur_m: float = 0.1
    """m: a point this far from a local map's surface fits by exp(-1/2)."""

    window_sigmas: float = 3.0
    """The search window reaches this many standard deviations of the path since then ..."""
    window_min_m: float = 1.0
    """m: ... at least this far ..."""
    window_max_m: float = 5.0
    """m: ... and at most this far. The far search has no such limit."""
    window_max_rad: float = 0.5
    """rad: the same for the heading."""

    score_min: float = 0.7
    """Share of comparisons that must agree in a match; more than this."""
    overlap_min: float = 0.2
    """Share of the recent local map that must be comparable."""
    rival_distance_m: float = 0.6
    """m: a pose that fits and is this far from the best one is a rival."""
    rival_overlap_min: float = 0.05
    """For a rival this share is enough, because little of the true place may have been seen again so far."""
    rival_share_max: float = 0.85
    """A match is ambiguous when its best rival reaches more than this share of its score."""
    weakest_sigma_max_m: float = 0.15
    """m: a match is degenerate when its standard deviation in any direction exceeds this."""
    chi_square_max: float = 11.34
    """Greatest chi-square of consistent matches: 99 % of a distribution with 3 degrees of freedom."""
    support_m: float = 16.0
    """m: a match counts only if another one within this much travel agrees with it. Twice stretch_m: so two
    local maps without common scans may support each other."""

    odometry_m_per_sqrt_m: float = 0.1
    """m: odometry's standard deviation along and across after one metre."""
    odometry_rad_per_sqrt_m: float = 0.1
    """rad: odometry's standard deviation of the heading after one metre."""
    odometry_rad_per_sqrt_rad: float = 0.2
    """rad: the same after one radian turned."""
    climb_m_per_sqrt_m: float = 0.005
    """m: standard deviation of the height by odometry after one metre."""
    drift_share: float = 0.005
    """Systematic part of the path's error, besides noise and matching, m per m."""
    slip_m: float = 10.0
    """m: odometry's standard deviation along and across where a scan contradicted it (wheels slip) ..."""
    slip_rad: float = 0.3
    """rad: ... and that of its heading."""
    step_share: float = 1.0
    """Stiffness of steps against closures: their deviations as a share of a single match's."""
    match_sigma_m: float = 0.03
    """m: standard deviation of a matched point from its surface."""
    match_points: float = 12.0
    """A match's points count as at most this many independent ones, because their errors are similar."""
    closure_sigma_m: float = 0.02
    """m: least standard deviation of a closure ..."""
    closure_sigma_rad: float = 0.003
    """rad: ... and of its heading, because local maps are slightly bent."""
    link_range_m: float = 30.0
    """m: beams are used up to here to link scans."""
    link_reach_m: float = 10.0
    """m: a scan is linked with scans at most this much travel before it ..."""
    links_back: int = 3
    """... and with at most this many of them."""
    link_radius_m: float = 3.0
    """m: a scan is linked with scans of other passes at most this far away ..."""
    link_separation_m: float = 10.0
    """m: ... and at least this much travel before it."""
    link_gate_m: float = 0.3
    """m: points farther apart are no pair ..."""
    link_pass_gate_m: float = 0.8
    """m: ... nor at the start of a link with a scan of another pass."""
    link_share_min: float = 0.3
    """Least share of a scan's points that have a pair in a link ..."""
    link_pass_share_min: float = 0.5
    """... and in a link with a scan of another pass."""
    link_rms_max_m: float = 0.1
    """m: greatest root mean square of the pairs' distances in a link."""
    correction_min_m: float = 0.03
    """m: correct the path if a closure that is new or removed differs from it by more. At the end of the log
    it is corrected in any case."""

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


def closure_parameters(given: dict) -> LoopClosureParameters:
    """Return the loop closer's parameters from given values by name and the defaults.

    Raises:
        ParameterError: one is unknown or makes no sense.
    """
    unknown = set(given) - {field.name for field in fields(LoopClosureParameters)}
    if unknown:
        raise ParameterError(f"The loop closure has no parameter {', '.join(sorted(unknown))}.")
    return LoopClosureParameters(**given)
