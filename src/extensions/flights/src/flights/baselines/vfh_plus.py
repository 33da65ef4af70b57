"""VFH+ (Ulrich and Borenstein, "VFH+: Reliable Obstacle Avoidance for Fast Mobile Robots", ICRA 1998).

Four stages: polar histogram of obstacle density, binary histogram with hysteresis, masking by what the
vehicle can turn to, and the candidate direction of least cost. A multirotor can fly in any direction at once,
so nothing is masked. The paper's certainty grid remembers what a ring of sonars saw. A lidar sees everything
at once, so each beam is one cell of full certainty.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cepa import CepaParameters, Decision, LaserScan2D, Reason
from cepa.algorithm import Algorithm, hover
from cepa.decision import Vector2
from cepa.motion import Cloud, Motion
from cepa.scan import Beams
from flight_basics.checks import check_limits, limited
from flights.baselines.sectors import Sectors, angle_between
from flights.errors import FlightError


@dataclass(frozen=True)
class VfhPlusParameters:
    """The paper's parameters.

    sectors: 360 degrees / alpha. window_m: radius of the active window; beyond it nothing counts.
    enlargement_m: r_{r+s}, the vehicle's radius plus the distance to keep. low, high: thresholds tau of the
    binary histogram; 1 is a sector filled by obstacles right at the vehicle. wide: s_max, sectors of a wide
    opening. mu: mu_1 to mu_3, cost of a direction's angle to the goal, to the vehicle's direction of
    travel, and to the last choice; mu_1 > mu_2 + mu_3 makes it goal-directed.
    """

    sectors: int = limited(72, 12, 360)
    window_m: float = limited(4.0, above=0.0)
    enlargement_m: float = limited(0.8, above=0.0)
    low: float = limited(0.05, above=0.0)
    high: float = limited(0.15, above=0.0)
    wide: int = limited(16, 2)
    mu: tuple[float, float, float] = (5.0, 2.0, 2.0)

    def __post_init__(self) -> None:
        check_limits(self, FlightError, "VFH+'s {}")
        if self.enlargement_m >= self.window_m:
            raise FlightError("VFH+ needs enlargement_m < window_m.")
        if self.low > self.high or not min(self.mu) >= 0.0:
            raise FlightError("VFH+ needs low <= high, and no negative mu.")


class VfhPlus(Algorithm):
    """Steers the reference velocity into the best opening, at its full speed, or stops when there is none."""

    def __init__(
        self, parameters: CepaParameters | None = None, vfh_plus: VfhPlusParameters | None = None
    ) -> None:
        """parameters: CEPA's, for what all algorithms do alike to a scan (dropouts, levelling)."""
        super().__init__(parameters)
        self._p = vfh_plus or VfhPlusParameters()
        self._sectors = Sectors(self._p.sectors)
        self._blocked = np.zeros(self._p.sectors, dtype=bool)
        self._last_rad: float | None = None

    def _steer(
        self, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2, motion: Motion | None, cloud: Cloud | None
    ) -> Decision:
        beams = self.beams(scan)
        self._blocked = self.binary(self.density(beams), self._blocked)
        speed = math.hypot(*v_ref)
        if speed == 0.0:
            return hover(Reason.NO_REFERENCE, 0.0)
        goal = math.atan2(v_ref[1], v_ref[0])
        free = ~self._blocked & ~np.isnan(self._sectors.nearest(beams))
        candidates = self.candidates(free, goal)
        if not candidates:
            self._last_rad = None
            return hover(Reason.BLOCKED, math.inf)
        travel = math.atan2(v_uav[1], v_uav[0]) if math.hypot(*v_uav) > 0.1 else goal
        costs = self.costs(candidates, goal, travel)
        best = int(np.argmin(costs))
        self._last_rad = candidates[best]
        answer = speed * math.cos(self._last_rad), speed * math.sin(self._last_rad)
        reason = Reason.CUSHION_CLEAR if self._last_rad == goal else Reason.STEERED
        return Decision(answer, False, float(costs[best]), len(candidates), reason)

    def density(self, beams: Beams) -> np.ndarray:
        """Return the primary polar histogram (sectors,): what each beam weighs, over all that it blocks.

        A beam at distance d weighs 1 - (d / window)^2, times its share of a sector; it fills every sector
        within asin(r_{r+s} / d) of it, so that the vehicle may be thought of as a point (eq. 1 to 5).
        """
        counts = beams.seen & (beams.ranges < self._p.window_m)
        d, angles = beams.ranges[counts], beams.angles[counts]
        weights = (1.0 - (d / self._p.window_m) ** 2) * beams.increment / self._sectors.width_rad
        enlarged = np.arcsin(np.minimum(self._p.enlargement_m / np.maximum(d, 1e-6), 1.0))
        fills = angle_between(self._sectors.angles_rad[:, None], angles[None, :]) <= enlarged
        return fills @ weights

    def binary(self, density: np.ndarray, before: np.ndarray) -> np.ndarray:
        """Return which sectors are blocked: above high yes, below low no, in between as before (eq. 6)."""
        return (density > self._p.high) | ((density >= self._p.low) & before)

    def candidates(self, free: np.ndarray, goal_rad: float) -> list[float]:
        """Return the candidate directions, rad, of all openings (eq. 9 to 11).

        The middle of a narrow opening; of a wide one both edges, moved in by half of s_max, and the goal's
        direction when it lies between them.
        """
        if free.all():
            return [goal_rad]
        found = []
        for first, length in _runs(free):
            if length < self._p.wide:
                found.append((first + 0.5 * (length - 1)) * self._sectors.width_rad)
                continue
            right, left = first + 0.5 * self._p.wide, first + length - 1 - 0.5 * self._p.wide
            from_right = (goal_rad / self._sectors.width_rad - right) % self._sectors.count
            found += [right * self._sectors.width_rad, left * self._sectors.width_rad]
            if from_right <= left - right:
                found.append(goal_rad)
        return found

    def costs(self, candidates_rad: list[float], goal_rad: float, travel_rad: float) -> np.ndarray:
        """Return the cost of each candidate (eq. 12)."""
        goal, travel, last = self._p.mu
        before = goal_rad if self._last_rad is None else self._last_rad
        directions = np.array(candidates_rad)
        return (
            goal * angle_between(directions, goal_rad)
            + travel * angle_between(directions, travel_rad)
            + last * angle_between(directions, before)
        )


def _runs(free: np.ndarray) -> list[tuple[int, int]]:
    """Return the runs of free sectors around the turn, as first sector and length; one must be blocked."""
    begins = np.flatnonzero(free & ~np.roll(free, 1))
    return [(int(first), int(np.argmin(np.roll(free, -first)))) for first in begins]
