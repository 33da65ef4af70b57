"""What comes down on the UAV, or up to it, is found by range finders and left to the side."""

import math

import numpy as np
import pytest
from flight_beside import BEAMS, DOWN, PERIOD_S, UP, fly_beside
from spatial_flight import LEVEL, Boxes

from cepa import Dynamic, LaserScan2D, Motion, Ranging
from cepa.dynamic.obstacle_tracks.sinking import Sinking
from cepa.dynamic.remembered.voxel_memory import VoxelMemory

HEIGHT_M, RANGE_MAX_M = 2.0, 40.0


def found_at(height_of, rng, way=UP, speed=0.0, until_s=30.0):
    """Return when a UAV that flies along x at 2 m/s or hovers finds that something comes, or None."""
    sinking = Sinking(0.3, 0.15)
    for number in range(round(until_s / PERIOD_S)):
        t = number * PERIOD_S
        x = speed * t
        range_m = way[2] * (height_of(t, x) - HEIGHT_M) + rng.normal(0.0, 0.01)
        motion = Motion(t, (x, 0.0, HEIGHT_M), LEVEL, (speed, 0.0, 0.0))
        if len(sinking.take_in([Ranging((0.0, 0.0, 0.0), way, range_m, 0.05, RANGE_MAX_M)], motion)):
            return t
    return None


@pytest.mark.table("speed", [0.2, 0.5, 1.0, 2.0])
@pytest.mark.table(("way", "start_m"), [(UP, 8.0), (DOWN, -4.0)])
def test_what_comes_is_found_in_time_to_leave_and_not_long_before(speed, way, start_m):
    end_m = 0.15 if way is UP else 0.3  # of the body
    arrives_s = (abs(start_m - HEIGHT_M) - end_m) / speed
    found_s = found_at(lambda t, x: start_m - way[2] * speed * t, np.random.default_rng(1), way)
    # A UAV leaves the middle of a load of 2 m within 2.5 s
    assert 2.5 < arrives_s - found_s < 7.0 or (arrives_s < 3.5 and found_s < 0.6)


@pytest.mark.table(
    ("height_of", "speed"),
    [
        (lambda t, x: 5.0, 0.0),  # a ceiling
        (lambda t, x: 8.0 - 0.3 * x, 2.0),  # one that slopes
        (lambda t, x: 5.0 if x < 3.0 else 3.5, 2.0),  # a beam under it
        (lambda t, x: 5.0 - 0.15 * (0.4 < x < 0.43), 0.1),  # a stiffener on it, which the UAV slowly passes
        (lambda t, x: 5.0 - 0.15 * (x > 0.4), 0.2),  # a step in it
        (lambda t, x: 5.0 - 0.35 * (t > 4.0), 0.0),  # a beam above a UAV that turns on the spot
        (lambda t, x: 4.0 + 0.5 * t, 0.0),  # a load that is lifted
        (lambda t, x: 30.0 - 0.5 * t, 0.0),  # one that is far up
    ],
)
def test_what_stands_or_is_lifted_or_far_up_closes_nothing(height_of, speed):
    assert found_at(height_of, np.random.default_rng(2), UP, speed, until_s=8.0) is None


def test_the_disc_ends_where_the_beam_passed_just_before():
    # Given a load whose edge the UAV flies under at 0.5 m/s
    sinking, found = Sinking(0.3, 0.15), np.empty((0, 6))
    for number in range(30):
        t = number * PERIOD_S
        x = 0.5 * t - 1.0
        range_m = 4.0 - 0.8 * t if x > 0.0 else 20.0
        motion = Motion(t, (x, 0.0, HEIGHT_M), LEVEL, (0.5, 0.0, 0.0))
        found = sinking.take_in([Ranging((0.0, 0.0, 0.0), UP, range_m + 1e-3 * number, 0.05, 40.0)], motion)
        if len(found):
            break
    # Then the way back is open, and the way ahead is not
    ((ahead, aside, _, _, radius, *_),) = found
    assert aside == pytest.approx(0.0, abs=1e-9)
    assert x + ahead - radius == pytest.approx(0.0, abs=0.1)


@pytest.mark.table("lean_rad", [-0.05, 0.05])
def test_a_beam_that_leans_passed_the_edge_at_the_height_of_the_load_and_not_at_its_own_end(lean_rad):
    # Given a load whose edge is at x = 0, and a UAV that leans while it flies under it at 0.5 m/s
    sinking, found = Sinking(0.3, 0.15), np.empty((0, 6))
    orientation = (0.0, math.sin(0.5 * lean_rad), 0.0, math.cos(0.5 * lean_rad))
    for number in range(40):
        t = number * PERIOD_S
        x, above_m = 0.5 * t - 1.0, 4.0 - 0.8 * t
        is_met = x + above_m * math.tan(lean_rad) > 0.0
        range_m = above_m / math.cos(lean_rad) + 1e-3 * (number % 2) if is_met else 50.0
        motion = Motion(t, (x, 0.0, HEIGHT_M), orientation, (0.5, 0.0, 0.0))
        found = sinking.take_in([Ranging((0.0, 0.0, 0.0), UP, range_m, 0.05, RANGE_MAX_M)], motion)
        if len(found):
            break
    # Then the disc begins at the edge
    ((ahead, _, _, _, radius, *_),) = found
    assert x + ahead - radius == pytest.approx(0.0, abs=0.15)


def test_the_plates_of_a_tank_over_a_beam_that_leans_do_not_come_down():
    """Times, places and heights of one flight into a manhole: deck, stiffener, then the plate beside it."""
    ends = (
        (-1.1, -1.661, 4.993), (-1.0, -1.663, 4.991), (-0.9, -1.67, 4.988), (-0.8, -1.681, 5.006),
        (-0.7, -1.707, 4.988), (-0.6, -1.755, 4.846), (-0.2, -1.893, 4.765), (-0.1, -1.9, 4.629),
        (0.0, -1.9, 4.621), (0.1, -1.9, 4.99),
    )  # fmt: skip
    sinking = Sinking(0.17, 0.05)
    for t, x, z in ends:
        motion = Motion(t + 10.0, (x, 0.0, 1.26), LEVEL, (-0.1, 0.0, 0.0))
        sinking.take_in([Ranging((0.0, 0.0, 0.0), UP, z - 1.26, 0.05, RANGE_MAX_M)], motion)
    for t in np.arange(10.2, 20.0, 0.2).tolist():
        motion = Motion(t, (-1.9, 0.0, 1.26), LEVEL, (0.0, 0.0, 0.0))
        assert not len(sinking.take_in([], motion))


def test_a_web_of_a_tank_down_which_a_beam_runs_does_not_come_down():
    """Heights of one flight along a frame: the UAV turns on the spot, and leans ever more to one side."""
    sinking = Sinking(0.17, 0.05)
    for number, z in enumerate((5.02, 4.88, 4.87, 4.70, 4.62, 4.46, 4.32, 4.05, 5.04, 5.10)):
        motion = Motion(0.1 * number, (-0.02 * number, 0.0, 1.26), LEVEL, (-0.2, 0.0, 0.0))
        ranging = Ranging((0.0, 0.0, 0.0), UP, z - 1.26, 0.05, RANGE_MAX_M)
        assert not len(sinking.take_in([ranging], motion, clouds_show=True))


@pytest.mark.table(("way", "near_m"), [(UP, 0.9), (DOWN, 0.9), (DOWN, 0.8)])
@pytest.mark.table("is_load", [False, True])
def test_what_stands_after_all_is_given_up_and_what_comes_is_not(way, near_m, is_load):
    """It comes by 0.15 m/s, as the floor does if the UAV's own height drifts for 1.5 s, or as a load does."""
    sinking, rng, is_closed = Sinking(0.3, 0.15), np.random.default_rng(5), {}
    for number in range(45):
        t = PERIOD_S * number
        range_m = near_m - 0.15 * (t if is_load else min(t, 1.5)) + rng.normal(0.0, 0.01)
        motion = Motion(t, (0.0, 0.0, HEIGHT_M), LEVEL, (0.0, 0.0, 0.0))
        ranging = Ranging((0.0, 0.0, 0.0), way, range_m, 0.05, RANGE_MAX_M)
        is_closed[number] = bool(len(sinking.take_in([ranging], motion)))
    assert is_closed[15]
    assert all(is_closed[number] == is_load for number in range(30, 45))


def test_the_disc_stays_where_it_was_found_while_the_uav_flies_on_under_the_load():
    sinking, middles = Sinking(0.3, 0.15), []
    for number in range(30):
        t = number * PERIOD_S
        motion = Motion(t, (0.5 * t, 0.0, HEIGHT_M), LEVEL, (0.5, 0.0, 0.0))
        range_m = 4.0 - 0.8 * t + 1e-3 * (number % 2)
        found = sinking.take_in([Ranging((0.0, 0.0, 0.0), UP, range_m, 0.05, RANGE_MAX_M)], motion)
        middles += [0.5 * t + disc[0] for disc in found]
    assert len(middles) > 20
    assert np.ptp(middles) == pytest.approx(0.0, abs=1e-6)


def test_a_fast_load_is_found_by_three_heights_of_twentieths_of_a_second():
    sinking = Sinking(0.3, 0.15)
    for number in range(4):
        t = 0.05 * number
        motion = Motion(t, (t, 0.0, HEIGHT_M), LEVEL, (1.0, 0.0, 0.0))
        range_m = 7.0 if number == 0 else 2.0 - 1.7 * t  # a ceiling, so it is not in the open
        found = sinking.take_in([Ranging((0.0, 0.0, 0.0), UP, range_m, 0.05, RANGE_MAX_M)], motion)
        assert len(found) == (number == 3)


def test_with_clouds_three_heights_are_not_enough():
    sinking = Sinking(0.3, 0.15)
    for number in range(4):
        t = 0.05 * number
        motion = Motion(t, (t, 0.0, HEIGHT_M), LEVEL, (1.0, 0.0, 0.0))
        ranging = Ranging((0.0, 0.0, 0.0), UP, 2.0 - 1.7 * t, 0.05, RANGE_MAX_M)
        assert not len(sinking.take_in([ranging], motion, clouds_show=True))


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.long) for seed in (2, 3, 4))])
@pytest.mark.table(
    "height_of",
    [
        lambda x, rough_m: 9.0 - x % 5.0,  # hopper plates of 45 degrees, one after the other
        lambda x, rough_m: 4.0 - np.interp(x / 0.6, np.arange(rough_m.size), rough_m),  # the roof of a mine
    ],
)
def test_hopper_plates_and_rough_roofs_do_not_come_down_under_a_roof_while_clouds_come(height_of, seed):
    rng, sinking = np.random.default_rng(seed), Sinking(0.3, 0.15)
    rough_m, speed = rng.uniform(0.0, 0.5, 100), 1.2
    for t in np.arange(0.0, 30.0, 0.05).tolist():
        motion = Motion(t, (speed * t, 0.0, HEIGHT_M), LEVEL, (speed, 0.0, 0.0))
        range_m = height_of(speed * t, rough_m) - HEIGHT_M + rng.normal(0.0, 0.01)
        ranging = Ranging((0.0, 0.0, 0.0), UP, float(range_m), 0.05, RANGE_MAX_M)
        assert not len(sinking.take_in([ranging], motion, clouds_show=True))


@pytest.mark.table(("ceiling_m", "is_open"), [(math.inf, True), (12.0, True), (5.0, False)])
def test_it_is_in_the_open_for_six_seconds_after_the_beam_has_met_no_ceiling_within_8_m(ceiling_m, is_open):
    sinking = Sinking(0.3, 0.15)
    for t, up_m in ((0.0, ceiling_m - HEIGHT_M), (0.1, 2.0)):
        ranging = Ranging((0.0, 0.0, 0.0), UP, up_m, 0.05, RANGE_MAX_M)
        sinking.take_in([ranging], Motion(t, (0.0, 0.0, HEIGHT_M), LEVEL, (0.0, 0.0, 0.0)))
    assert sinking.is_in_the_open(5.9) == is_open
    assert not sinking.is_in_the_open(6.1)


def test_what_is_slower_than_a_slope_under_which_the_uav_flies_counts_when_it_is_about_to_touch_the_uav():
    # Given a load that sinks at 0.3 m/s onto a UAV that flies at 1 m/s
    for above_m, is_found in ((0.6, True), (3.0, False)):
        found_s = found_at(
            lambda t, x, above=above_m: HEIGHT_M + above - 0.3 * t,
            np.random.default_rng(3),
            speed=1.0,
            until_s=1.4,
        )
        assert (found_s is not None) == is_found


@pytest.mark.table(("before_m", "near_m"), [(30.0, 1.2), (math.inf, 0.4), (30.0, 2.5), (7.0, 1.2)])
def test_in_the_open_the_uav_goes_back_from_what_appears_over_it_until_it_knows_whether_it_comes(
    before_m, near_m
):
    # Given a beam that meets something that stands, 1 s after it began, and once more
    sinking, found = Sinking(0.3, 0.15), {}
    rng = np.random.default_rng(4)
    for number in range(60):
        t = 0.05 * number
        is_met = 20 <= number < 30 or 40 <= number < 50
        range_m = (near_m if is_met else before_m) + rng.normal(0.0, 0.005)
        motion = Motion(t, (0.5 * t, 0.0, HEIGHT_M), LEVEL, (0.5, 0.0, 0.0))
        found[number] = sinking.take_in([Ranging((0.0, 0.0, 0.0), UP, range_m, 0.05, 40.0)], motion)
    # Then its column is closed for five heights, if it may be a load; and not again so soon
    is_sign = before_m > 8.0 and near_m < 2.0
    assert [n for n, discs in found.items() if len(discs)] == (list(range(20, 25)) if is_sign else [])
    if is_sign:
        ((ahead, _, _, _, radius, _, arrives_s, way),) = found[20]
        assert math.hypot(ahead, 0.0) <= radius
        assert arrives_s == pytest.approx((near_m - 0.15) / 2.0, abs=0.02)  # by the fastest load
        assert way == 1.0


def test_what_appeared_over_the_uav_in_the_open_counts_while_the_beam_misses_it():
    """The UAV leans back to brake, so its beam is no longer under the load."""
    sinking = Sinking(0.3, 0.15)
    for number in range(40):
        t = 0.05 * number
        range_m = 1.0 if number in (2, 3) else math.inf
        motion = Motion(t, (0.0, 0.0, HEIGHT_M), LEVEL, (0.0, 0.0, 0.0))
        found = sinking.take_in([Ranging((0.0, 0.0, 0.0), UP, range_m, 0.05, 40.0)], motion)
        assert len(found) == (number >= 2)  # for 2 s after its arrival


def fly_near_a_load(
    edge_m, bottom_of, reference_of, until_s, place_m=(0.0, 0.0, HEIGHT_M), speed=0.0, has_puck=False
):
    """Return how near the UAV came to a cube whose bottom is at a height at a time, and its least height."""
    half = 0.5 * edge_m

    def load_at(t):
        bottom_m = bottom_of(t)
        return (-half, -half, bottom_m), (half, half, bottom_m + edge_m)

    nearest = fly_beside(load_at, reference_of, until_s, place_m, speed, has_puck)
    return nearest.box_m, nearest.lowest_m


def test_spots_of_what_comes_are_forgotten_and_nothing_beside_or_under_the_uav():
    memory, here = VoxelMemory(), np.array([20.0, 0.0, 2.0])
    over, beside, under = (0.1, 0.0, 0.4), (0.8, 0.0, 0.4), (0.1, 0.0, -0.4)
    nothing_seen = np.full((40, 24), math.inf, np.float32), 0.05, 0.3, 1.5, 3
    memory.update(np.array([over, beside, under]), here, 1.0, 0.0, nothing_seen)
    memory.forget_over(here, 0.5, 1.0)
    points, _ = memory.update(np.empty((0, 3)), here, 1.1, 0.0, nothing_seen)
    assert sorted(map(tuple, points.round(6).tolist())) == sorted((beside, under))


@pytest.mark.parametrize("is_led", [False, pytest.param(True, marks=pytest.mark.long)])
@pytest.mark.parametrize(
    ("edge_m", "speed"),
    [
        (0.3, 2.0),
        (1.0, 0.5),
        (2.0, 1.0),
        pytest.param(0.3, 0.2, marks=pytest.mark.long),
        pytest.param(2.0, 0.2, marks=pytest.mark.long),
    ],
)
def test_a_load_comes_down_beside_the_uav_and_never_onto_it(edge_m, speed, is_led):
    """The UAV hovers, or is led on and on; it has a planar lidar and range finders."""
    clearance_m, lowest_m = fly_near_a_load(
        edge_m,
        lambda t: max(5.0 - speed * t, 0.01),
        lambda place: (0.3, 0.0) if is_led and place[0] < 0.1 else (0.0, 0.0),
        4.0 / speed,
    )
    assert clearance_m > 0.0
    assert lowest_m > HEIGHT_M - 0.3


@pytest.mark.table(("edge_m", "speed", "lead_s"), [(2.0, 1.7, 1.6), (1.2, 1.0, 1.4), (1.8, 0.7, 1.3)])
def test_a_uav_that_flies_under_a_load_is_out_again_before_it_arrives(edge_m, speed, lead_s):
    """It flies at 1 m/s; the load is at its height so long after the beam has met it."""
    start_m, lead_m = -1.0 - 0.5 * edge_m, speed * (1.0 + lead_s)
    clearance_m, lowest_m = fly_near_a_load(
        edge_m,
        lambda t: max(HEIGHT_M + 0.15 + lead_m - speed * t, 0.01),
        lambda _: (1.0, 0.0),
        1.5 + lead_s + HEIGHT_M / speed,
        (start_m, 0.05, HEIGHT_M),
        speed=1.0,
    )
    assert clearance_m > 0.0
    assert lowest_m > HEIGHT_M - 0.9  # it is nowhere near the floor


@pytest.mark.table(("edge_m", "speed", "lead_s"), [(2.0, 1.7, 1.3), (1.2, 1.0, 1.0)])
def test_under_a_load_that_a_puck_does_not_see_the_uav_hurries_as_without_clouds(edge_m, speed, lead_s):
    """It flies at 1 m/s; the load is at its height so long after the beam has met it."""
    clearance_m, _ = fly_near_a_load(
        edge_m,
        lambda t: max(HEIGHT_M + 0.15 + speed * (1.0 + lead_s) - speed * t, 0.01),
        lambda _: (1.0, 0.0),
        2.0 + lead_s,
        (-1.0 - 0.5 * edge_m, 0.05, HEIGHT_M),
        speed=1.0,
        has_puck=True,
    )
    assert clearance_m > 0.0


def test_a_uav_that_sinks_out_of_the_way_of_a_load_stops_in_time_over_the_floor():
    """It sinks at 0.8 m/s, 0.4 m over its least height; a UAV that leans stops 0.5 m lower."""
    steering, sinks, period_s, end_m = Dynamic(), 0.8, 0.05, Dynamic().parameters.height_min + 0.4
    for number in range(20, -1, -1):
        position = np.array([0.0, 0.0, end_m + sinks * period_s * number])
        bottom_m = end_m + 0.3 + 1.4 * period_s * number  # it comes nearer at 0.6 m/s
        load = Boxes(np.array([[(-0.5, -0.5, bottom_m), (0.5, 0.5, bottom_m + 1.0)]]))
        ranges = np.full(BEAMS, math.inf)
        scan = LaserScan2D(ranges, -math.pi, 2 * math.pi / BEAMS, 0.06, 10.0)
        up, down = (float(load.ranges(position, np.array([way]) + 1e-9)[0]) for way in (UP, DOWN))
        steering.take_ranges(
            [Ranging((0.0, 0.0, 0.0), w, r, 0.05, 40.0) for w, r in ((UP, up), (DOWN, down))]
        )
        motion = Motion(1.0 - number * period_s, tuple(position), LEVEL, (0.0, 0.0, -sinks))
        decision = steering.steer(scan, (0.0, 0.0), (0.0, 0.0), motion)
    assert math.hypot(*decision.velocity_xy) > 1.0  # it leaves the load's way
    assert decision.climb_m_s == 0.0


@pytest.mark.table(("arrives_s", "sinks"), [(0.3, True), (-0.3, True), (-0.6, False), (-5.0, False)])
def test_the_uav_does_not_sink_for_what_should_have_come_and_has_not(monkeypatch, arrives_s, sinks):
    """A disc of 2 m over the UAV; it is told when something arrives in it, which is not seen any more."""
    disc = np.array([[-0.5, 0.0, 0.0, 0.0, 2.0, 0.0, arrives_s, 1.0]])
    monkeypatch.setattr(Sinking, "take_in", lambda *_: disc)
    steering = Dynamic()
    scan = LaserScan2D(np.full(BEAMS, math.inf), -math.pi, 2 * math.pi / BEAMS, 0.06, 10.0)
    steering.take_ranges([Ranging((0.0, 0.0, 0.0), DOWN, HEIGHT_M, 0.05, RANGE_MAX_M)])
    motion = Motion(0.0, (0.0, 0.0, HEIGHT_M), LEVEL, (0.0, 0.0, 0.0))
    decision = steering.steer(scan, (0.0, 0.0), (0.0, 0.0), motion)
    assert math.hypot(*decision.velocity_xy) > 0.5  # it leaves the disc
    assert (decision.climb_m_s < 0.0) == sinks


@pytest.mark.table(("below_m", "sinks"), [(HEIGHT_M, True), (0.25, False), (-math.inf, False)])
def test_the_uav_does_not_sink_onto_what_its_range_finder_sees_below(monkeypatch, below_m, sinks):
    """The floor of its start is 2 m below; a box may be nearer."""
    disc = np.array([[-0.5, 0.0, 0.0, 0.0, 2.0, 0.0, 0.3, 1.0]])
    monkeypatch.setattr(Sinking, "take_in", lambda *_: disc)
    steering = Dynamic()
    scan = LaserScan2D(np.full(BEAMS, math.inf), -math.pi, 2 * math.pi / BEAMS, 0.06, 10.0)
    steering.take_ranges([Ranging((0.0, 0.0, 0.0), DOWN, below_m, 0.05, RANGE_MAX_M)])
    decision = steering.steer(
        scan, (0.0, 0.0), (0.0, 0.0), Motion(0.0, (0.0, 0.0, HEIGHT_M), LEVEL, (0.0, 0.0, 0.0))
    )
    assert (decision.climb_m_s < 0.0) == sinks


def test_a_fast_uav_at_the_rim_of_a_column_goes_back_and_does_not_only_stand(monkeypatch):
    """It flies at 1 m/s, 0.15 m before the disc of a load that arrives soon: it cannot stop there."""
    disc = np.array([[1.65, 0.0, 0.0, 0.0, 1.5, 0.0, 0.9, 1.0]])
    monkeypatch.setattr(Sinking, "take_in", lambda *_: disc)
    steering = Dynamic()
    scan = LaserScan2D(np.full(BEAMS, math.inf), -math.pi, 2 * math.pi / BEAMS, 0.06, 10.0)
    steering.take_ranges([Ranging((0.0, 0.0, 0.0), DOWN, HEIGHT_M, 0.05, RANGE_MAX_M)])
    motion = Motion(0.0, (0.0, 0.0, HEIGHT_M), LEVEL, (1.0, 0.0, 0.0))
    decision = steering.steer(scan, (1.0, 0.0), (1.0, 0.0), motion)
    assert decision.velocity_xy[0] < -2.0


def test_what_a_planar_lidar_shows_near_the_uav_is_left_at_its_height_for_it_may_be_at_others_too():
    steering, angles_rad = Dynamic(), np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)
    for number in range(12):
        ahead = np.abs(angles_rad) < 0.6
        ranges = np.where(ahead, (0.38 if number > 3 else 3.0) / np.cos(angles_rad), math.inf)
        scan = LaserScan2D(ranges, -math.pi, 2 * math.pi / BEAMS, 0.06, 10.0)
        steering.take_ranges(
            [Ranging((0.0, 0.0, 0.0), w, r, 0.05, 40.0) for w, r in ((UP, 35.0), (DOWN, 2.0))]
        )
        motion = Motion(0.05 * number, (0.0, 0.0, HEIGHT_M), LEVEL, (0.0, 0.0, 0.0))
        decision = steering.steer(scan, (0.0, 0.0), (0.0, 0.0), motion)
    assert decision.velocity_xy[0] < -0.1
    assert decision.climb_m_s == 0.0
