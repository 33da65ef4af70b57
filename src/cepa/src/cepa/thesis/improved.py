"""The improved algorithm (thesis 6.2, algorithm 2)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cepa.algorithm import Algorithm, Reference, hover
from cepa.decision import Decision, Reason, Vector2
from cepa.motion import Cloud, Motion
from cepa.scan import Beams, LaserScan2D
from cepa.thesis.emergency import improved_flight, is_emergency, original_flight
from cepa.thesis.kernels.improved import best_velocity, intrusion
from cepa.thesis.kernels.valid_directions import valid_directions

LONGEST_GAP_S = 0.5
"""After a longer pause nobody flies the last answer any more."""


class Weights(NamedTuple):
    """Equation 6.5 as -|v| (along cos(angle to the favoured direction) + k2) + k3 Omega."""

    x: float
    """The favoured direction, relative to beam 0: a unit vector."""
    y: float
    beam: int
    """The beam nearest to it."""
    cos_of_reference: float
    """Of the angle between it and v_ref."""
    along: float
    """At least 0."""
    k2: float
    k3: float


class Improved(Algorithm):
    """CEPA with cushions that end in arcs, k1 that rises with the own speed, and a safer emergency avoidance.

    The candidates are v_ref, and each eligible beam's direction at each speed fraction. Outside an emergency
    the answer is the candidate of least cost (6.5). A search that tries all candidates would find the same.

    With ``k_previous`` a velocity v at an angle theta to the last answer costs more by k_previous |v_ref| |v|
    (1 - cos theta). So the answer does not change sides from scan to scan, when the best directions on both
    sides of an obstacle cost the same but for the noise. The last answer is forgotten in an emergency, when
    the UAV is told to stand, and after LONGEST_GAP_S.
    """

    def reset(self) -> None:
        """Forget the last answer."""
        super().reset()
        self._previous: Vector2 | None = None  # in the scan's frame

    def on_next_scan(self, gap_s: float, turn_rad: float) -> None:
        """Take in what `Algorithm.on_next_scan` says."""
        if self._previous is None:
            return
        if not 0.0 <= gap_s <= LONGEST_GAP_S:
            self._previous = None
            return
        x, y = self._previous
        c, s = math.cos(turn_rad), math.sin(turn_rad)
        self._previous = c * x + s * y, c * y - s * x

    def _steer(
        self, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2, motion: Motion | None, cloud: Cloud | None
    ) -> Decision:
        decision = self._decide(scan, v_ref, v_uav)
        moves = not decision.emergency and decision.velocity_xy != (0.0, 0.0)
        self._previous = decision.velocity_xy if moves else None
        return decision

    def _decide(self, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2) -> Decision:
        # The numbers are the lines of algorithm 2.
        beams = self.beams(scan)
        if is_emergency(beams, self._grid, self.parameters, v_uav):  # 2
            return self._flee(beams, v_uav)  # 3-6
        reference = self._reference(v_ref, beams)
        if reference.speed < self.parameters.reference_speed_min:
            return hover(Reason.NO_REFERENCE, 0.0)
        weights = self._weights(reference, v_uav, beams)
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

    def _weights(self, reference: Reference, v_uav: Vector2, beams: Beams) -> Weights:
        p = self.parameters
        k1 = (math.hypot(*v_uav) * p.k4 + p.k5) * reference.speed
        k2 = p.k2 / reference.speed
        thesis = Weights(reference.x, reference.y, reference.beam, 1.0, k1, k2, self._omega_weight())
        if p.k_previous == 0.0 or self._previous is None:
            return thesis
        # Two cosines with their weights are one cosine, to the direction of the sum of both vectors.
        k_previous = p.k_previous * reference.speed
        angle = math.atan2(self._previous[1], self._previous[0]) - beams.angle_0
        x = k1 * reference.x + k_previous * math.cos(angle)
        y = k1 * reference.y + k_previous * math.sin(angle)
        along = math.hypot(x, y)
        if along == 0.0:
            return thesis._replace(along=0.0, k2=k2 - k_previous)
        x, y = x / along, y / along
        beam, cosine = self._grid.index(math.atan2(y, x)), x * reference.x + y * reference.y
        return Weights(x, y, beam, cosine, along, k2 - k_previous, thesis.k3)

    def _cost_of_reference(self, reference: Reference, weights: Weights, beams: Beams) -> tuple[float, bool]:
        """Return v_ref's cost (inf when forbidden or unseen), and whether its outer cushion is clear."""
        if not self._eligible(beams)[reference.beam]:
            return math.inf, False
        p = self.parameters
        ahead = reference.speed * p.time_horizon
        inner, outer = (float(p.r_lb), p.r_lb + ahead), (float(p.r_ub), p.r_ub + ahead)
        grid = self._grid
        omega = intrusion(beams.ranges, grid.cos, grid.sin, reference.x, reference.y, *inner, *outer)
        if math.isinf(omega):
            return math.inf, False
        travel = reference.speed * (weights.along * weights.cos_of_reference + weights.k2)
        return weights.k3 * omega - travel, omega == 0.0

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
            weights.x,
            weights.y,
            weights.beam,
            speeds,
            float(p.r_ub),
            ahead + p.r_ub,
            weights.along,
            weights.k2,
            weights.k3,
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
