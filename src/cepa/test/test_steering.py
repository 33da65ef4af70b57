"""Steering outside emergencies: both algorithms against trying everything, slowly, from the equations."""

import math
from dataclasses import replace

import numpy as np
import plain_cepa as reference
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_scans import parameter_sets, recipes, velocities

from cepa import CepaParameters, Improved, LaserScan2D, Original, Reason, VelocityError
from cepa.algorithm import GREATEST_SPEED_M_S
from cepa.scan import Grid
from cepa.thesis.cushion import improved_cushion, original_cushion
from cepa.thesis.kernels.valid_directions import valid_directions

EXAMPLES = settings(max_examples=150, deadline=None)
TURN = 2.0 * math.pi


def empty_scan(beams=144, seen=None):
    return LaserScan2D(np.full(beams, np.inf), -math.pi, TURN / beams, 0.05, 12.0, seen)


def scan_of(hits, beams=1440, background=math.inf):
    """A scan with single readings ``hits`` {degrees: metres}."""
    ranges = np.full(beams, background)
    for degrees, metres in hits.items():
        ranges[round((degrees + 180.0) / 360.0 * beams) % beams] = metres
    return LaserScan2D(ranges, -math.pi, TURN / beams, 0.05, 12.0)


@EXAMPLES
@given(recipes(), velocities, velocities, parameter_sets)
def test_improved_equals_brute_force(recipe, v_ref, v_uav, parameters):
    scan = recipe.scan()
    decision = Improved(parameters).steer(scan, v_ref, v_uav)
    _, costs = reference.improved_costs(parameters, scan, v_ref, v_uav)
    least = costs.min(initial=math.inf)
    if math.isinf(least):
        assert (decision.reason, decision.velocity_xy) == (Reason.BLOCKED, (0.0, 0.0))
    else:
        assert decision.cost == pytest.approx(least, rel=1e-9, abs=1e-9)
        assert cost_of(parameters, scan, decision.velocity_xy, v_ref, v_uav) == pytest.approx(
            least, rel=1e-9, abs=1e-9
        )


@EXAMPLES
@given(recipes(), st.floats(-0.5, 0.5), velocities, velocities, parameter_sets)
def test_improved_equals_brute_force_if_beams_do_not_divide_the_turn(
    recipe, beyond, v_ref, v_uav, parameters
):
    scan = replace(recipe, beams_per_turn=recipe.beams_per_turn + beyond).scan()
    decision = Improved(parameters).steer(scan, v_ref, v_uav)
    _, costs = reference.improved_costs(parameters, scan, v_ref, v_uav)
    assert decision.cost == pytest.approx(costs.min(initial=math.inf), rel=1e-9, abs=1e-9)


@pytest.mark.table("turn_in_beams", [2.0, 3.4, 8.0, 8.4, 8.6, 9.0, 9.4, 20.3, 20.7])
def test_one_obstacle_forbids_its_angle_on_both_sides_across_the_seam_too(turn_in_beams):
    """For every beam: before, on and behind the edge of the cushion (`Grid`), min(length, r_lb reach).

    On the edge only if the increment does not divide the turn. Else rounding differs on its two sides.
    """
    grid = Grid(round(turn_in_beams), TURN / turn_in_beams)
    beams, everywhere, length_m = np.arange(grid.count), np.ones(grid.count, bool), np.array([2.0])
    edges_m = 0.5 * np.unique(grid.reach[np.isfinite(grid.reach)])
    for obstacle in beams:
        edge = np.minimum(length_m[0], 0.5 * grid.reach[obstacle - beams + grid.count - 1])
        for distance_m in (
            0.4,
            *(0.999 * edges_m),
            *(edges_m if not grid.is_even else ()),
            *(1.001 * edges_m),
        ):
            ranges = np.where(beams == obstacle, distance_m, math.inf)
            valid = valid_directions(ranges, everywhere, grid.reach, grid.is_even, 0.5, length_m)
            np.testing.assert_array_equal(valid[0], distance_m > edge)


@given(recipes(), velocities, parameter_sets)
def test_original_equals_brute_force(recipe, v_ref, parameters):
    scan = recipe.scan()
    decision = Original(parameters).steer(scan, v_ref)
    velocities_xy, costs = reference.original_costs(parameters, scan, v_ref)
    least = costs.min(initial=math.inf)
    if math.isinf(least):
        assert (decision.reason, decision.velocity_xy) == (Reason.BLOCKED, (0.0, 0.0))
    else:
        assert decision.cost == pytest.approx(least, rel=1e-9, abs=1e-9)
        beams = scan.full_turn(parameters.dropout_beams)
        again = reference.cost(
            parameters, beams, decision.velocity_xy, v_ref, parameters.k1, original_cushion
        )
        assert again == pytest.approx(least, rel=1e-9, abs=1e-9)
    assert decision.directions_tested in (len(velocities_xy), len(velocities_xy) + 1)


@EXAMPLES
@given(recipes(), velocities, velocities)
def test_no_answer_has_an_obstacle_in_its_inner_cushion(recipe, v_ref, v_uav):
    parameters = CepaParameters()
    scan = recipe.scan()
    decision = Improved(parameters).steer(scan, v_ref, v_uav)
    if decision.velocity_xy == (0.0, 0.0):
        return
    beams = scan.full_turn(parameters.dropout_beams)
    psi = reference.wrap(beams.angles - math.atan2(*decision.velocity_xy[::-1]))
    speed = math.hypot(*decision.velocity_xy)
    edge = improved_cushion(psi, speed, parameters.r_lb, parameters.time_horizon)
    assert (beams.ranges > edge).all()


def cost_of(parameters, scan, velocity, v_ref, v_uav):
    k1 = math.hypot(*v_uav) * parameters.k4 + parameters.k5
    beams = scan.full_turn(parameters.dropout_beams)
    return reference.cost(parameters, beams, velocity, v_ref, k1, improved_cushion)


@pytest.mark.parametrize("algorithm", [Improved, Original])
class TestBoth:
    def test_in_the_open_v_ref_is_the_answer_to_the_last_bit(self, algorithm):
        decision = algorithm().steer(empty_scan(), (1.234, -0.567), (2.0, 0.0))
        assert decision.velocity_xy == (1.234, -0.567)
        assert not decision.emergency

    @pytest.mark.parametrize("v_ref", [(0.0, 0.0), (0.03, -0.02)])
    def test_without_a_reference_it_hovers(self, algorithm, v_ref):
        decision = algorithm().steer(empty_scan(), v_ref, (2.0, 0.0))
        assert (decision.velocity_xy, decision.reason) == ((0.0, 0.0), Reason.NO_REFERENCE)

    def test_too_close_to_measure_is_an_emergency(self, algorithm):
        decision = algorithm().steer(scan_of({0.0: -math.inf}), (1.0, 0.0))
        assert decision.emergency
        assert decision.velocity_xy[0] < 0.0

    def test_an_obstacle_exactly_at_r_lb_is_an_emergency(self, algorithm):
        assert algorithm().steer(scan_of({0.0: 0.5}), (1.0, 0.0)).emergency
        assert not algorithm().steer(scan_of({0.0: 0.5 + 1e-9}), (1.0, 0.0)).emergency

    def test_when_no_direction_is_free_it_stands_still(self, algorithm):
        # The slowest inner cushion, 0.2 m/s x 1.5 s + 0.5 m, reaches farther
        ring = scan_of({}, background=0.6)
        decision = algorithm().steer(ring, (1.0, 0.0))
        assert (decision.velocity_xy, decision.reason) == ((0.0, 0.0), Reason.BLOCKED)
        assert not decision.emergency
        assert math.isinf(decision.cost)

    def test_the_unseen_is_not_chosen(self, algorithm):
        seen = np.zeros(144, bool)
        seen[36:109] = True  # 90 degrees to either side
        decision = algorithm().steer(empty_scan(seen=seen), (-1.0, 0.1), (0.0, 0.0))
        assert abs(math.atan2(*decision.velocity_xy[::-1])) <= math.pi / 2 + 1e-9
        free = algorithm(CepaParameters(unseen_is_free=True)).steer(
            empty_scan(seen=seen), (-1.0, 0.1), (0.0, 0.0)
        )
        assert free.velocity_xy == (-1.0, 0.1)

    def test_a_scan_without_any_valid_beam_blocks(self, algorithm):
        scan = LaserScan2D(np.full(144, np.nan), -math.pi, TURN / 144, 0.05, 12.0)
        assert algorithm().steer(scan, (1.0, 0.0)).reason is Reason.BLOCKED

    def test_weights_of_zero_are_allowed(self, algorithm):
        parameters = CepaParameters(k1=0.0, k2=0.0, k3=0.0, k4=0.0, k5=0.0)
        decision = algorithm(parameters).steer(scan_of({0.0: 1.0}), (1.0, 0.0))
        assert decision.cost == 0.0

    @pytest.mark.parametrize(
        "bad", [(math.nan, 0.0), (1.0,), "ab", None, (1e160, 0.0), (0.0, -1.1e6), (10**400, 0)]
    )
    def test_a_velocity_that_is_none_is_refused(self, algorithm, bad):
        with pytest.raises(VelocityError):
            algorithm().steer(empty_scan(), bad)
        with pytest.raises(VelocityError):
            algorithm().steer(empty_scan(), (1.0, 0.0), bad)

    def test_the_greatest_speed_still_has_a_cost(self, algorithm):
        speed = GREATEST_SPEED_M_S * math.sqrt(0.5)
        decision = algorithm().steer(scan_of({0.0: 2.0}), (speed, speed), (speed, -speed))
        assert math.isfinite(decision.cost) or decision.reason is Reason.BLOCKED
        assert algorithm().steer(empty_scan(), (speed, speed)).velocity_xy == (speed, speed)

    def test_one_tuning_serves_every_lidar(self, algorithm):
        def answer(beams):
            angles = -math.pi + np.arange(beams) * TURN / beams
            wall = np.where(np.cos(angles) > 0.1, 2.0 / np.maximum(np.cos(angles), 0.1), np.inf)
            scan = LaserScan2D(wall, -math.pi, TURN / beams, 0.05, 12.0)
            return algorithm().steer(scan, (1.0, 0.5), (1.0, 0.0))

        coarse, fine = answer(720), answer(2880)
        assert coarse.velocity_xy == pytest.approx(fine.velocity_xy, abs=0.05)
        assert coarse.cost == pytest.approx(fine.cost, rel=0.02)

    def test_the_lidars_geometry_may_change_between_scans(self, algorithm):
        one = algorithm()
        for beams in (144, 90, 144):
            assert one.steer(empty_scan(beams), (1.0, 0.0)).velocity_xy == (1.0, 0.0)


def test_improved_goes_round_a_column_by_exactly_the_removed_angle():
    # k3 zero: the least turn that the inner cushion allows, asin(r_lb / LS) and on to the next whole beam
    parameters = CepaParameters(k3=0.0, k5=1000.0, k2=1000.0, speed_fractions=(1.0,))
    decision = Improved(parameters).steer(scan_of({0.0: 2.0}), (2.0, 0.0))
    turned = math.degrees(abs(math.atan2(*decision.velocity_xy[::-1])))
    least = math.degrees(math.asin(0.5 / 2.0))
    assert least < turned <= least + 0.25


def test_improved_ignores_what_lies_beyond_its_cushions():
    decision = Improved().steer(scan_of({0.0: 4.21}), (2.0, 0.0))  # |v| T + r_UB = 4.2 m
    assert decision.reason is Reason.CUSHION_CLEAR
    assert decision.directions_tested == 1
    assert Improved().steer(scan_of({0.0: 4.19}), (2.0, 0.0)).reason is Reason.STEERED


def test_k1_rises_with_the_own_speed():
    parameters = CepaParameters(k4=2.0, k5=3.0, k2=5.0)
    still = Improved(parameters).steer(empty_scan(), (2.0, 0.0), (0.0, 0.0))
    flying = Improved(parameters).steer(empty_scan(), (2.0, 0.0), (0.0, -1.5))
    assert still.cost == pytest.approx(-3.0 * 4.0 - 5.0)
    assert flying.cost == pytest.approx(-(1.5 * 2.0 + 3.0) * 4.0 - 5.0)


def test_the_search_tests_few_directions():
    rng = np.random.default_rng(1)
    hits = {float(angle): float(rng.uniform(1.5, 6.0)) for angle in rng.uniform(-180.0, 180.0, 40)}
    decision = Improved().steer(scan_of(hits), (2.0, 0.0), (2.0, 0.0))
    assert 1 < decision.directions_tested < 1440
