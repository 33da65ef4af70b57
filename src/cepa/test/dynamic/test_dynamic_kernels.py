"""The kernels of dynamic against slow and obvious references."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cepa import CepaParameters
from cepa.dynamic.cost_to_go.course import NO_END
from cepa.dynamic.cost_to_go.kernels.slowness import fill_slowness
from cepa.dynamic.cost_to_go.kernels.sweeping import sweep
from cepa.dynamic.cost_to_go.kernels.ways import cross_section, shortest_way
from cepa.dynamic.free_space.kernels.beams import clear_of, directions_of, points_of
from cepa.dynamic.free_space.kernels.ranges import bins_of, fill_blind, reach_in_sight, was_seen_around
from cepa.dynamic.kernels.angles import ANGLE_ERROR_RAD
from cepa.dynamic.kernels.clear_path import _is_near, _is_wide_open
from cepa.dynamic.kernels.distance_field import fill_distances, widest
from cepa.dynamic.kernels.free_space import leaves_reach
from cepa.dynamic.kernels.response import roll
from cepa.dynamic.observer import Observer, response_of
from cepa.dynamic.remembered.kernels.cells import MOST_TRUST, TRUST, knows_near, recall, remember
from cepa.identification.response import ResponseModel

SEEDS = st.integers(0, 2**31)
LEVEL = np.eye(3)


@settings(max_examples=20)
@given(seed=SEEDS)
def test_a_field_holds_the_distance_to_the_nearest_point(seed):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-3.0, 3.0, (rng.integers(0, 20), 2))
    field = np.empty((41, 41))
    fill_distances(points, 0.2, -0.1, field, 0.1, 1.3)
    axis = 0.1 * (np.arange(41) - 20)
    nodes = np.stack(np.meshgrid(axis, axis), axis=-1)
    distances = np.linalg.norm(nodes[:, :, None] - points - (0.2, -0.1), axis=-1).min(axis=2, initial=1.3)
    np.testing.assert_allclose(field, distances, atol=1e-9)


def test_a_cell_is_as_wide_as_its_widest_quarter():
    finer, field = np.arange(16.0).reshape(4, 4), np.empty((2, 2))
    widest(finer, field)
    np.testing.assert_array_equal(field, [[5.0, 7.0], [13.0, 15.0]])


def test_without_obstacles_the_way_out_is_straight():
    slowness, way = np.ones((41, 41)), np.empty((41, 41))
    sweep(slowness, 0.25, np.array([1.0, 0.0]), NO_END, way, 8)
    np.testing.assert_allclose(way[20], 0.25 * np.arange(40, -1, -1), atol=1e-9)
    cells = np.empty((200, 2), np.int64)
    assert shortest_way(way, 100, 50, cells) == 21
    np.testing.assert_array_equal(cells[20], (120, 50))


def test_the_way_out_goes_round_a_wall():
    slowness, way = np.ones((41, 41)), np.empty((41, 41))
    slowness[:31, 25] = math.inf
    sweep(slowness, 0.25, np.array([1.0, 0.0]), NO_END, way, 8)
    corner = 0.25 * math.hypot(5, 11) + 0.25 * 15  # past the wall's end, then straight on
    assert corner - 0.1 < way[20, 20] < 1.1 * corner
    assert math.isinf(way[10, 25])


def test_a_way_with_an_end_leads_there_and_round_a_wall():
    slowness, way, end = np.ones((41, 41)), np.empty((41, 41)), np.array([2.5, 0.1])
    sweep(slowness, 0.25, np.array([1.0, 0.0]), end, way, 8)
    axis = 0.25 * (np.arange(41) - 20)
    distances = np.hypot(axis[None, :] - end[0], axis[:, None] - end[1])
    assert np.abs(way - distances).max() < 0.35  # first order: some centimetres a metre off the axes
    slowness[:31, 25] = math.inf
    sweep(slowness, 0.25, np.array([1.0, 0.0]), end, way, 8)
    around = 0.25 * math.hypot(5, 11) + 0.25 * math.hypot(5, 11)
    assert around - 0.2 < way[20, 20] < 1.15 * around


@pytest.mark.table(("end_x_m", "nearest_m"), [(1.25, 0.25), (1.5, 0.5)])
def test_a_way_leads_to_the_open_cells_nearest_to_an_end_that_is_closed(end_x_m, nearest_m):
    slowness, way = np.ones((41, 41)), np.empty((41, 41))
    slowness[:, 25:30] = math.inf
    sweep(slowness, 0.25, np.array([1.0, 0.0]), np.array([end_x_m, 0.0]), way, 8)
    assert way[20, 24] == pytest.approx(nearest_m)
    assert way[20, 20] == pytest.approx(nearest_m + 1.0)


def test_an_opening_stays_as_it_was_within_the_hysteresis():
    limits, states = np.array([0.43, 0.47, 0.51]), np.full((64, 64, 3), -math.inf)

    def closed(distance_m, stamp_s):
        slowness = np.empty((3, 3))
        fill_slowness(np.full((3, 3), distance_m), limits, 0.5, 1.5, 7, 9, stamp_s, 3.0, states, slowness)
        return bool(np.isinf(slowness[1, 1]))

    told = [
        closed(*question) for question in ((0.46, 0.0), (0.5, 1.0), (0.52, 2.0), (0.44, 3.0), (0.42, 4.0))
    ]
    assert told == [True, True, False, False, True]
    assert not closed(0.5, 20.0)  # what was long ago does not count


@settings(max_examples=20)
@given(seed=SEEDS, distance=st.floats(0.1, 2.0))
def test_a_path_is_near_what_is_near_any_of_its_places(seed, distance):
    rng = np.random.default_rng(seed)
    path, points = np.cumsum(rng.uniform(0.0, 0.5, (20, 2)), axis=0), rng.uniform(-2.0, 9.0, (3, 2))
    apart = np.linalg.norm(path[:, None] - points, axis=2)
    assert _is_near(path, points, distance) == (apart < distance).any()


@given(
    seed=SEEDS,
    beams=st.sampled_from((36, 400, 1440)),
    heading=st.floats(-math.pi, math.pi),
    angle_0=st.floats(-7.0, 7.0),
)
def test_what_is_wide_open_is_in_sight(seed, beams, heading, angle_0):
    rng, increment, radius = np.random.default_rng(seed), 2.0 * math.pi / beams, 0.35
    angles, spread = angle_0 + increment * np.arange(beams), rng.uniform(0.0, 1.0)
    path = np.linspace(0.0, rng.uniform(0.3, 8.0), 20)[:, None] * [math.cos(heading), math.sin(heading)]
    path += rng.uniform(-spread, spread, path.shape)
    from_heading = np.abs((angles - heading + math.pi) % (2.0 * math.pi) - math.pi)
    seen = from_heading < rng.uniform(1.0, math.pi)
    ranges = np.where(seen & (rng.random(beams) < 0.02), rng.uniform(0.5, 12.0, beams), np.inf)
    distance, direction = np.hypot(*path.T), np.arctan2(path[:, 1], path[:, 0])
    apart = np.abs((angles - direction[:, None] + math.pi) % (2.0 * math.pi) - math.pi)
    width = np.arcsin(np.minimum(1.0, radius / distance))[:, None]
    meets = (apart <= width) & (distance >= radius)[:, None]
    in_sight = not (meets & (~seen | (ranges < distance[:, None]))).any()
    scan = ranges, seen, angle_0, increment, 29.6
    assert in_sight or not _is_wide_open(path, scan, radius)
    assert not _is_wide_open(path, (ranges, seen, angle_0, increment, distance.max() - 0.01), radius)
    clear = np.full(beams, distance.max()), np.ones(beams, np.bool_), angle_0, increment, 29.6
    assert _is_wide_open(path, clear, radius) or distance[distance >= radius].min(initial=9.0) < 0.9


@given(seed=SEEDS, flown=st.integers(0, 40))
def test_a_path_leaves_sight_where_it_is_farther_than_was_seen_there(seed, flown):
    rng, width = np.random.default_rng(seed), 2.0 * math.pi / 360
    path = rng.uniform(-3.0, 3.0, (2, 40)) * (rng.random((2, 40)) < 0.9)  # some along an axis, or at rest
    bins = np.arctan2(path[1], path[0]) / width
    is_sure = np.abs(np.abs(bins - np.rint(bins)) - 0.5) > ANGLE_ERROR_RAD / width
    path[:, ~is_sure] = 0.0
    sight, most = rng.uniform(0.0, 8.0, 360), rng.uniform(-1.0, 2.5, 40)
    beyond_m = np.hypot(*path) - sight[np.rint(np.arctan2(path[1], path[0]) / width).astype(int) % 360]
    expected = (beyond_m > np.maximum(0.0, most))[:flown].any()
    assert leaves_reach(path, flown, sight, most) == expected


@settings(max_examples=20)
@given(seed=SEEDS)
def test_points_near_floor_and_ceiling_are_told(seed):
    points, is_clear = np.random.default_rng(seed).uniform(-4.0, 4.0, (50, 3)), np.empty(50, np.bool_)
    clear_of(points, -2.0, 3.0, 0.3, 0.1, is_clear)
    gap = 0.3 + 0.1 * np.linalg.norm(points[:, :2], axis=1)
    assert (is_clear == ((points[:, 2] > -2.0 + gap) & (points[:, 2] < 3.0 - gap))).all()


@settings(max_examples=20)
@given(seed=SEEDS, turn=st.floats(-3.0, 3.0))
def test_points_and_bins_are_those_of_the_beams(seed, turn):
    rng = np.random.default_rng(seed)
    ranges = np.where(rng.random(720) < 0.3, np.inf, rng.uniform(0.5, 9.0, 720))
    seen, increment = rng.random(720) < 0.9, 2.0 * math.pi / 720
    rotation = np.array(
        [[math.cos(turn), -math.sin(turn), 0.0], [math.sin(turn), math.cos(turn), 0.0], LEVEL[2]]
    )
    points, bins = np.empty((720, 3)), np.empty(360)
    directions = np.empty((720, 2))
    directions_of(0.1, increment, directions)
    orientation = 0.0, 0.0, math.sin(0.5 * turn), math.cos(0.5 * turn)
    found = points_of(ranges, seen, directions, *orientation, 8.0, points)
    bins_of(ranges, seen, 0.1, increment, rotation, 8.0, bins)
    angles = 0.1 + turn + increment * np.arange(720)
    hits = seen & (ranges < 8.0)
    plain = ranges[hits, None] * np.stack([np.cos(angles[hits]), np.sin(angles[hits])], axis=1)
    np.testing.assert_allclose(points[:found, :2], plain, atol=1e-9)
    for angle, r in zip(np.degrees(angles[seen]), np.minimum(ranges[seen], 8.0)):
        nearest = {round(angle - 1e-6) % 360, round(angle + 1e-6) % 360}  # two, half way between them
        assert min(bins[list(nearest)]) <= r + 1e-9


@settings(max_examples=10)
@given(seed=SEEDS)
def test_the_reach_in_sight_is_as_far_as_a_disc_meets_nothing_hidden(seed):
    rng = np.random.default_rng(seed)
    bins, reach = rng.choice([2.0, 5.0, 9.0], 360) * rng.uniform(0.5, 1.0, 360), np.empty(360)
    reach_in_sight(bins, 0.35, reach)
    angles = np.radians(np.arange(360))
    for b in rng.integers(0, 360, 10):
        for r in (reach[b] - 0.01, reach[b] + 0.01):
            along = r * np.cos(angles - angles[b])
            beyond = np.maximum(along, bins)  # the nearest place on each direction's hidden part
            gaps = np.sqrt(r * r - 2.0 * beyond * along + beyond**2)
            assert (gaps.min() >= 0.35 - 1e-6) == (r < reach[b]) or r > bins[b]


def test_what_no_beam_sees_was_seen_from_elsewhere():
    bins = np.full(360, 5.0)
    bins[170:190] = -1.0
    frames_xy, frames = np.array([[-1.0, 0.0]]), np.full((1, 360), 2.0)
    fill_blind(bins, 0.0, 0.0, frames_xy, frames, 1, 0.2, 4.0, 0.6)
    assert bins[180] == pytest.approx(2.8, abs=0.21)  # 2 m beyond the earlier place, which is 1 m behind
    assert bins[0] == 5.0


@pytest.mark.table(("seen_m", "is_seen"), [(2.0, True), (0.8, False)])
def test_the_body_was_seen_if_an_earlier_scan_reached_beyond_it(seen_m, is_seen):
    bins = np.full(360, 5.0)
    bins[120:241] = -1.0
    frames_xy, frames = np.array([[-1.0, 0.0]]), np.full((1, 360), seen_m)  # from 1 m behind
    assert was_seen_around(bins, 0.0, 0.0, frames_xy, frames, 1, 0.35) == is_seen
    assert not was_seen_around(bins, 0.0, 0.0, frames_xy, frames, 0, 0.35)


def test_memory_keeps_what_is_hidden_and_forgets_what_is_seen_free_or_old():
    cells = memory_cells()
    remember(np.array([[3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [-3.0, 0.0, 0.0]]), 100.0, 50.0, 1.0, 0.1, *cells)
    remember(np.array([[0.0, -3.0, 0.0]]), 100.0, 50.0, 0.0, 0.1, *cells)
    bins = np.full(360, 8.0)
    bins[85:96], bins[175:186] = 2.0, -1.0  # something stands before the second; nobody looks at the third
    for _ in range(TRUST):
        kept, hidden = recalled(bins, cells)
        assert hidden.all()
    assert kept == [(-3.0, 0.0), (0.0, 3.0)]


def memory_cells():
    return np.empty((160, 160, 2)), np.full((160, 160), -math.inf), np.zeros((160, 160), np.int64)


def recalled(bins, cells, patience=MOST_TRUST):
    """What is remembered 0.5 s after, seen from (100, 50), in ascending order, and which of it is hidden."""
    points, hidden = np.empty((10, 2)), np.empty(10, np.bool_)
    count = recall(100.0, 50.0, 0.5, 7.5, bins, 0.3, patience, *cells, points, hidden)
    return sorted(map(tuple, np.round(points[:count], 6).tolist())), hidden[:count]


@pytest.mark.table("scans", [1, 5, 40])
def test_what_was_seen_more_often_is_forgotten_later_when_seen_free(scans):
    """TRUST for each scan that saw it, MOST_TRUST at most. Until then it counts, though scans see past it."""
    cells, bins = memory_cells(), np.full(360, 8.0)
    for scan in range(scans):
        twice = np.array([[3.0, 0.01, 0.5], [3.0, 0.02, 0.5]])  # two points in one cell count once
        remember(twice, 100.0, 50.0, 1.0 + 0.025 * scan, 0.1, *cells)
    past = min(TRUST * scans, MOST_TRUST)
    for _ in range(past - 1):
        kept, hidden = recalled(bins, cells)
        assert len(kept) == 1
        assert hidden.all()
    assert recalled(bins, cells)[0] == []
    remember(np.array([[3.0, 0.0, 0.0]]), 100.0, 50.0, 9.0, 0.1, *cells)
    assert recalled(bins, cells, patience=1)[0] == []


@pytest.mark.table("height_m", [-0.8, 0.8])
def test_what_a_leaning_lidar_saw_far_from_its_height_is_forgotten_by_one_scan_past_it(height_m):
    cells, bins = memory_cells(), np.full(360, 8.0)
    for scan in range(5):
        remember(np.array([[3.0, 0.0, height_m]]), 100.0, 50.0, 1.0 + 0.025 * scan, 0.1, *cells)
    assert recalled(np.full(360, 2.0), cells)[0] == [(3.0, 0.0)]  # something stands before it
    assert recalled(bins, cells)[0] == []


def test_a_place_that_was_trusted_stays_so_when_a_leaning_lidar_meets_it():
    cells, bins = memory_cells(), np.full(360, 8.0)
    for scan, height_m in enumerate((0.0, -0.8)):
        remember(np.array([[3.0, 0.0, height_m]]), 100.0, 50.0, 1.0 + 0.025 * scan, 0.1, *cells)
    for _ in range(TRUST - 1):
        assert recalled(bins, cells)[0] == [(3.0, 0.0)]
    assert recalled(bins, cells)[0] == []


def test_memory_knows_what_is_near_a_straight_way():
    cells = memory_cells()
    remember(np.array([[3.0, 1.0, 0.0]]), 100.0, 50.0, 1.0, 0.1, *cells)
    xy, stamps, _ = cells

    def near(end_x, end_y, distance_m, oldest_s=0.5):
        return knows_near(end_x, end_y, 100.0, 50.0, oldest_s, distance_m, 0.1, xy, stamps)

    assert near(4.0, 0.0, 1.1)
    assert not near(4.0, 0.0, 0.9)
    assert not near(2.0, 0.0, 1.3)
    assert near(2.0, 0.0, 1.5)
    assert near(0.0, 0.0, 3.2)
    assert not near(0.0, 0.0, 3.1)
    assert not near(4.0, 0.0, 1.1, oldest_s=1.5)


@settings(max_examples=5)
@given(ux=st.floats(-4.0, 4.0), uy=st.floats(-4.0, 4.0), v=st.floats(-4.0, 4.0))
def test_a_rollout_follows_the_law_of_the_response(ux, uy, v):
    model = CepaParameters().response
    start, path = np.zeros((3, 4)), np.empty((20, 3))
    start[0, 1] = v
    roll(start, np.array([ux, uy, 0.0]), response_of(model, 0.05), 20, path)
    position, velocity, acceleration = np.zeros(2), np.array([v, 0.0]), np.zeros(2)
    for step in range(500):
        change = (model.p * (np.array([ux, uy]) - velocity) - acceleration) / model.lag_s
        change *= min(1.0, model.jerk_max_m_s3 / max(np.hypot(*change), 1e-9))
        acceleration = acceleration + 2e-3 * change
        acceleration *= min(1.0, model.acceleration_max_m_s2 / max(np.hypot(*acceleration), 1e-9))
        velocity = velocity + 2e-3 * acceleration
        position = position + 2e-3 * velocity
        if step % 25 == 24:
            assert np.hypot(*(path[step // 25, :2] - position)) < 0.06


def test_the_observer_finds_the_state_and_foresees_what_is_commanded():
    model = ResponseModel()
    observer, (f, g) = Observer(model), model.transition(0.025)
    state = np.zeros((3, 4))
    command = np.array([2.0, -1.0, 0.0])
    for scan in range(40):
        stamp_s, measured = 0.025 * scan, (*state[:2, 1].tolist(), 0.0)
        now = observer.update(stamp_s, measured, stamp_s, stamp_s).state
        observer.command(stamp_s, command.tolist(), 0.1)
        if scan >= 2:  # the delay of two scans
            state[:2] = state[:2] @ f.T + np.outer(command[:2], g)
    np.testing.assert_allclose(now[:2, 1], state[:2, 1], atol=0.15)
    stamp_s = 0.025 * 39
    later, _ = observer.update(stamp_s, measured, stamp_s, stamp_s + 0.1)
    assert later[0, 0] == pytest.approx(0.1 * now[0, 1], abs=0.05)
    from_scan, way_m = observer.update(stamp_s, measured, stamp_s + 0.06, stamp_s + 0.1)
    assert way_m[0] + from_scan[0, 0] == pytest.approx(later[0, 0])
    assert way_m[0] == pytest.approx(0.06 * now[0, 1], abs=0.03)


def test_a_velocity_may_be_whole_numbers():
    told = [
        Observer(ResponseModel()).update(0.0, velocity, 0.0, 0.1).state
        for velocity in ((2, 0, 0.0), (2.0, 0.0, 0.0))
    ]
    np.testing.assert_array_equal(*told)


def test_the_cross_section_spans_a_pocket_and_an_open_place_has_none():
    """A corridor three cells wide and closed on the right; the way out leads to the left."""
    way = np.tile(np.arange(21.0), (21, 1))
    slowness = np.full((21, 21), math.inf)
    slowness[9:12, :18] = 1.0
    cells = np.empty((20, 2), np.int64)
    count = cross_section(way, slowness, 2.0, 4.0, cells)
    assert sorted(map(tuple, cells[:count].tolist())) == [(x, y) for x in (2, 3) for y in (-1, 0, 1)]
    slowness[9:12] = 1.0  # it may go on beyond the edge
    assert cross_section(way, slowness, 2.0, 4.0, cells) == 0
    slowness[9:12, 18:] = math.inf
    assert cross_section(way, slowness, 2.0, 4.0, cells[:5]) == 0  # too wide
