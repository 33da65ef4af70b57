"""Every parameter of loop closure, checked once."""

from __future__ import annotations

from dataclasses import dataclass, fields

from flight_basics.checks import check_limits, limited
from gridslam.errors import ParameterError


@dataclass(frozen=True)
class LoopClosureParameters:
    """When a place counts as revisited, and how far odometry and matches are trusted.

    Raises ParameterError, in one sentence, for values that make no sense alone or together.
    """

    answer_s: float = limited(0.5, above=0.0)
    """s: a correction is taken over this long after the scan that led to it, by the scans' stamps."""
    rest_s: float = limited(10.0, above=0.0)
    """s: after so long without a new node, as after a landing, what is pending is decided."""
    search_every_m: float = limited(0.5, above=0.0)
    """m: search for a revisited place after this much travel."""
    search_agreed_m: float = limited(8.0, above=0.0)
    """m: search after this much travel if the last place was found within correction_min_m of the path."""
    separation_m: float = limited(20.0, above=0.0)
    """m: only places at least this far back on the path can be revisited; more than twice stretch_m."""
    height_band_m: float = limited(0.5, above=0.0)
    """m: a place seen from a height that differs by more is not recognised, because the scans are other
    slices."""
    place_radius_m: float = limited(5.0, above=0.0)
    """m: greatest distance of the path from such a place, by the present estimate."""
    places_max: int = limited(3, 1)
    """Greatest number of earlier passes of a place to compare, nearest first."""
    search_far_m: float = limited(4.0, above=0.0)
    """m: if no place near is found, search as far as the path may be off after this much travel."""
    stretch_m: float = limited(8.0, above=0.0)
    """m: length of path in a local map."""
    range_m: float = limited(15.0, above=0.0)
    """m: beams are used up to here."""
    resolution_m: float = limited(0.05, above=0.0)
    """m: cells of local maps."""
    blur_m: float = limited(0.1, above=0.0)
    """m: a point this far from a local map's surface fits by exp(-1/2)."""

    window_sigmas: float = limited(3.0, above=0.0)
    """The search window reaches this many standard deviations of the path since the place was passed."""
    window_min_m: float = limited(1.0, above=0.0)
    """m: the search window reaches at least this far."""
    window_max_m: float = limited(5.0, above=0.0)
    """m: the search window reaches at most this far. The far search has no such limit."""
    window_max_rad: float = limited(0.5, above=0.0)
    """rad: the search window reaches at most this far in heading."""

    score_min: float = limited(0.7, above=0.0, most=1.0)
    """Share of comparisons that must agree in a match; more than this."""
    overlap_min: float = limited(0.2, above=0.0, most=1.0)
    """Share of the recent local map that must be comparable."""
    rival_distance_m: float = limited(0.6, above=0.0)
    """m: a pose that fits and is this far from the best one is a rival."""
    rival_overlap_min: float = limited(0.05, above=0.0, most=1.0)
    """For a rival this share is enough, because little of the true place may have been seen again so far."""
    rival_share_max: float = limited(0.85, above=0.0, most=1.0)
    """A match is ambiguous when its best rival reaches more than this share of its score."""
    weakest_sigma_max_m: float = limited(0.15, above=0.0)
    """m: a match is degenerate when its standard deviation in any direction exceeds this."""
    chi_square_max: float = limited(11.34, above=0.0)
    """Greatest chi-square of consistent matches: 99 % of a distribution with 3 degrees of freedom."""
    support_m: float = limited(16.0, above=0.0)
    """m: a match counts only if another one within this much travel agrees with it. Twice stretch_m: so two
    local maps without common scans may support each other."""

    odometry_m_per_sqrt_m: float = limited(0.1, 0.0)
    """m: odometry's standard deviation along and across after one metre."""
    odometry_rad_per_sqrt_m: float = limited(0.1, 0.0)
    """rad: odometry's standard deviation of the heading after one metre."""
    odometry_rad_per_sqrt_rad: float = limited(0.2, 0.0)
    """rad: odometry's standard deviation of the heading after one radian turned."""
    climb_m_per_sqrt_m: float = limited(0.005, 0.0)
    """m: standard deviation of the height by odometry after one metre."""
    drift_share: float = limited(0.005, 0.0)
    """Systematic part of the path's error, besides noise and matching, m per m."""
    slip_m: float = limited(10.0, above=0.0)
    """m: odometry's standard deviation along and across where a scan contradicted it (wheels slip)."""
    slip_rad: float = limited(0.3, above=0.0)
    """rad: odometry's standard deviation of the heading where a scan contradicted it."""
    step_share: float = limited(1.0, above=0.0)
    """Stiffness of steps against closures: their deviations as a share of a single match's."""
    match_sigma_m: float = limited(0.03, above=0.0)
    """m: standard deviation of a matched point from its surface."""
    match_points: float = limited(12.0, above=0.0)
    """A match's points count as at most this many independent ones, because their errors are similar."""
    closure_sigma_m: float = limited(0.02, above=0.0)
    """m: least standard deviation of a closure."""
    closure_sigma_rad: float = limited(0.003, above=0.0)
    """rad: least standard deviation of a closure's heading, because local maps are slightly bent."""
    link_range_m: float = limited(30.0, above=0.0)
    """m: beams are used up to here to link scans."""
    link_reach_m: float = limited(10.0, above=0.0)
    """m: a scan is linked with scans at most this much travel before it."""
    links_back: int = limited(3, 1)
    """A scan is linked with at most this many of the scans before it."""
    link_radius_m: float = limited(3.0, above=0.0)
    """m: a scan is linked with scans of other passes at most this far away."""
    link_separation_m: float = limited(10.0, above=0.0)
    """m: a scan is linked with scans of other passes at least this much travel before it."""
    link_gate_m: float = limited(0.3, above=0.0)
    """m: points farther apart are no pair."""
    link_pass_gate_m: float = limited(0.8, above=0.0)
    """m: the same at the start of a link with a scan of another pass."""
    link_share_min: float = limited(0.3, above=0.0, most=1.0)
    """Least share of a scan's points that have a pair in a link."""
    link_pass_share_min: float = limited(0.5, above=0.0, most=1.0)
    """The same in a link with a scan of another pass."""
    link_rms_max_m: float = limited(0.1, above=0.0)
    """m: greatest root mean square of the pairs' distances in a link."""
    correction_min_m: float = limited(0.03, above=0.0)
    """m: correct the path if a closure that is new or removed differs from it by more. At the end of the log
    it is corrected in any case."""

    def __post_init__(self) -> None:
        check_limits(self, ParameterError)
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
