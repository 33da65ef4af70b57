"""What moves in a planar world of standing trunks and walls, seen from a UAV in flight."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from planar_flight import Lidar, Scene, box, forest

from cepa import ParameterError
from cepa.dynamic.free_space.free_ranges import FreeRanges
from cepa.dynamic.obstacle_tracks.tracker import ObstacleTracker, TrackerParameters
from cepa.motion import DOUBTED, Doubt
from cepa.scan import Beams

SCAN_S = 0.025
INCREMENT_RAD = math.radians(0.5)
BEAMS = 540
RANGE_MAX_M, RANGE_MARGIN_M = 10.0, 0.4


def bins_of(angles, ranges):
    """Return how far the scan sees in each of 360 directions."""
    bins = np.full(360, np.inf)
    np.minimum.at(bins, np.round(np.degrees(angles)).astype(int) % 360, ranges)
    return np.where(np.isinf(bins), -1.0, bins)


def free_as(bins, shown_m=math.inf, slope=(0.0, 0.0)):
    """Return what a lidar sees whose plane falls by ``slope``; it shows nothing beyond ``shown_m``."""
    level_m = np.full(bins.size, math.inf)
    return SimpleNamespace(free_m=bins, level_m=level_m, shown_m=np.minimum(bins, shown_m), slope=slope)


class World:
    """Standing things, and things that move from a place at a velocity: (x, y), (vx, vy), radius or edge."""

    def __init__(self, standing=None, circles=(), boxes=()):
        self._standing = standing or Scene()
        self._circles, self._boxes = circles, boxes

    def at(self, t):
        circles, walls = [self._standing.circles], [self._standing.walls]
        for (x, y), (vx, vy), radius in self._circles:
            circles.append(np.array([(x + vx * t, y + vy * t, radius)]))
        for (x, y), (vx, vy), edge in self._boxes:
            walls.append(np.array(box(x + vx * t, y + vy * t, edge)))
        return Scene(np.concatenate(circles), np.concatenate(walls))


class Lorry(World):
    """A box of 6 m by 1.8 m that drives along y at 1 m/s, from behind a wall to behind another one."""

    def __init__(self, start_y):
        super().__init__(Scene(walls=np.array([(4.0, -9.0, 4.0, -3.2), (4.0, 3.2, 4.0, 9.0)])))
        self._start_y = start_y

    def at(self, t):
        y, sides = self._start_y + t, self._standing.walls
        corners = np.array([(6.0, y - 3.0), (6.0, y + 3.0), (7.8, y + 3.0), (7.8, y - 3.0)])
        return Scene(walls=np.concatenate((sides, np.hstack((corners, np.roll(corners, -1, axis=0))))))


class InParts(World):
    """A box of 3 m by 1.8 m that comes head-on at 2 m/s; for 0.1 s a leaning lidar shows a part of it."""

    BEGINS_S, SHARES = 0.2, (0.25, 0.25, 0.5, 0.5, 1.0)

    def __init__(self, start, left_first):
        super().__init__()
        self._start, self._left_first = start, left_first

    def at(self, t):
        if t < self.BEGINS_S:
            return self._standing
        (x, y), share = self._start, self.SHARES[min(4, round((t - self.BEGINS_S) / SCAN_S))]
        shown_y = 0.9 - 1.8 * share, 0.9
        right, left = (y + each for each in (shown_y if self._left_first else np.negative(shown_y[::-1])))
        near, far = x - 2.0 * t, x - 2.0 * t + 3.0
        corners = np.array([(near, right), (near, left), (far, left), (far, right)])
        return Scene(walls=np.hstack((corners, np.roll(corners, -1, axis=0))))


class Odometry:
    """Drifts as the simulator's: in steps with the way flown, and 3 cm of noise in each scan."""

    def __init__(self, rng, noise_m=0.03):
        self._rng, self._noise_m, self._turn, self._shift = rng, noise_m, 0.0, np.zeros(2)

    def error(self, speed):
        way = speed * SCAN_S
        self._shift = self._shift + self._rng.normal(0.0, 0.02, 2) * math.sqrt(way) + 0.01 * way
        self._turn += self._rng.normal(0.0, 0.01) * math.sqrt(way) + 0.002 * way
        return self._turn, self._shift + self._rng.normal(0.0, self._noise_m, 2)


def watch(
    world,
    seconds,
    speed=0.0,
    seed=0,
    start_x=0.0,
    skip=lambda t: False,
    parameters=None,
    noise_m=0.03,
    doubt=DOUBTED,
    drift=None,
):
    """Fly along x, swaying, and yield (t, place in odometry, points, what moves) of each scan.

    doubt: what of the odometry an IMU leaves in doubt. drift: in place of the odometry's error, (turn, shift)
    at a time.
    """
    rng = np.random.default_rng(seed)
    movers, odometry = ObstacleTracker(parameters), Odometry(rng, noise_m)
    for k in range(round(seconds / SCAN_S)):
        t = k * SCAN_S
        turn, shift = odometry.error(speed) if drift is None else drift(t)
        if skip(t):
            continue
        place = np.array([start_x + speed * t, 0.0])
        angles = -math.radians(135.0) + np.arange(BEAMS) * INCREMENT_RAD
        angles += 0.3 * math.sin(1.7 * t) if speed else 0.0
        ranges = world.at(t).ranges(place, np.stack([np.cos(angles), np.sin(angles)], axis=1))
        ranges = ranges + rng.normal(0.0, Lidar.sigma, BEAMS)
        hit = ranges < RANGE_MAX_M
        believed = angles + turn
        directions = np.stack([np.cos(believed), np.sin(believed)], axis=1)
        points = place + shift + ranges[hit, None] * directions[hit]
        bins = bins_of(believed, np.minimum(ranges, RANGE_MAX_M - RANGE_MARGIN_M))
        yield (
            t,
            shift,
            points,
            movers.update(
                t, points - place - shift, place + shift, free_as(bins), doubt=doubt, speed_m_s=speed
            ),
        )


FEW_TRUNKS = Scene(circles=np.array([(3.0, 4.0, 0.2), (6.0, -5.0, 0.3), (8.0, 3.5, 0.25), (2.0, -4.0, 0.2)]))


@pytest.mark.table("speed", [1.0, 2.0])
@pytest.mark.table(
    ("start", "direction"), [((5.0, -3.0), (0.0, 1.0)), ((8.0, 0.5), (-1.0, 0.0)), ((3.0, 0.5), (1.0, 0.0))]
)
@pytest.mark.table("radius", [0.2, 0.5])
def test_a_person_is_found_within_half_a_second_with_its_velocity(speed, start, direction, radius):
    velocity = speed * np.array(direction)
    world = World(FEW_TRUNKS, circles=[(start, velocity, radius)])
    found_s, errors = None, []
    for t, shift, _, moving in watch(world, 2.0, seed=1):
        assert len(moving.positions) <= 1
        if len(moving.positions) == 1:
            found_s = found_s or t
            errors.append(np.hypot(*(moving.velocities[0] - velocity)))
            assert np.hypot(*(moving.positions[0] - start - velocity * t - shift)) < 0.3
    assert found_s <= 0.15 + 0.5 / speed
    assert np.median(errors) < 0.2
    assert max(errors) < 0.8


@pytest.mark.table("velocity", [(-1.4, 0.0), (-0.7, 0.0), (-1.2, 0.5)])
@pytest.mark.table(("persons", "standing"), [(4, 0), (8, 0), (6, 3)])
def test_people_abreast_are_no_drift_of_the_odometry(persons, standing, velocity):
    # They come 1.1 m apart to a field where less stands than moves: an odometry that is off by as much
    # would look the same
    places = [(7.0, 1.1 * (k - 0.5 * (persons - 1))) for k in range(persons)]
    world = World(
        Scene(FEW_TRUNKS.circles[:standing]), [(place, np.array(velocity), 0.3) for place in places]
    )
    sets = [moving for t, _, _, moving in watch(world, 1.2, seed=1) if t > 0.8]
    assert min(len(moving.positions) for moving in sets) >= persons - 1
    velocities = np.array([np.median(moving.velocities, axis=0) for moving in sets])
    assert np.median(velocities, axis=0) == pytest.approx(velocity, abs=0.4)


@pytest.mark.table("persons", [4, 6, 8])
def test_slow_people_abreast_are_found_where_an_imu_confirms_the_odometry(persons):
    # At 0.45 m/s they come no faster than an odometry may drift for a while; nothing stands
    places = [(7.0, 1.1 * (k - 0.5 * (persons - 1))) for k in range(persons)]
    world = World(circles=[(place, np.array((-0.45, 0.0)), 0.3) for place in places])
    doubt = Doubt(turn=True, shift=False)
    sets = [moving for t, _, _, moving in watch(world, 2.0, seed=1, doubt=doubt) if t > 1.5]
    assert min(len(moving.positions) for moving in sets) == persons
    velocities = np.array([np.median(moving.velocities, axis=0) for moving in sets])
    assert np.median(velocities, axis=0) == pytest.approx((-0.45, 0.0), abs=0.15)


@pytest.mark.table(
    ("doubt", "seems_to_move"), [(DOUBTED, False), (Doubt(True, False), False), (Doubt(False, False), True)]
)
def test_a_heading_that_drifts_is_recognised_where_the_imu_does_not_confirm_it(doubt, seems_to_move):
    # 0.06 rad/s: what stands 9 m away seems to move at 0.5 m/s
    far = World(Scene(circles=np.array([(8.5, y, 0.25) for y in (-3.0, -1.0, 1.0, 3.0)])))
    sets = watch(far, 1.0, seed=1, noise_m=0.0, doubt=doubt, drift=lambda t: (0.06 * t, np.zeros(2)))
    assert any(len(moving.positions) for _, _, _, moving in sets) == seems_to_move


@pytest.mark.table("edge", [1.0, 2.0])
def test_a_vehicle_is_found_from_a_uav_in_flight(edge):
    world = World(FEW_TRUNKS, boxes=[((9.0, -5.0), (0.0, 2.0), edge)])
    sets = [moving for t, _, _, moving in watch(world, 1.5, speed=2.0, seed=2) if t > 0.6]
    assert all(len(moving.positions) == 1 for moving in sets)
    velocities = np.array([moving.velocities[0] for moving in sets])
    assert np.median(velocities, axis=0) == pytest.approx([0.0, 2.0], abs=0.4)


def test_a_lorry_seen_in_part_in_full_and_in_part_keeps_its_velocity():
    parameters = TrackerParameters(greatest_radius_m=3.3)
    for t, _, _, moving in watch(Lorry(-9.0), 17.0, parameters=parameters, noise_m=0.0):
        front_y, rear_y = t - 6.0, t - 12.0
        if front_y > -4.8:  # so far from the line of sight past the wall
            (velocity,), (place,), (radius,) = moving.velocities, moving.positions, moving.radii
            assert velocity == pytest.approx([0.0, 1.0], abs=0.3)
            # And the disc holds all of the near side that is in sight
            ends = np.array([(6.0, max(rear_y, -4.8)), (6.0, min(front_y, 4.8))])
            assert (np.hypot(*(ends - place).T) < radius + 0.3).all()


@pytest.mark.table("left_first", [False, True])
@pytest.mark.table("aside_m", [-1.5, 0.0, 1.5])
@pytest.mark.table("seed", range(3))
def test_a_lorry_that_comes_into_view_in_parts_does_not_come_sideways(seed, aside_m, left_first):
    world, told = InParts((9.0, aside_m), left_first), 0
    for t, _, _, moving in watch(world, 2.0, speed=1.0, seed=seed):
        if t > InParts.BEGINS_S + 0.5:
            assert moving.velocities == pytest.approx(np.array([[-2.0, 0.0]]), abs=0.55)
            told += 1
    assert told > 40


def test_its_points_and_no_others_are_marked():
    world = World(FEW_TRUNKS, circles=[((5.0, -3.0), (0.0, 2.0), 0.4)])
    for t, shift, points, moving in watch(world, 1.0, seed=3):
        off = np.hypot(*(points - (5.0, -3.0 + 2.0 * t) - shift).T)
        if len(moving.positions):
            assert moving.is_moving[off < 0.45].all()
            assert not moving.is_moving[off > 1.2].any()
        else:
            assert not moving.is_moving.any()


@pytest.mark.table("seed", range(2))
def test_nothing_moves_in_a_forest(seed):
    # 4 m/s, trunks that appear from behind others, a wall with a corner. Of 20 such forests none had a false
    # mover in 9600 scans (doc/how_it_works.md)
    rng = np.random.default_rng(seed)
    trunks = forest(rng, length=36.0, width=24.0, spacing=3.0, clear=0.0).circles
    trunks = trunks[np.abs(trunks[:, 1]) > trunks[:, 2] + 0.4]
    walls = np.array([(-5.0, 13.0, 65.0, 13.0), (10.0, -13.0, 10.0, -6.0), (10.0, -6.0, 30.0, -6.0)])
    for _, _, _, moving in watch(World(Scene(trunks, walls)), 5.0, speed=4.0, seed=seed):
        assert len(moving.positions) == 0


def test_it_is_predicted_while_hidden_and_forgotten_after_a_second():
    trunk = Scene(circles=np.array([*FEW_TRUNKS.circles, (3.0, 0.0, 0.25)]))
    world = World(trunk, circles=[((6.0, -2.5), (0.0, 1.5), 0.2)])
    hidden = [(t, moving) for t, _, points, moving in watch(world, 3.0, seed=4) if abs(-2.5 + 1.5 * t) < 0.8]
    assert all(len(moving.positions) == 1 for _, moving in hidden)
    # And nobody looks any more
    sets = list(watch(world, 4.0, seed=4, skip=lambda t: 0.8 < t < 2.3))
    assert len([moving for t, _, _, moving in sets if 0.7 < t <= 0.8][-1].positions) == 1
    assert len(next(moving for t, _, _, moving in sets if t >= 2.3).positions) == 0


def flee(things, looks_back, seconds):
    """Yield (t, what moves) while a UAV flies along -x at 1.4 m/s.

    things: (x, y) of all that stands or walks there at a time, as seen from the UAV, m. looks_back: whether
    its lidar of 270 degrees looks along x, else along -x.
    """
    movers = ObstacleTracker()
    for k in range(round(seconds / SCAN_S)):
        t = k * SCAN_S
        angles = -math.radians(135.0) + np.arange(BEAMS) * INCREMENT_RAD
        angles += 0.0 if looks_back(t) else math.pi
        directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        ranges = Scene(np.array([(x, y, 0.25) for x, y in things(t)])).ranges(np.zeros(2), directions)
        hit = ranges < RANGE_MAX_M
        free = free_as(bins_of(angles, np.minimum(ranges, RANGE_MAX_M - RANGE_MARGIN_M)))
        points = ranges[hit, None] * directions[hit]
        yield t, movers.update(t, points, np.array([-1.4 * t, 0.0]), free, doubt=Doubt(False, False))


def test_who_walks_beside_a_lost_person_is_another_one():
    # Both walk at 1.4 m/s, as fast as the UAV flies, so they stay 2 m behind it. The one straight behind is
    # out of sight from 1.5 s on. The other one steps out of a door at 4 s, 2.1 m beside, at the edge of the
    # view
    beside = [(2.0, 2.1)]
    for t, moving in flee(lambda t: [(2.0, 0.0)] + beside * (t >= 4.0), lambda t: t < 1.5, 5.4):
        if t > 1.0:
            apart_m = np.hypot(moving.positions[:, 0] + 1.4 * t - 2.0, moving.positions[:, 1])
            assert apart_m.min() < 0.3
        assert len(moving.positions) == 2 or t < 4.5


def test_a_lost_person_who_comes_into_sight_again_is_the_same_one():
    counts = [
        (t, len(moving.positions))
        for t, moving in flee(lambda t: [(2.0, 0.0)], lambda t: not 1.5 <= t < 4.5, 5.5)
    ]
    assert all(count == 1 for t, count in counts if t > 1.0)


def test_of_posts_that_come_into_sight_near_a_lost_thing_at_most_one_moves_on():
    # As in a narrow place in which the UAV climbs. A wall hides the person from 0.9 s on, and another post
    # comes into sight there each quarter of a second
    wall, person = np.array([(4.0, -0.6, 4.0, 6.0)]), World(circles=[((5.0, -3.0), (0.0, 2.0), 0.3)])
    posts = np.array([(3.3, 0.45 * k - 0.9, 0.06) for k in range(8)])

    class Narrow(World):
        def at(self, t):
            seen = posts[: max(0, math.ceil((t - 0.9) / 0.25))]
            return Scene(np.concatenate((FEW_TRUNKS.circles, person.at(t).circles, seen)), wall)

    counts = [(t, len(moving.positions)) for t, _, _, moving in watch(Narrow(), 6.0, seed=5)]
    assert any(count for t, count in counts if t < 0.9)
    assert all(count <= 1 for _, count in counts)
    assert all(count == 0 for t, count in counts if 4.0 < t < 5.0)  # then the person comes into sight again


@pytest.mark.table(
    ("climb_m_s", "rise_m_s", "are_upright", "moves"),
    [(0.8, 0.0, True, False), (0.0, 0.0, False, True), (0.0, 0.8, False, False), (0.0, 0.8, True, True)],
)
def test_posts_that_slope_stand_while_the_uav_climbs_or_leans(climb_m_s, rise_m_s, are_upright, moves):
    """In each scan they are farther away, as something that moves is to a UAV that stays as it is.

    rise_m_s: so fast the lidar's plane rises 3 m ahead, because the UAV leans back.
    """
    movers, bins, sets = ObstacleTracker(), np.full(360, 9.6), []
    angles = np.radians(np.arange(-3.0, 3.5, 0.5))
    for k in range(80):
        x = 3.0 + 0.8 * k * SCAN_S
        points = np.stack([np.full(len(angles), x), 3.0 * np.tan(angles)], axis=1)
        bins = np.full(360, 9.6)
        bins[[*range(-4, 5)]] = x
        height_m = 2.0 + climb_m_s * k * SCAN_S
        free = free_as(bins, slope=(-rise_m_s * k * SCAN_S / 3.0, 0.0))
        sets.append(movers.update(k * SCAN_S, points, (0.0, 0.0), free, None, height_m, are_upright))
    assert any(len(moving.radii) for moving in sets) == moves


def test_what_stops_stands():
    def places(t):
        return (5.0, -2.0 + 1.5 * min(t, 1.2))

    class Stops(World):
        def at(self, t):
            return Scene(np.concatenate((FEW_TRUNKS.circles, [(*places(t), 0.3)])))

    sets = list(watch(Stops(), 3.0, seed=5))
    assert any(len(moving.positions) == 1 for t, _, _, moving in sets if t < 1.2)
    # Its evidence is used up within EVIDENCE_MAX_S / EVIDENCE_LOSS_OF_SLOW = 1 s after its velocity has gone
    assert all(len(moving.positions) == 0 for t, _, _, moving in sets if t > 1.2 + 0.25 + 1.0)


def test_the_floor_is_no_thing_that_moves():
    # The floor ahead of a UAV that pitches: an arc of points that comes nearer, 1.5 m below
    movers, across = ObstacleTracker(), np.linspace(-0.5, 0.5, 40)
    for k in range(80):
        points = np.stack([np.full(40, 8.0 - 1.5 * k * SCAN_S), across], axis=1)
        bins = np.full(360, 9.6)
        bins[[*range(-4, 5)]] = points[0, 0]
        is_level = movers.clear_of_floor(np.column_stack((points, np.full(40, -1.5))), -1.6, 10.0)
        moving = movers.update(k * SCAN_S, points, np.zeros(2), free_as(bins), is_level)
        assert len(moving.positions) == 0
        assert moving.is_moving.shape == (40,)


@pytest.mark.table(("shown_m", "moves"), [(5.0, False), (math.inf, True)])
def test_a_wall_over_which_a_leaning_lidar_has_looked_does_not_move(shown_m, moves):
    # A wall 7 m ahead. The UAV leans for half a second; then it sees a part of the wall through a door, and
    # as it flies on, another part. With beams that do not pass over it, a wall has come from the side.
    movers, nothing, free = ObstacleTracker(), np.empty((0, 2)), np.full(360, 9.6)
    for k in range(20):
        movers.update(k * SCAN_S, nothing, (0.0, 0.0), free_as(free, shown_m))
    sets = []
    for k in range(20, 50):
        left = -1.0 + 1.5 * (k - 20) * SCAN_S
        points = np.stack([np.full(30, 7.0), np.linspace(left, left + 1.2, 30)], axis=1)
        bins = np.full(360, 3.0)  # the wall with the door
        angles = np.degrees(np.arctan2(points[:, 1], points[:, 0]))
        bins[np.round(angles).astype(int) % 360] = 7.0
        sets.append(movers.update(k * SCAN_S, points, (0.0, 0.0), free_as(bins)))
    assert any(len(moving.radii) for moving in sets) == moves


def test_a_leaning_lidar_shows_nothing_where_its_beams_are_far_above_it():
    lean_rad = math.radians(20.0)
    beams = Beams(np.full(720, 20.0), np.ones(720, bool), 0.0, math.pi / 360, nearest=20.0)
    free = FreeRanges(beams, (0.0, math.sin(0.5 * lean_rad), 0.0, math.cos(0.5 * lean_rad)), 30.0)
    assert free.shown_m[0] == pytest.approx(20.0 * math.cos(lean_rad), abs=0.01)  # ahead its beams fall
    assert free.shown_m[180] == pytest.approx(1.5 / math.tan(lean_rad), abs=0.01)
    assert free.shown_m[90] == pytest.approx(20.0, abs=0.01)  # abeam its beams are level


def test_a_clock_that_goes_back_and_empty_scans_are_no_harm():
    movers, nothing, bins = ObstacleTracker(), np.empty((0, 2)), np.full(360, 9.6)
    for stamp_s in (5.0, 5.025, 1.0, 1.025, 9.0):
        moving = movers.update(stamp_s, nothing, np.zeros(2), free_as(bins))
        assert len(moving.positions) == 0
        assert moving.is_moving.shape == (0,)


def test_discs_hold_the_thing_with_its_uncertainty():
    world = World(FEW_TRUNKS, circles=[((5.0, -3.0), (0.0, 2.0), 0.4)])
    moving = [moving for _, _, _, moving in watch(world, 1.0, seed=6)][-1]
    ((x, y, vx, vy, radius, growth),) = moving.movers(np.array([1.0, 1.0]))
    assert (x, y) == pytest.approx((4.0, -2.0), abs=0.3)
    assert (vx, vy) == pytest.approx((0.0, 2.0), abs=0.3)
    assert 0.35 < radius < 0.7
    assert 0.0 < growth < 1.0


def test_a_parameter_that_makes_no_sense_is_refused():
    with pytest.raises(ParameterError, match="speed_min_m_s"):
        TrackerParameters(speed_min_m_s=0.0)
