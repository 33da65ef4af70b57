"""The improved algorithm (thesis 6.2, algorithm 2)."""

from __future__ import annotations

import math

import numpy as np

from cepa.algorithm import Algorithm, Reference, hover
from cepa.decision import Decision, Reason, Vector2
from cepa.motion import Cloud, Motion
from cepa.scan import Beams, LaserScan2D
from cepa.thesis.emergency import improved_flight, is_emergency, original_flight
from cepa.thesis.kernels.improved import best_velocity, intrusion
from cepa.thesis.kernels.valid_directions import valid_directions

Weights = tuple[float, float, float]
"""The factors of |v| cos(psi), |v| and Omega in equation 6.5."""


class Improved(Algorithm):
    """CEPA with cushions that end in arcs, k1 that rises with the own speed, and a safer emergency avoidance.

    The candidates are v_ref, and each eligible beam's direction at each speed fraction. Outside an emergency
    the answer is the candidate of least cost (6.5). A search that tries all candidates would find the same.
    """

    def _steer(
        self, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2, motion: Motion | None, cloud: Cloud | None
    ) -> Decision:
        # The numbers are the lines of algorithm 2.
        beams = self.beams(scan)
        if is_emergency(beams, self._grid, self.parameters, v_uav):  # 2
            return self._flee(beams, v_uav)  # 3-6
        reference = self._reference(v_ref, beams)
        if reference.speed < self.parameters.reference_speed_min:
            return hover(Reason.NO_REFERENCE, 0.0)
        weights = self._weights(reference, v_uav)
        cost, clear = self._cost_of_reference(reference, weights, beams)
        if clear:  # 8
            return Decision(v_ref, False, cost, 1, Reason.CUSHION_CLEAR)  # 9
        return self._best_of_valid(reference, v_ref, cost, weights, beams)  # 11-20

    def _flee(self, beams: Beams, v_uav: Vector2) -> Decision:
        proposal = original_flight(beams, self._grid, self.parameters, v_uav)  # 3
        flight, reason = improved_flight(proposal, beams, self._grid, self.parameters, v_uav)  # 4-5
        original = proposal.velocity(beams.angle_0)
        improved = flight.velocity(beams.angle_0) if flight else (0.0, 0.0)
        return Decision(improved, True, math.nan, 0, reason, original, improved)

    def _weights(self, reference: Reference, v_uav: Vector2) -> Weights:
        k1 = math.hypot(*v_uav) * self.parameters.k4 + self.parameters.k5
        return k1 * reference.speed, self.parameters.k2 / reference.speed, self._omega_weight()

    def _cost_of_reference(self, reference: Reference, weights: Weights, beams: Beams) -> tuple[float, bool]:
        """Return v_ref's cost (inf when forbidden or unseen), and whether its outer cushion is clear."""
        if not self._eligible(beams)[reference.beam]:
            return math.inf, False
        p, (k1, k2, k3) = self.parameters, weights
        ahead = reference.speed * p.time_horizon
        inner, outer = (float(p.r_lb), p.r_lb + ahead), (float(p.r_ub), p.r_ub + ahead)
        grid = self._grid
        omega = intrusion(beams.ranges, grid.cos, grid.sin, reference.x, reference.y, *inner, *outer)
        if math.isinf(omega):
            return math.inf, False
        return k3 * omega - reference.speed * (k1 + k2), omega == 0.0

    def _best_of_valid(
        self, reference: Reference, v_ref: Vector2, cost: float, weights: Weights, beams: Beams
    ) -> Decision:
        p, grid = self.parameters, self._grid
        speeds = reference.speed * np.array(p.speed_fractions)
        ahead = speeds * p.time_horizon
        eligible = self._eligible(beams)
        valid = valid_directions(
            beams.ranges, eligible, grid.reach, grid.is_even, float(p.r_lb), ahead + p.r_lb
        )  # 11
        beam, index, best_cost, tested = best_velocity(
            beams.ranges,
            grid.cos,
            grid.sin,
            grid.reach,
            valid,
            reference.x,
            reference.y,
            reference.beam,
            speeds,
            float(p.r_ub),
            ahead + p.r_ub,
            *weights,
            cost,
        )  # 12-20
        tested += 1
        if beam >= 0:
            return Decision(
                self._velocity(beam, speeds[index], beams), False, best_cost, tested, Reason.STEERED
            )
        if math.isfinite(cost):
            return Decision(v_ref, False, cost, tested, Reason.STEERED)
        return hover(Reason.BLOCKED, math.inf, tested)
