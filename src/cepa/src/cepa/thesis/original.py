"""The original algorithm (thesis 6.1, algorithm 1), the baseline."""

from __future__ import annotations

import math

import numpy as np

from cepa.algorithm import Algorithm, Reference, hover
from cepa.decision import Decision, Reason, Vector2
from cepa.motion import Cloud, Motion
from cepa.scan import Beams, LaserScan2D
from cepa.thesis.cushion import original_cushion
from cepa.thesis.emergency import is_emergency, original_flight
from cepa.thesis.kernels.original import best_of_all, weight


class Original(Algorithm):
    """CEPA as proposed: every beam's direction is tried at every speed, with the cushion of equation 6.2."""

    def _steer(
        self, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2, motion: Motion | None, cloud: Cloud | None
    ) -> Decision:
        # The numbers are the lines of algorithm 1. v_uav matters with velocity_aware_emergency only.
        beams = self.beams(scan)
        if is_emergency(beams, self._grid, self.parameters, v_uav):  # 2
            flight = original_flight(beams, self._grid, self.parameters, v_uav)
            proposal = flight.velocity(beams.angle_0)  # 3
            return Decision(proposal, True, math.nan, 0, Reason.EMERGENCY_SUM, proposal)
        reference = self._reference(v_ref, beams)
        if reference.speed < self.parameters.reference_speed_min:
            return hover(Reason.NO_REFERENCE, 0.0)
        cost = self._cost_of_reference(reference, beams)
        speeds = reference.speed * np.array(self.parameters.speed_fractions)
        beam, index, best_cost, tested = self._best_of_all(reference, speeds, beams)  # 5-11
        if math.isinf(cost) and beam < 0:
            return hover(Reason.BLOCKED, math.inf, tested + 1)
        if cost <= best_cost:
            return Decision(v_ref, False, cost, tested + 1, Reason.STEERED)
        return Decision(
            self._velocity(beam, speeds[index], beams), False, best_cost, tested + 1, Reason.STEERED
        )

    def _best_of_all(
        self, reference: Reference, speeds: np.ndarray, beams: Beams
    ) -> tuple[int, int, float, int]:
        p, grid = self.parameters, self._grid
        inner, outer = (
            np.array(
                [original_cushion(grid.offset_angles, speed, radius, p.time_horizon) for speed in speeds]
            )
            for radius in (p.r_lb, p.r_ub)
        )
        alignment = grid.cos * reference.x + grid.sin * reference.y
        weights = self._weights(reference)
        return best_of_all(beams.ranges, self._eligible(beams), alignment, speeds, inner, outer, *weights)

    def _cost_of_reference(self, reference: Reference, beams: Beams) -> float:
        """Return v_ref's own cost; its direction lies between two beams."""
        if not self._eligible(beams)[reference.beam]:
            return math.inf
        p, grid = self.parameters, self._grid
        psi = np.arctan2(
            grid.sin * reference.x - grid.cos * reference.y, grid.cos * reference.x + grid.sin * reference.y
        )
        inner = original_cushion(psi, reference.speed, p.r_lb, p.time_horizon)
        outer = original_cushion(psi, reference.speed, p.r_ub, p.time_horizon)
        k1, k2, k3 = self._weights(reference)
        omega = weight(beams.ranges, inner, outer, 0)
        return k3 * omega - reference.speed * (k1 + k2) if math.isfinite(omega) else math.inf

    def _weights(self, reference: Reference) -> tuple[float, float, float]:
        """Return the factors of |v| cos(psi), |v| and Omega in equation 6.5."""
        p = self.parameters
        return p.k1 * reference.speed, p.k2 / reference.speed, self._omega_weight()
