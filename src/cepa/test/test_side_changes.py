"""The cost of leaving the last answer's direction: `improved` keeps its side of an obstacle."""

import math
from dataclasses import replace

import numpy as np
import plain_cepa as reference
import pytest
from hypothesis import given, settings
from planar_flight import Lidar, Scene, turn
from random_scans import recipes, steady_parameter_sets, velocities

from cepa import CepaParameters, Improved, LaserScan2D, Reason
from cepa.thesis.improved import LONGEST_GAP_S

EXAMPLES = settings(max_examples=150, deadline=None)
SCAN_S = 0.025
THESIS = CepaParameters(speed_fractions=(0.8, 0.6, 0.4, 0.2))
STEADY = replace(THESIS, k_previous=4.0)
V_REF = (2.0, 0.0)
TRUNK = Scene(np.array([(2.6, 0.0, 0.18)]))
"""Straight ahead, so that both sides of it cost the same."""


def after(parameters: CepaParameters, previous) -> Improved:
    """Return an algorithm whose last answer was ``previous``: in the open it was asked for it."""
    improved = Improved(parameters)
    open_scan = LaserScan2D(np.full(144, np.inf), -math.pi, 2.0 * math.pi / 144, 0.05, 12.0)
    assert improved.steer(open_scan, previous).velocity_xy == previous
    improved.on_next_scan(SCAN_S, 0.0)
    return improved


def noisy_scan(seed: int) -> LaserScan2D:
    return Lidar().scan(TRUNK, (0.0, 0.0), 0.0, np.random.default_rng(seed))


@EXAMPLES
@given(recipes(), velocities, velocities, velocities, steady_parameter_sets)
def test_the_search_finds_the_least_cost_of_all_candidates(recipe, v_ref, v_uav, previous, parameters):
    scan = recipe.scan()
    decision = after(parameters, previous).steer(scan, v_ref, v_uav)
    every, costs = reference.improved_costs(parameters, scan, v_ref, v_uav)
    costs = costs + reference.cost_of_leaving(parameters, every, v_ref, previous)
    if decision.reason is Reason.CUSHION_CLEAR:  # line 8 of algorithm 2 asks nothing else
        assert decision.velocity_xy == v_ref
        return
    least = costs.min(initial=math.inf)
    assert decision.cost == pytest.approx(least, rel=1e-9, abs=1e-9)
    if math.isfinite(least):
        k1 = math.hypot(*v_uav) * parameters.k4 + parameters.k5
        beams, own = scan.full_turn(parameters.dropout_beams), np.array([decision.velocity_xy])
        again = reference.cost(parameters, beams, decision.velocity_xy, v_ref, k1, reference.improved_cushion)
        again += reference.cost_of_leaving(parameters, own, v_ref, previous)[0]
        assert again == pytest.approx(least, rel=1e-9, abs=1e-9)


@EXAMPLES
@given(recipes(), velocities, velocities, velocities, steady_parameter_sets)
def test_with_0_it_is_the_thesis_to_the_last_bit(recipe, v_ref, v_uav, previous, parameters):
    thesis, scan = replace(parameters, k_previous=0.0), recipe.scan()
    fresh = Improved(thesis).steer(scan, v_ref, v_uav)
    assert after(thesis, previous).steer(scan, v_ref, v_uav) == fresh
    assert Improved(parameters).steer(scan, v_ref, v_uav) == fresh  # without a last answer nothing is left


def test_a_trunk_straight_ahead_is_passed_on_the_side_that_was_begun():
    """Noise alone decides the side otherwise: the thesis's algorithm takes both."""
    sides = {}
    for parameters in (THESIS, STEADY):
        improved, taken = Improved(parameters), []
        for seed in range(40):
            taken.append(math.copysign(1.0, improved.steer(noisy_scan(seed), V_REF, V_REF).velocity_xy[1]))
            improved.on_next_scan(SCAN_S, 0.0)
        sides[parameters] = np.count_nonzero(np.diff(taken))
    assert sides[THESIS] > 5
    assert sides[STEADY] == 0


@pytest.mark.table("side", [1.0, -1.0])
def test_the_side_is_that_of_the_last_answer(side):
    for seed in range(10):
        decision = after(STEADY, (1.2, 1.0 * side)).steer(noisy_scan(seed), V_REF, V_REF)
        assert decision.velocity_xy[1] * side > 0.0


def test_the_last_answer_turns_with_the_lidar():
    """As if everything but the lidar had stood still: the trunk is where it was, and so is the answer."""
    turn_rad = math.radians(8.0)
    upright = after(STEADY, (1.2, 1.0)).steer(noisy_scan(0), V_REF, V_REF)
    turned = after(STEADY, (1.2, 1.0))
    turned.on_next_scan(SCAN_S, turn_rad)
    scan = noisy_scan(0)
    scan = replace(scan, angle_min=scan.angle_min - turn_rad)  # the same beams, seen from the turned lidar
    v_ref = turn(V_REF, -turn_rad)
    decision = turned.steer(scan, v_ref, v_ref)
    assert decision.cost == pytest.approx(upright.cost, rel=1e-9)
    assert turn(decision.velocity_xy, turn_rad) == pytest.approx(upright.velocity_xy, abs=1e-9)


def forgets(improved: Improved) -> bool:
    """Return whether an algorithm answers a scan as one that has never answered."""
    return improved.steer(noisy_scan(0), V_REF, V_REF) == Improved(STEADY).steer(noisy_scan(0), V_REF, V_REF)


@pytest.mark.table("gap_s", [1.01 * LONGEST_GAP_S, -SCAN_S, math.nan])
def test_the_last_answer_is_forgotten_after_a_pause_and_when_the_clock_goes_back(gap_s):
    improved = after(STEADY, (1.2, 1.0))
    improved.on_next_scan(gap_s, 0.0)
    assert forgets(improved)


def test_the_last_answer_is_forgotten_after_a_reset_a_stop_and_an_emergency():
    near = LaserScan2D(np.full(144, 0.4), -math.pi, 2.0 * math.pi / 144, 0.05, 12.0)
    improved = after(STEADY, (1.2, 1.0))
    assert not forgets(improved)
    improved.reset()
    assert forgets(improved)
    for scan, v_ref, is_emergency in ((noisy_scan(1), (0.0, 0.0), False), (near, V_REF, True)):
        improved = after(STEADY, (1.2, 1.0))
        assert improved.steer(scan, v_ref).emergency is is_emergency
        improved.on_next_scan(SCAN_S, 0.0)
        assert forgets(improved)
