"""The emergency that comes earlier the faster the UAV flies: closed forms, and the slow reference."""

import math
from dataclasses import replace

import numpy as np
import plain_cepa as reference
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planar_flight import Scene
from random_scans import recipes, velocities

from cepa import CepaParameters, Improved, LaserScan2D, Original, Reason, view
from cepa.algorithm import GREATEST_SPEED_M_S, normal_form
from cepa.scan import Grid
from cepa.thesis.cushion import emergency_edge, stopping_distance
from cepa.thesis.emergency import edges

EXAMPLES = settings(max_examples=60, deadline=None)
TURN = 2.0 * math.pi
P = CepaParameters(velocity_aware_emergency=True, braking_deceleration=4.0, braking_latency=0.25)
near_and_far = recipes(0.3, 1.0)
brakes = st.builds(
    CepaParameters,
    velocity_aware_emergency=st.just(True),
    braking_deceleration=st.floats(0.5, 10.0),
    braking_latency=st.floats(0.0, 1.0),
    r_lb=st.sampled_from([0.4, 0.5, 0.8]),
)
"""2 m/s, for instance: 2^2 / (2 x 4) + 2 x 0.25 = 1 m to stop."""


def look(scene: Scene, beams=1440) -> LaserScan2D:
    angles = -math.pi + np.arange(beams) * TURN / beams
    ranges = scene.ranges(np.zeros(2), np.stack([np.cos(angles), np.sin(angles)], axis=1))
    return LaserScan2D(ranges, -math.pi, TURN / beams, 0.05, 12.0)


def post(x, y, radius=0.05):
    return look(Scene(np.array([(x, y, radius)])))


@pytest.mark.table(("speed", "stopping"), [(0.0, 0.0), (1.0, 0.375), (2.0, 1.0), (4.0, 3.0)])
def test_the_stopping_distance_is_that_of_the_closed_form(speed, stopping):
    assert stopping_distance(speed, 4.0, 0.25) == pytest.approx(stopping)


@pytest.mark.table("algorithm", [Improved, Original])
@pytest.mark.table(("distance", "expected"), [(1.49, True), (1.51, False)])
def test_an_obstacle_within_stopping_distance_and_r_lb_is_an_emergency(algorithm, distance, expected):
    decision = algorithm(P).steer(post(distance + 0.05, 0.0), (2.0, 0.0), (2.0, 0.0))
    assert decision.emergency == expected
    assert not algorithm(P).steer(post(distance + 0.05, 0.0), (2.0, 0.0), (-2.0, 0.0)).emergency
    assert not algorithm().steer(post(distance + 0.05, 0.0), (2.0, 0.0), (2.0, 0.0)).emergency


@pytest.mark.table(("aside", "expected"), [(0.34, True), (0.36, False)])
def test_what_the_body_passes_while_it_brakes_is_no_emergency(aside, expected):
    # the post's surface is `aside` from the straight way on, and the body's radius is 0.35 m
    assert Improved(P).steer(post(1.0, aside + 0.05), (2.0, 0.0), (2.0, 0.0)).emergency == expected


@pytest.mark.table("algorithm", [Improved, Original])
def test_it_flees_from_what_it_cannot_brake_for(algorithm):
    decision = algorithm(P).steer(post(1.2, 0.0), (2.0, 0.0), (2.0, 0.0))
    assert decision.reason is Reason.EMERGENCY_SUM
    assert decision.velocity_xy[0] < 0.0
    assert math.atan2(*decision.velocity_xy[::-1]) % TURN == pytest.approx(math.pi, abs=0.01)


def test_its_push_is_that_of_the_closed_form():
    # an arc about the UAV at 1.2 m, +-0.1 rad ahead; the edge there is at 0.5 + 1.0 m, where 0.35 / sin(0.1)
    # = 3.5 m does not limit it: integral of (1.5 - 1.2) cos t over +-0.1 rad
    ranges = np.full(14400, math.inf)
    angles = -math.pi + np.arange(14400) * TURN / 14400
    ranges[np.abs(angles) <= 0.1] = 1.2
    scan = LaserScan2D(ranges, -math.pi, TURN / 14400, 0.05, 12.0)
    parameters = replace(P, emergency_gain=7.0, v_min=0.0, v_max=5.0, k_filter=1000.0)
    decision = Original(parameters).steer(scan, (2.0, 0.0), (2.0, 0.0))
    assert decision.velocity_xy == pytest.approx((-7.0 * 0.3 * 2.0 * math.sin(0.1), 0.0), abs=2e-3)


@EXAMPLES
@given(near_and_far, velocities, velocities, brakes)
def test_it_is_an_emergency_exactly_where_the_reference_says_so(recipe, v_ref, v_uav, parameters):
    scan = recipe.scan()
    beams = normal_form(scan, parameters)
    edge = reference.emergency_edges(parameters, beams, v_uav)
    fast = edges(beams, Grid(beams.ranges.size, beams.increment), parameters, v_uav)
    assert fast == pytest.approx(edge, rel=1e-9, abs=1e-9)
    depth = float((edge - beams.ranges).max())
    if abs(depth) > 1e-9:
        assert Improved(parameters).steer(scan, v_ref, v_uav).emergency == (depth > 0.0)
        assert Original(parameters).steer(scan, v_ref, v_uav).emergency == (depth > 0.0)


@EXAMPLES
@given(near_and_far, velocities, velocities, brakes)
def test_it_comes_earlier_never_later_and_ever_earlier_with_speed(recipe, v_ref, v_uav, parameters):
    scan = recipe.scan()
    off = Improved(replace(parameters, velocity_aware_emergency=False)).steer(scan, v_ref, v_uav).emergency
    slow = Improved(parameters).steer(scan, v_ref, (0.5 * v_uav[0], 0.5 * v_uav[1])).emergency
    fast = Improved(parameters).steer(scan, v_ref, v_uav).emergency
    assert off <= slow <= fast


@EXAMPLES
@given(near_and_far, velocities, velocities, brakes)
def test_its_direction_is_safe_whenever_a_safe_direction_exists(recipe, v_ref, v_uav, parameters):
    scan = recipe.scan()
    decision = Improved(parameters).steer(scan, v_ref, v_uav)
    if not decision.emergency:
        return
    beams = normal_form(scan, parameters)
    if decision.reason is Reason.BLOCKED:
        assert not any(reference.is_safe(parameters, beams, angle) for angle in beams.angles[beams.seen])
    else:
        assert reference.is_safe(parameters, beams, math.atan2(*decision.velocity_xy[::-1]))


@EXAMPLES
@given(near_and_far, velocities, velocities, brakes)
def test_at_rest_and_switched_off_it_is_the_thesis_emergency(recipe, v_ref, v_uav, parameters):
    scan = recipe.scan()
    thesis = replace(parameters, velocity_aware_emergency=False)
    for algorithm in (Improved, Original):
        plain = CepaParameters(r_lb=parameters.r_lb)
        same(algorithm(thesis).steer(scan, v_ref, v_uav), algorithm(plain).steer(scan, v_ref, v_uav))
        same(
            algorithm(parameters).steer(scan, v_ref, (0.0, 0.0)),
            algorithm(plain).steer(scan, v_ref, (0.0, 0.0)),
        )


def same(one, other):
    assert (one.velocity_xy, one.reason, one.emergency) == (other.velocity_xy, other.reason, other.emergency)


def test_the_greatest_speed_makes_no_emergency_of_the_open():
    open_field = LaserScan2D(np.full(1440, math.inf), -math.pi, TURN / 1440, 0.05, 12.0)
    v_uav = (GREATEST_SPEED_M_S, 0.0)
    assert Improved(P).steer(open_field, (1.0, 0.0), v_uav).reason is Reason.CUSHION_CLEAR
    assert Improved(P).steer(post(3.0, 0.0), (1.0, 0.0), v_uav).emergency


def test_what_is_drawn_is_what_is_judged():
    outline = view.emergency_outline(P, (0.0, 2.0))
    assert outline[:, 1].max() == pytest.approx(1.5, abs=1e-3)
    assert outline[:, 1].min() == pytest.approx(-0.5, abs=1e-3)
    beams = normal_form(post(0.0, 1.2), P)
    (edge, end), *_ = view.intrusions(beams, P, (0.0, 2.0))
    assert np.hypot(*edge) > np.hypot(*end)
    assert view.intrusions(beams, CepaParameters(), (0.0, 2.0)).size == 0


def test_the_edge_is_r_lb_behind_and_beside_at_every_speed():
    psi = np.array([math.pi / 2, -math.pi / 2, math.pi, 2.5])
    assert emergency_edge(psi, 3.0, 0.5, 0.35) == pytest.approx(0.5)
    assert emergency_edge(0.0, 3.0, 0.5, 0.35) == pytest.approx(3.5)
    assert emergency_edge(math.asin(0.35 / 2.0), 3.0, 0.5, 0.35) == pytest.approx(2.0)
