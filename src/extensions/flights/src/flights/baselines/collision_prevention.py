"""PX4's Collision Prevention, as its user guide and parameter reference describe it (PX4 1.12).

It guides the setpoint by some degrees towards more room, and limits its speed so that the UAV can stop in
front of what it sees. It does not fly around anything.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cepa import CepaParameters, Decision, LaserScan2D, Reason
from cepa.algorithm import Algorithm, hover
from cepa.decision import Vector2
from cepa.motion import Cloud, Motion
from flight_basics.checks import check_limits, limited
from flights.baselines.sectors import Sectors
from flights.errors import FlightError

_DEVIATION_PER_BIN = 0.5  # of CP_DIST; cost of the guidance for each bin away from the setpoint


@dataclass(frozen=True)
class CollisionPreventionParameters:
    """PX4's parameters; the defaults are PX4's, except for CP_DIST, which is off in PX4.

    CP_DIST: distance to keep, m. Its default here is CEPA's r_LB, because both are hard limits: the UAV does
    not fly towards anything nearer. (CEPA's r_UB is soft.) CP_DELAY: of sensor and velocity tracking, s.
    CP_GUIDE_ANG: the guidance's reach, degrees. CP_GO_NO_DAT: fly where nothing is seen. MPC_XY_P, 1/s;
    MPC_ACC_HOR, m/s2; MPC_JERK_MAX, m/s3: how the UAV brakes. bins: of the turn, of 10 degrees each.
    """

    CP_DIST: float = limited(0.5, above=0.0)
    CP_DELAY: float = limited(0.4, 0.0, 1.0)
    CP_GUIDE_ANG: float = limited(30.0, 0.0, 90.0)
    CP_GO_NO_DAT: bool = False
    MPC_XY_P: float = limited(0.95, above=0.0)
    MPC_ACC_HOR: float = limited(3.0, above=0.0)
    MPC_JERK_MAX: float = limited(8.0, above=0.0)
    bins: int = limited(36, 12, 360)

    def __post_init__(self) -> None:
        check_limits(self, FlightError)


class CollisionPrevention(Algorithm):
    """Guides and slows the reference velocity."""

    def __init__(
        self,
        parameters: CepaParameters | None = None,
        collision_prevention: CollisionPreventionParameters | None = None,
    ) -> None:
        """parameters: CEPA's, for what all algorithms do alike to a scan (dropouts, levelling)."""
        super().__init__(parameters)
        self._p = collision_prevention or CollisionPreventionParameters()
        self._sectors = Sectors(self._p.bins)

    def _steer(
        self, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2, motion: Motion | None, cloud: Cloud | None
    ) -> Decision:
        speed = math.hypot(*v_ref)
        if speed == 0.0:
            return hover(Reason.NO_REFERENCE, 0.0)
        distances = self._sectors.nearest(self.beams(scan))
        wanted = math.atan2(v_ref[1], v_ref[0])
        direction = self.guided(wanted, distances)
        allowed = min(speed, self.speed_limit(direction, distances, v_uav))
        if allowed <= 0.0:
            return hover(Reason.BLOCKED, math.inf)
        answer = allowed * math.cos(direction), allowed * math.sin(direction)
        same = allowed == speed and direction == wanted
        return Decision(answer, False, 0.0, 0, Reason.CUSHION_CLEAR if same else Reason.STEERED)

    def guided(self, wanted_rad: float, distances_m: np.ndarray) -> float:
        """Return the direction within CP_GUIDE_ANG that has most room, minus a cost for its deviation."""
        room = np.nan_to_num(np.minimum(distances_m, _far(self._p)), nan=self._p.CP_DIST)
        centre = int(self._sectors.index(wanted_rad))
        reach = int(math.radians(self._p.CP_GUIDE_ANG) / self._sectors.width_rad)
        offsets = sorted(
            range(-reach, reach + 1), key=abs
        )  # among equal ones, the nearest to the wanted direction

        def cost(offset: int) -> float:
            bin_ = (centre + offset) % self._sectors.count
            beside = np.mean([room[(bin_ + k) % self._sectors.count] for k in (-1, 0, 1)])
            seen = self._p.CP_GO_NO_DAT or not math.isnan(distances_m[bin_])
            return (
                _DEVIATION_PER_BIN * self._p.CP_DIST * abs(offset) - beside - room[bin_] if seen else math.inf
            )

        best = min(offsets, key=cost)
        return (
            wanted_rad
            if best == 0
            else float(self._sectors.angles_rad[(centre + best) % self._sectors.count])
        )

    def speed_limit(self, direction_rad: float, distances_m: np.ndarray, v_uav: tuple[float, float]) -> float:
        """Return the greatest speed, m/s, at which the UAV can stop before CP_DIST in every bin ahead."""
        if not self._p.CP_GO_NO_DAT and math.isnan(distances_m[self._sectors.index(direction_rad)]):
            return 0.0
        ahead = np.cos(self._sectors.angles_rad - direction_rad)
        x, y = np.cos(self._sectors.angles_rad), np.sin(self._sectors.angles_rad)
        closing = np.maximum(v_uav[0] * x + v_uav[1] * y, 0.0)
        counts = (ahead > 0.01) & np.isfinite(distances_m)
        stop = np.maximum(distances_m - self._p.CP_DIST - closing * self._p.CP_DELAY, 0.0)[counts]
        if stop.size == 0:
            return math.inf
        limits = np.minimum(self._p.MPC_XY_P * stop, self._stopping_speed(stop)) / ahead[counts]
        return float(limits.min())

    def _stopping_speed(self, stop_m: np.ndarray) -> np.ndarray:
        """Return the speed from which the UAV comes to rest in these distances, braking with limited jerk.

        Full braking at a is reached by jerk j only after the time a / j. With twice that as a margin the
        distance from v is s = v^2 / 2a + 2 v a / j, which is solved for v here.
        """
        a, j = self._p.MPC_ACC_HOR, self._p.MPC_JERK_MAX
        b = 4.0 * a * a / j
        return 0.5 * (-b + np.sqrt(b * b + 8.0 * a * stop_m))


def _far(p: CollisionPreventionParameters) -> float:
    """Return the distance, m, beyond which more room makes no difference."""
    return 10.0 * p.CP_DIST
