"""What a track must show to count as moving, and what moves at a scan."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import SPREAD_MOST_M
from cepa.errors import ParameterError
from flight_basics.checks import check_limits, limited

NO_VECTORS, NO_RADII, NO_COVARIANCES = np.empty((0, 2)), np.empty(0), np.empty((0, 2, 2))


@dataclass(frozen=True)
class TrackerParameters:
    """What counts as moving. Raises ParameterError for a value that is not above 0."""

    cluster_gap_m: float = limited(0.3, above=0.0)
    """m: Points that are farther apart belong to different things. Source: chosen. Greater: things beside
    each other are one."""
    least_points: int = limited(3, above=0.0)
    """points: A thing with fewer is not tracked. Source: chosen. Greater: small things are found later."""
    greatest_radius_m: float = limited(2.6, above=0.0)
    """m: A larger thing, such as a wall, is taken as standing. Source: chosen. Greater: pieces of walls are
    tracked."""
    deviation_m: float = limited(0.05, above=0.0)
    """m: Standard deviation of a thing's middle, with that of the odometry from scan to scan. Source: chosen.
    Greater: velocities come later."""
    deviation_hidden_m: float = limited(0.3, above=0.0)
    """m: The same where something hides a part of it. Source: chosen. Greater: velocities come later."""
    acceleration_m_s2: float = limited(0.6, above=0.0)
    """m/s²: How much a velocity changes within 1 s, standard deviation. Source: chosen. Greater: velocities
    follow faster."""
    speed_first_m_s: float = limited(1.0, above=0.0)
    """m/s: Standard deviation of the velocity of what appears. Source: chosen. Greater: what appears has a
    velocity sooner."""
    gate_m: float = limited(0.3, above=0.0)
    """m: How far from its predicted place a thing is looked for, beyond three standard deviations. Source:
    chosen. Greater: tracks jump to neighbours."""
    free_gap_m: float = limited(0.2, above=0.0)
    """m: A place was free if a beam went so much farther. Source: chosen. Greater: less evidence."""
    share: float = limited(0.2, above=0.0)
    """1: Share of a thing's points that must be where it was free. Source: chosen. Greater: less evidence."""
    speed_min_m_s: float = limited(0.35, above=0.0)
    """m/s: Slower things stand. Source: chosen. Greater: slow walkers count as standing."""
    significance: float = limited(2.0, above=0.0)
    """1: A velocity counts if it is so many times its standard deviation. Source: chosen. Greater: motion is
    found later."""
    hovering_m_s: float = limited(0.5, above=0.0)
    """m/s: A UAV that is slower hovers. It sees the same sides of a thing all the time, and it does not fly
    away from who comes slowly. Source: chosen. Greater: slow walkers are found while it flies, but more of
    what stands seems to move."""
    speed_min_hovering_m_s: float = limited(0.25, above=0.0)
    """m/s: `speed_min_m_s` while the UAV hovers. Source: chosen. Greater: slow walkers count as standing."""
    significance_hovering: float = limited(1.0, above=0.0)
    """1: `significance` while the UAV hovers. Source: chosen. Greater: slow walkers are found later."""
    evidence_s: float = limited(0.07, above=0.0)
    """s: How long the evidence must last. Source: chosen. Greater: motion is found later."""
    floor_gap_m: float = limited(0.3, above=0.0)
    """m: What is so near to floor or ceiling is not tracked: both seem to move when the lidar tilts. Source:
    chosen. Greater: less is tracked."""
    floor_gap_share: float = limited(0.03, above=0.0)
    """m/m: Added to that for each metre of distance, for the errors of the attitude. Source: chosen. Greater:
    less is tracked."""
    forget_s: float = limited(1.0, above=0.0)
    """s: What moves is predicted so long where nobody sees it. Source: chosen. Greater: it evades what has
    gone."""

    def __post_init__(self) -> None:
        check_limits(self, ParameterError, "The tracker's {}")

    def least(self, speed_m_s: float) -> tuple[float, float]:
        """Return which speed, m/s, and how many standard deviations a velocity must exceed.

        speed_m_s: of the UAV.
        """
        if speed_m_s < self.hovering_m_s:
            return self.speed_min_hovering_m_s, self.significance_hovering
        return self.speed_min_m_s, self.significance


@dataclass(frozen=True, eq=False)
class MovingTracks:
    """What moves at a scan, in the odometry's frame."""

    positions: np.ndarray
    """(k, 2) m: of the middles."""
    velocities: np.ndarray
    """(k, 2) m/s"""
    radii: np.ndarray
    """(k,) m"""
    covariances: np.ndarray
    """(k, 2, 2): of position and velocity along any axis."""
    is_moving: np.ndarray
    """(n,) bool: which of the scan's points belong to what moves."""

    def movers(self, origin_xy: np.ndarray, deviations: float = 2.0) -> np.ndarray:
        """Return what moves, as growing discs (k, 6): x, y, vx, vy, radius, growth of the radius in m/s.

        The positions count from ``origin_xy``. A disc holds the thing with so many standard deviations, but
        at most SPREAD_MOST_M: a thing that is long out of sight would else close all ways.
        """
        spread = deviations * np.sqrt(self.covariances[:, [0, 1], [0, 1]])
        np.minimum(spread[:, 0], SPREAD_MOST_M, out=spread[:, 0])
        return np.column_stack(
            (self.positions - origin_xy, self.velocities, self.radii + spread[:, 0], spread[:, 1])
        )


@lru_cache(maxsize=1)
def nothing_moves(points: int) -> MovingTracks:
    """Return that none of so many points moves; nobody changes it."""
    return MovingTracks(NO_VECTORS, NO_VECTORS, NO_RADII, NO_COVARIANCES, np.zeros(points, bool))
