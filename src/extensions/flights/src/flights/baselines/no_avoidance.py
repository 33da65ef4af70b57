"""No avoidance at all: how often does a straight flight hit something?"""

from __future__ import annotations

from cepa import Decision, LaserScan2D, Reason
from cepa.algorithm import Algorithm
from cepa.decision import Vector2
from cepa.motion import Cloud, Motion


class NoAvoidance(Algorithm):
    """Answers the reference velocity."""

    def _steer(
        self, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2, motion: Motion | None, cloud: Cloud | None
    ) -> Decision:
        return Decision(v_ref, False, 0.0, 0, Reason.CUSHION_CLEAR)
