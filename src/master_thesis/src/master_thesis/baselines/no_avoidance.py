"""No avoidance at all: how often does a straight flight hit something?"""

from __future__ import annotations

from typing import Sequence

from cepa import Decision, LaserScan2D, Reason
from cepa.algorithm import Algorithm, velocity
from cepa.motion import Cloud, Motion


class NoAvoidance(Algorithm):
    """Answers the reference velocity."""

    def steer(
        self,
        scan: LaserScan2D,
        v_ref_xy: Sequence[float],
        v_uav_xy: Sequence[float] = (0.0, 0.0),
        motion: Motion | None = None,
        cloud: Cloud | None = None,
    ) -> Decision:
        """Return v_ref. Raises VelocityError when it is not two finite numbers."""
        return Decision(velocity(v_ref_xy, "v_ref"), False, 0.0, 0, Reason.CUSHION_CLEAR)
