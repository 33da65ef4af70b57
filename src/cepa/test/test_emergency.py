"""The emergency avoidance: the K filter, the sum of intrusions, the sanity check and the open sections."""

import math

import numpy as np
import plain_cepa as reference
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planar_flight import Scene
from random_scans import recipes, velocities

from cepa import CepaParameters, Improved, LaserScan2D, Original, Reason
from cepa.scan import Grid
from cepa.thesis.emergency import Section, open_sections
from cepa.thesis.kernels.emergency import direction_is_safe, k_filter, safe_directions

EXAMPLES = settings(max_examples=60, deadline=None)
TURN = 2.0 * math.pi
P = CepaParameters()
close_recipes = recipes(0.1, 0.5)


def look(scene: Scene, beams=1440, noise=0.0, seed=0) -> LaserScan2D:
    angles = -math.pi + np.arange(beams) * TURN / beams
    ranges = scene.ranges(np.zeros(2), np.stack([np.cos(angles), np.sin(angles)], axis=1))
    ranges = ranges + noise * np.random.default_rng(seed).normal(size=beams)
    return LaserScan2D(ranges, -math.pi, TURN / beams, 0.05, 12.0)


def column(bearing_degrees, gap, radius=0.1):
    bearing = math.radians(bearing_degrees)
    return (gap + radius) * math.cos(bearing), (gap + radius) * math.sin(bearing), radius


def wall(y):
    return -8.0, y, 8.0, y


def scene(columns=(), walls=()):
    return Scene(np.array(columns).reshape(-1, 3), np.array(walls).reshape(-1, 4))


def bearing(velocity):
    return math.degrees(math.atan2(velocity[1], velocity[0]))


class TestKFilter:
    @EXAMPLES
    @given(close_recipes, st.sampled_from([0.1, 0.5, 2.0, 10.0, 50.0, 1e6]))
    def test_two_passes_equal_all_pairs(self, recipe, slope):
        beams = recipe.scan().full_turn(4)
        filtered = k_filter(beams.ranges, slope, beams.increment)
        assert filtered == pytest.approx(reference.k_filter(beams, slope), rel=1e-12, abs=1e-12)

    @pytest.mark.table("nearest", range(6))
    def test_an_increment_that_does_not_divide_the_turn(self, nearest):
        ranges = np.roll([1.0, 9.0, 9.0, 9.0, 9.0, 9.0], nearest)
        beams = LaserScan2D(ranges, 0.3, 1.0, 0.05, 12.0).full_turn(4)
        assert k_filter(beams.ranges, 1.0, 1.0) == pytest.approx(reference.k_filter(beams, 1.0))


class TestOriginal:
    def test_flees_straight_from_a_wall_at_the_speed_of_the_closed_form(self):
        # a wall at h, seen from the middle of r: the integral of (r - h / cos t) cos t over |t| < acos(h / r)
        h, r = 0.45, 0.5
        limit = math.acos(h / r)
        push = 2.0 * (r * math.sin(limit) - h * limit)
        parameters = CepaParameters(emergency_gain=10.0, v_min=0.01, v_max=5.0, k_filter=1e6)
        decision = Original(parameters).steer(look(scene(walls=[wall(h)])), (1.0, 0.0))
        assert decision.velocity_xy == pytest.approx((0.0, -10.0 * push), abs=1e-3)
        assert decision.reason is Reason.EMERGENCY_SUM

    @pytest.mark.table(("gap", "speed"), [(0.499, 0.3), (0.06, 1.0)])
    def test_its_speed_is_limited(self, gap, speed):
        parameters = CepaParameters(v_min=0.3, v_max=1.0)
        decision = Original(parameters).steer(look(scene([column(0.0, gap, 1.0)])), (1.0, 0.0))
        assert math.hypot(*decision.velocity_xy) == pytest.approx(speed)

    def test_a_symmetric_trap_leaves_it_without_an_answer(self):
        decision = Original().steer(look(scene([column(a, 0.4) for a in (45, 135, 225, 315)])), (1.0, 0.0))
        assert math.hypot(*decision.velocity_xy) <= P.v_min + 1e-12

    def test_a_lower_k_lets_the_nearer_obstacle_count_more(self):
        # a thin near post on the left, a long wall a little farther on the right (figure 6.3)
        trap = look(scene([column(90.0, 0.2, 0.02)], [wall(-0.42)]))
        for slope, expected in ((1e4, 90.0), (0.3, -90.0)):
            decision = Original(CepaParameters(k_filter=slope)).steer(trap, (1.0, 0.0))
            assert bearing(decision.velocity_xy) == pytest.approx(expected, abs=2.0)


class TestImproved:
    @EXAMPLES
    @given(
        close_recipes,
        velocities,
        velocities,
        st.sampled_from([0.3, 1.2, 3.0]),
        st.booleans(),
        st.sampled_from([0.0, 0.8]),
    )
    def test_the_answer_is_safe_whenever_a_safe_direction_exists(
        self, recipe, v_ref, v_uav, lookahead, free, v_min
    ):
        p = CepaParameters(emergency_lookahead=lookahead, unseen_is_free=free, v_min=v_min)
        scan = recipe.scan()
        decision = Improved(p).steer(scan, v_ref, v_uav)
        beams = scan.full_turn(p.dropout_beams)
        assert decision.emergency == bool(beams.ranges.min() <= p.r_lb)
        if not decision.emergency:
            return
        eligible = beams.angles[beams.seen | free]
        if not any(reference.is_safe(p, beams, angle) for angle in eligible):
            assert decision.velocity_xy == (0.0, 0.0)
            assert decision.reason is Reason.BLOCKED
            return
        assert p.v_min - 1e-12 <= math.hypot(*decision.velocity_xy) <= p.v_max + 1e-12
        assert decision.velocity_xy != (0.0, 0.0)
        angle = math.atan2(*decision.velocity_xy[::-1])
        assert reference.is_safe(p, beams, angle)
        assert free or beams.seen[nearest_beam(beams, angle)]

    @settings(max_examples=150, deadline=None)
    @given(
        st.integers(0, 2**32 - 1),
        st.floats(8.0, 60.0),
        st.sampled_from([0.36, 0.45, 0.7, 1.3]),
        st.sampled_from([0.2, 0.5, 1.2]),
        velocities,
    )
    def test_it_is_safe_between_beams_and_across_a_seam_too(self, seed, turn_in_beams, near, ahead, v_uav):
        # few beams, so that a section's middle between two of them is far from both; an increment that does
        # not divide the turn makes the first and the last beam nearer or farther apart than the others
        rng = np.random.default_rng(seed)
        p = CepaParameters(emergency_lookahead=ahead, dropout_beams=0)
        count = round(turn_in_beams)
        ranges = np.where(rng.random(count) < 0.5, near + rng.gamma(1.0, 0.5, count), math.inf)
        ranges[rng.integers(count)] = rng.uniform(0.1, p.r_lb)
        scan = LaserScan2D(ranges, rng.uniform(-math.pi, math.pi), TURN / turn_in_beams, 0.05, 12.0)
        decision = Improved(p).steer(scan, (1.0, 0.0), v_uav)
        assert decision.emergency
        beams = scan.full_turn(0)
        if decision.reason is Reason.BLOCKED:
            assert not any(reference.is_safe(p, beams, angle) for angle in beams.angles)
        else:
            assert reference.is_safe(p, beams, math.atan2(*decision.velocity_xy[::-1]))

    @EXAMPLES
    @given(close_recipes, st.sampled_from([0.3, 1.2, 3.0]))
    def test_every_direction_is_judged_as_the_definition_does(self, recipe, lookahead):
        p = CepaParameters(emergency_lookahead=lookahead)
        beams = recipe.scan().full_turn(4)
        grid = Grid(beams.ranges.size, beams.increment)
        safe = safe_directions(beams.ranges, beams.seen, grid.cos, grid.sin, p.body_radius, lookahead)
        expected = [reference.is_safe(p, beams, angle) for angle in beams.angles]
        assert (safe == (np.array(expected) & beams.seen)).all()

    def test_what_touches_the_body_forbids_all_that_leads_towards_it(self):
        # at 4e-9 rad less than 90 degrees aside, rounding may put it farther aside than it is away
        beside = np.linspace(-math.pi, math.pi, 1000)
        for bearing_rad, angle in zip(beside, beside + math.pi / 2 - 4e-9):
            beam = np.array([P.body_radius]), np.cos([bearing_rad]), np.sin([bearing_rad])
            assert not direction_is_safe(*beam, math.cos(angle), math.sin(angle), P.body_radius, 1.2)

    def test_where_the_sum_is_safe_it_answers_as_the_original(self):
        # figure 8.6: a wall on the left and one column ahead to the right
        scan = look(scene([column(-30.0, 0.45)], [wall(0.42)]))
        improved, original = Improved().steer(scan, (1.0, 0.0)), Original().steer(scan, (1.0, 0.0))
        assert improved.reason is Reason.EMERGENCY_SUM
        assert improved.velocity_xy == original.velocity_xy
        assert improved.emergency_original_xy == original.velocity_xy

    def test_three_columns_opposite_a_wall(self):
        # figure 8.7: the sum drives into the columns; the improved leaves along the wall
        scan = look(scene([column(a, 0.55) for a in (-125.0, -90.0, -55.0)], [wall(0.4)]))
        decision = Improved().steer(scan, (1.0, 0.0))
        assert decision.reason is Reason.EMERGENCY_OPEN_SECTION
        assert bearing(decision.emergency_original_xy) == pytest.approx(-90.0, abs=5.0)
        beams = scan.full_turn(4)
        assert not reference.is_safe(P, beams, math.radians(bearing(decision.emergency_original_xy)))
        assert reference.is_safe(P, beams, math.radians(bearing(decision.velocity_xy)))
        assert min(abs(bearing(decision.velocity_xy)), abs(180 - abs(bearing(decision.velocity_xy)))) < 25.0

    def test_four_columns_around(self):
        # figure 8.3: the sum cancels out; any of the four gaps will do
        scan = look(scene([column(a, 0.65) for a in (45, 135, 225, 315)]))
        decision = Improved(CepaParameters(r_lb=0.7)).steer(scan, (1.0, 0.0), (0.0, 0.2))
        assert decision.reason is Reason.EMERGENCY_OPEN_SECTION
        assert bearing(decision.velocity_xy) == pytest.approx(90.0, abs=0.3)  # ties: along the own velocity

    @pytest.mark.table(("v_min", "speed"), [(0.0, 1.0), (0.3, 0.3)])
    def test_a_sum_that_cancels_out_is_no_reason_to_stand_still(self, v_min, speed):
        scan = look(scene([column(a, 0.65) for a in (45, 135, 225, 315)]))
        decision = Improved(CepaParameters(r_lb=0.7, v_min=v_min, v_max=1.0)).steer(scan, (1.0, 0.0))
        assert decision.reason is Reason.EMERGENCY_OPEN_SECTION
        assert math.hypot(*decision.velocity_xy) == pytest.approx(speed)

    @pytest.mark.table("v_uav", [(0.3, 0.0), (-0.3, 0.0)])
    def test_it_does_not_dither_between_equal_ways_out(self, v_uav):
        answers = [
            Improved().steer(
                look(scene(walls=[wall(0.45), wall(-0.45)]), noise=0.013, seed=seed), (0, 0), v_uav
            )
            for seed in range(50)
        ]
        assert all(answer.velocity_xy[0] * v_uav[0] > 0.0 for answer in answers)

    def test_it_flees_even_without_a_reference(self):
        decision = Improved().steer(look(scene([column(0.0, 0.4)])), (0.0, 0.0))
        assert decision.emergency
        assert abs(bearing(decision.velocity_xy)) == pytest.approx(180.0, abs=1.0)

    def test_what_already_touches_does_not_forbid_to_leave(self):
        decision = Improved().steer(look(scene([column(0.0, 0.2)])), (1.0, 0.0))
        assert decision.reason is Reason.EMERGENCY_SUM
        assert decision.velocity_xy[0] < 0.0

    @pytest.mark.table("near", [-math.inf, 0.2, 0.49])
    @pytest.mark.table("r_lb", [0.45, 0.5, 0.6])
    @pytest.mark.table("algorithm", [Improved, Original])
    def test_it_flees_from_what_is_too_close_for_the_lidar(self, near, r_lb, algorithm):
        # a Puck sees from 0.5 m on: something nearer may be anywhere up to the body
        ranges = np.full(1440, math.inf)
        ranges[700:740] = near  # ahead
        scan = LaserScan2D(ranges, -math.pi, TURN / 1440, 0.5, 100.0)
        decision = algorithm(CepaParameters(r_lb=r_lb)).steer(scan, (1.0, 0.0))
        assert decision.emergency
        assert decision.reason is Reason.EMERGENCY_SUM
        assert abs(bearing(decision.velocity_xy)) == pytest.approx(180.0, abs=1.0)
        assert math.hypot(*decision.velocity_xy) >= P.v_min - 1e-12

    @pytest.mark.table("gap", [0.2, 0.4])
    def test_closed_in_on_all_sides_it_stands_still(self, gap):
        scan = LaserScan2D(np.full(1440, gap), -math.pi, TURN / 1440, 0.05, 12.0)
        decision = Improved().steer(scan, (1.0, 0.0))
        assert decision.emergency
        assert (decision.velocity_xy, decision.reason) == ((0.0, 0.0), Reason.BLOCKED)

    def test_it_does_not_flee_into_the_unseen(self):
        full = look(scene([column(0.0, 0.4)]))
        seen = np.abs(np.arange(1440) - 720) <= 540  # 135 degrees to either side
        half = LaserScan2D(full.ranges, full.angle_min, full.angle_increment, 0.05, 12.0, seen)
        decision = Improved().steer(half, (1.0, 0.0), (0.5, 0.1))
        assert decision.reason is Reason.EMERGENCY_OPEN_SECTION
        assert abs(bearing(decision.velocity_xy)) <= 135.0
        free = Improved(CepaParameters(unseen_is_free=True)).steer(half, (1.0, 0.0))
        assert abs(bearing(free.velocity_xy)) == pytest.approx(180.0, abs=1.0)


class TestSections:
    def test_runs_are_found_around_the_turn(self):
        safe = np.array([1, 1, 0, 0, 1, 0, 0, 1], bool)
        assert open_sections(safe) == [Section(4, 1), Section(7, 3)]
        assert open_sections(~np.zeros(8, bool)) == [Section(0, 8)]
        assert open_sections(np.zeros(8, bool)) == []

    def test_middle_and_edges(self):
        grid = Grid(8, TURN / 8)
        section = Section(7, 3)  # beams 7, 0, 1
        assert math.remainder(section.middle(grid), TURN) == pytest.approx(0.0)
        assert section.distance(math.pi / 2, grid) == pytest.approx(math.pi / 4)
        assert section.distance(-math.pi / 2, grid) == pytest.approx(math.pi / 4)


def nearest_beam(beams, angle):
    return int(np.argmin(np.abs(reference.wrap(beams.angles - angle))))
