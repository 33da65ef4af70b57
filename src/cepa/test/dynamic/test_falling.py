"""What comes down is found by clouds, ahead or beside, and is not flown under; what stands does not fall."""

from __future__ import annotations

import math

import numpy as np
import pytest
from spatial_flight import HEIGHT_M, LEVEL, NO_SCAN, PERIOD_S, STEP_S, Boxes

from cepa import Cloud, Dynamic, Motion, Reason
from cepa.dynamic.constants.free_space import PICTURE_ROW_TAN
from cepa.dynamic.free_space.cloud_picture import CloudPicture
from cepa.dynamic.kernels.response import fly
from cepa.dynamic.observer import response_of
from cepa.dynamic.obstacle_tracks.falling import Falling
from cepa.dynamic.obstacle_tracks.kernels.falling import fall_rates, lowest_over
from cepa.motion import Ranging

FAR_M, LIMITS_RAD = 30.0, (-0.7, 0.9)
PUCK_PERIOD_S = 0.05
CHANNELS_RAD = np.linspace(*LIMITS_RAD, 64)
"""Of a QT64."""


def directions(step_deg: float) -> np.ndarray:
    """Return those of its beams (n, 3)."""
    azimuth, up = np.meshgrid(np.radians(np.arange(0.0, 360.0, step_deg)), CHANNELS_RAD)
    around = np.cos(up) * np.cos(azimuth), np.cos(up) * np.sin(azimuth), np.sin(up)
    return np.stack(around, axis=-1).reshape(-1, 3)


AROUND, FINE = directions(2.0), directions(0.6)


def cloud_of(boxes: Boxes, place: np.ndarray, beams: np.ndarray = AROUND) -> Cloud:
    ranges = boxes.ranges(place, beams)
    met = (ranges > 0.1) & (ranges < FAR_M)
    return Cloud(beams[met] * ranges[met, None], LIMITS_RAD, 0.1, FAR_M)


def box(x: float, y: float, z: float, edge_m: float, high_m: float | None = None) -> Boxes:
    """Return a box whose lowest face has this middle."""
    half = 0.5 * edge_m
    return Boxes(np.array([[(x - half, y - half, z), (x + half, y + half, z + (high_m or edge_m))]]))


def found_in(
    boxes_at, speed: float, until_s: float, climb: float = 0.0, period_s: float = PERIOD_S, cloud_of=cloud_of
) -> tuple[float, np.ndarray] | None:
    """Return when a UAV that flies along x finds that something comes down, and the discs; None: never."""
    falling, picture = Falling(0.15), CloudPicture()
    for t in np.arange(0.0, until_s, period_s).tolist():
        place = np.array([speed * t, 0.0, HEIGHT_M + climb * t])
        motion = Motion(t, tuple(place.tolist()), LEVEL, (speed, 0.0, climb))
        points = picture.take_in(cloud_of(boxes_at(t), place), motion)
        falling.take_in(points, picture.free, PICTURE_ROW_TAN * picture.rows_in_one, motion)
        columns = falling.columns(motion)
        if len(columns):
            return t, columns
    return None


@pytest.mark.table(("edge_m", "sinks"), [(0.3, 0.5), (1.0, 0.2), (2.0, 2.0)])
def test_a_load_is_found_before_it_is_at_the_height_of_the_body(edge_m, sinks):
    start_m = 4.0 + sinks
    found = found_in(lambda t: box(3.0, 0.0, start_m - sinks * t, edge_m), 0.0, 20.0)
    assert found is not None
    found_s, ((ahead, aside, _, _, radius, *_),) = found
    arrives_s = (start_m - HEIGHT_M - 0.15) / sinks
    assert 1.0 < arrives_s - found_s < 6.5
    assert math.hypot(ahead - 3.0, aside) < radius  # the load's middle is in the disc


def test_a_load_whose_near_side_is_over_the_highest_channel_is_as_large_as_loads_are():
    # Given a load from x = 0.5 to 2.5 m, of which the channels up to 52 degrees see the far side only
    found = found_in(lambda t: box(1.5, 0.0, HEIGHT_M + 3.4 - 0.5 * t, 2.0), 0.0, 4.0)
    assert found is not None
    _, ((ahead, aside, _, _, radius, *_),) = found
    # Then the disc holds the load's middle, too, and reaches its near side
    assert math.hypot(ahead - 1.5, aside) < radius
    assert ahead - radius < 0.5


@pytest.mark.table(("edge_m", "sinks"), [(0.35, 0.5), (1.15, 1.1), (1.0, 1.2)])
def test_a_load_that_is_in_view_for_less_than_half_a_second_is_found_and_as_wide_as_its_front(edge_m, sinks):
    start_m, far_m = HEIGHT_M + 1.5, 1.0 + edge_m
    load_at = lambda t: box(0.5 * (1.0 + far_m), 0.0, start_m - sinks * t, edge_m)  # noqa: E731
    found = found_in(load_at, 0.0, 3.0, 0.0, PUCK_PERIOD_S, lambda boxes, place: boxes.cloud(place))
    assert found is not None
    found_s, ((ahead, aside, _, _, radius, *_),) = found
    # A Puck's highest channel meets the far end of its bottom first, and the body ends 0.15 m over the lidar
    seen_s = (start_m - HEIGHT_M - far_m * math.tan(math.radians(15.0))) / sinks
    arrives_s = (start_m - HEIGHT_M - 0.15) / sinks
    assert arrives_s - seen_s < 0.5
    assert seen_s < found_s < arrives_s
    for corner_m in (-0.5 * edge_m, 0.5 * edge_m):
        assert math.hypot(ahead - 1.0, aside - corner_m) < radius


def by_puck(boxes: Boxes, place: np.ndarray) -> Cloud:
    return boxes.cloud(place)


def seen_in_the_open(
    boxes_at, speed: float, until_s: float, period_s: float = PUCK_PERIOD_S, cloud_of=by_puck
) -> list[float]:
    """Return when something may come down, s, for a UAV that flies along x."""
    falling, picture, times_s = Falling(0.15), CloudPicture(), []
    for t in np.arange(0.0, until_s, period_s).tolist():
        place = np.array([speed * t, 0.0, HEIGHT_M])
        motion = Motion(t, tuple(place.tolist()), LEVEL, (speed, 0.0, 0.0))
        points = picture.take_in(cloud_of(boxes_at(t), place), motion)
        falling.take_in(points, picture.free, PICTURE_ROW_TAN * picture.rows_in_one, motion)
        if len(falling.columns(motion, counts_signs=True)):
            times_s.append(t)
    return times_s


@pytest.mark.table(("edge_m", "sinks"), [(0.5, 0.8), (0.6, 1.0), (0.8, 1.5)])
def test_in_the_open_what_comes_into_view_from_above_counts_in_the_second_cloud(edge_m, sinks):
    # Given a load that is at the UAV's height 0.6 m ahead, 2 s after the UAV has set off at 1 m/s
    middle_m = 2.6 + 0.5 * edge_m
    times_s = seen_in_the_open(lambda t: box(middle_m, 0.0, HEIGHT_M + sinks * (2.0 - t), edge_m), 1.0, 2.0)
    # Then it is found as soon as the highest channel has met its bottom's far edge twice
    far_m, up = 2.6 + edge_m, math.tan(math.radians(15.0))
    seen_s = (2.0 * sinks - far_m * up) / (sinks - up)
    assert seen_s <= times_s[0] <= seen_s + 0.15


@pytest.mark.parametrize("speed", [pytest.param(0.5, marks=pytest.mark.long), 1.0, 2.0])
def test_in_the_open_what_stands_does_not_come_down_though_the_uav_flies_up_to_it_and_under_it(speed):
    standing = np.concatenate(
        [
            box(5.0, 0.0, HEIGHT_M + 0.6, 0.4).corners,  # an arm of a crane
            box(7.0, 1.0, 0.0, 0.4, 6.0).corners,  # a pillar
            np.array([[(9.0, -6.0, HEIGHT_M + 1.0), (15.0, 6.0, HEIGHT_M + 1.4)]]),  # a bridge
        ]
    )
    assert not seen_in_the_open(lambda _: Boxes(standing), speed, 11.0 / speed)


def test_in_the_open_what_may_come_down_counts_on_while_it_is_out_of_view_again():
    # Given a load 1 m ahead of a UAV that hovers, which two clouds of a QT64 show, 1.2 m above the body
    low_m = HEIGHT_M + 0.15 + 1.2
    load_at = lambda t: box(1.0, 0.0, low_m if 1.55 < t < 1.75 else 30.0, 0.5)  # noqa: E731
    times_s = seen_in_the_open(load_at, 0.0, 4.0, PERIOD_S, cloud_of)
    # Then it counts from the second one on, until it should have arrived at 2 m/s, and 0.5 s more
    assert times_s == pytest.approx(np.arange(1.7, 1.7 + 0.6 + 0.5 + 1e-6, PERIOD_S))


def test_in_the_open_what_comes_into_view_from_behind_a_wall_does_not_come_down():
    # Given a beam that the end of a high wall hides until the UAV is within 2 m of it
    beam = (3.3, 1.3, HEIGHT_M + 0.8), (3.7, 1.7, HEIGHT_M + 1.2)
    behind = Boxes(np.array([((-9.0, 0.8, 0.0), (3.0, 1.0, 6.0)), beam]))
    shows = lambda boxes, place: cloud_of(boxes, place, FINE)  # noqa: E731
    assert not seen_in_the_open(lambda _: behind, 1.0, 4.0, PERIOD_S, shows)


def test_in_the_open_a_load_that_a_qt64_shows_only_from_near_is_evaded_in_the_second_cloud():
    # Given a load that sinks at 1.8 m/s onto a UAV at 1 m/s: until it is near, no channel is so steep
    steering, answers = Dynamic(), {}
    for number in range(24):
        t = PERIOD_S * number
        place = np.array([t, 0.0, HEIGHT_M])
        load = box(2.66, 0.0, HEIGHT_M + 1.8 * (2.6 - t), 0.8)
        motion = Motion(t, tuple(place.tolist()), LEVEL, (1.0, 0.0, 0.0))
        steering.take_ranges([Ranging((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), math.inf, 0.05, 40.0)])
        shown = cloud_of(load, place)
        decision = steering.steer(NO_SCAN, (1.0, 0.0), (1.0, 0.0), motion, shown)
        if (shown.points_m[:, 2] > 0.15).any():
            answers[t] = decision.reason
    # Then the answer to the second cloud that shows it leaves
    assert list(answers.values())[:2] == [Reason.CUSHION_CLEAR, Reason.MARGIN_LOST]


def test_what_a_cloud_shows_to_come_down_counts_in_the_answer_to_its_own_scan(monkeypatch):
    disc, clouds = np.array([[0.5, 0.0, 0.0, 0.0, 1.5, 0.0, 1.0, 1.0]]), []
    monkeypatch.setattr(Falling, "take_in", lambda self, *_: clouds.append(self))
    monkeypatch.setattr(Falling, "columns", lambda self, *_: disc if len(clouds) > 1 else disc[:0])
    steering, place, far = Dynamic(), np.array([0.0, 0.0, HEIGHT_M]), box(20.0, 0.0, 0.0, 1.0)
    for number in range(2):
        motion = Motion(PERIOD_S * number, tuple(place.tolist()), LEVEL, (0.0, 0.0, 0.0))
        decision = steering.steer(NO_SCAN, (1.0, 0.0), (0.0, 0.0), motion, far.cloud(place))
        assert (decision.reason is Reason.MARGIN_LOST) == (len(clouds) > 1)


def test_a_thing_that_is_nearer_at_once_does_not_fall():
    """A UAV passes a step of 0.1 m in a deck: three clouds show the lower part, and the two before do not."""
    falling, picture = Falling(0.15), CloudPicture()
    for number in range(8):
        place = np.array([0.0, 0.0, HEIGHT_M])
        motion = Motion(PUCK_PERIOD_S * number, tuple(place.tolist()), LEVEL, (0.0, 0.0, 0.0))
        deck = box(1.2, 0.0, HEIGHT_M + (0.8 if number < 5 else 0.7), 0.4)
        points = picture.take_in(cloud_of(deck, place), motion)
        falling.take_in(points, picture.free, PICTURE_ROW_TAN * picture.rows_in_one, motion)
        assert not len(falling.columns(motion))


@pytest.mark.table(("speed", "climb"), [(1.0, 0.0), (0.0, 0.5), (0.0, -0.3)])
def test_what_stands_or_rises_does_not_fall(speed, climb):
    standing = np.concatenate(
        [
            box(6.0, 2.0, 0.0, 0.4, 6.0).corners,  # a pillar
            box(8.0, -2.0, 3.0, 2.0).corners,  # a deck
            np.array([[(12.0, -6.0, 0.0), (12.4, 6.0, 6.0)]]),  # a wall
        ]
    )
    lifted = lambda t: box(3.0, -1.5, 3.0 + 0.5 * t, 1.0).corners  # noqa: E731
    assert found_in(lambda t: Boxes(np.concatenate((standing, lifted(t)))), speed, 5.0, climb) is None


@pytest.mark.table("seed", range(4))
def test_the_rim_of_a_manhole_does_not_fall(seed):
    """A UAV sinks past the lintel of a manhole, drifts before it, and sees its sides edge-on."""
    rng = np.random.default_rng(seed)
    low_y, low_z, plate = rng.uniform(-0.6, 0.2), HEIGHT_M - rng.uniform(0.3, 0.6), (1.5, 1.53)
    high_y, high_z = low_y + 0.6, low_z + 0.8
    corners = [
        ((plate[0], -3.0, 0.0), (plate[1], low_y, 5.0)),
        ((plate[0], high_y, 0.0), (plate[1], 3.0, 5.0)),
        ((plate[0], low_y, 0.0), (plate[1], high_y, low_z)),
        ((plate[0], low_y, high_z), (plate[1], high_y, 5.0)),
        ((6.0, -3.0, 0.0), (6.2, 3.0, 5.0)),
    ]
    room, falling, picture = Boxes(np.array(corners)), Falling(0.05), CloudPicture()
    sinks, begin = rng.uniform(0.1, 0.8), np.array([rng.uniform(0.0, 1.0), 0.5 * (low_y + high_y), high_z])
    begin[2] += rng.uniform(-0.4, 0.4)
    for t in np.arange(0.0, 2.5, PERIOD_S).tolist():
        place = begin + t * np.array((0.1, 0.05, -sinks))
        motion = Motion(t, tuple(place.tolist()), LEVEL, (0.1, 0.05, -sinks))
        points = picture.take_in(cloud_of(room, place), motion)
        points += rng.normal(0.0, 0.01, points.shape)
        falling.take_in(points, picture.free, PICTURE_ROW_TAN * picture.rows_in_one, motion)
        assert not len(falling.columns(motion))


def in_gallery(depths_m: np.ndarray, place: np.ndarray) -> Cloud:
    """Return a cloud in a gallery along x, 3 m wide, of whose sides stones of 0.3 m stand out by depths_m."""
    sideways = np.abs(AROUND[:, 1]) > 0.05
    ranges = 1.5 / np.abs(AROUND[sideways, 1])
    x, _, z = (place + AROUND[sideways] * ranges[:, None]).T
    n = len(depths_m)
    depth_m = depths_m[(x // 0.3).astype(int) % n, (z // 0.3).astype(int) % n]
    ranges *= (1.5 - depth_m) / 1.5
    near = ranges < FAR_M
    return Cloud(AROUND[sideways][near] * ranges[near, None], LIMITS_RAD, 0.1, FAR_M)


@pytest.mark.table("seed", range(1, 5))
def test_the_stones_of_a_gallery_do_not_fall_while_the_uav_sinks(seed):
    depths_m = np.random.default_rng(seed).uniform(0.0, 0.5, (64, 64))
    moves = 1.0, 3.0, -0.3, PUCK_PERIOD_S
    assert found_in(lambda t: depths_m, *moves, cloud_of=in_gallery) is None


@pytest.mark.table(("edge_m", "sinks", "aside_m"), [(0.95, 0.7, 0.1), (0.6, 0.6, 0.2)])
def test_a_uav_leaves_a_load_that_a_puck_sees_late(edge_m, sinks, aside_m):
    """It is over the highest channel until it is some 0.3 m over the UAV, which flies towards it at 1 m/s."""
    steering, place, state = Dynamic(), np.array([0.0, 0.0, HEIGHT_M]), np.zeros((3, 4))
    model, command, clearance_m = steering.parameters.response, np.zeros(3), math.inf
    response, meeting_s, meeting_x = response_of(model, STEP_S), 4.5, 4.0
    for t in np.arange(0.0, 6.5, PUCK_PERIOD_S).tolist():
        load = box(meeting_x, aside_m, max(0.01, HEIGHT_M - sinks * (t - meeting_s)), edge_m)
        motion = Motion(t, tuple(place.tolist()), LEVEL, tuple(state[:, 1].tolist()), HEIGHT_M - place[2])
        decision = steering.steer(NO_SCAN, (1.0, 0.0), tuple(state[:2, 1]), motion, load.cloud(place))
        late, command = command, np.array([*decision.velocity_xy, decision.climb_m_s or 0.0])
        state[:, 0] = 0.0
        commands = np.array([[0.0, 9.0, *late], [model.delay_s, 9.0, *command]])
        fly(state, commands, 0, 2, 0.0, PUCK_PERIOD_S, response)
        place = place + state[:, 0]
        clearance_m = min(clearance_m, load.clearance(place, 0.3, 0.1, 0.05))
    assert clearance_m > 0.0


@pytest.mark.table(("edge_m", "sinks"), [(1.0, 0.5), (2.0, 1.0)])
def test_a_load_that_comes_down_onto_the_way_is_not_flown_under(edge_m, sinks):
    """It would be at the UAV's height, on its way, when a UAV that flies on at 1 m/s is there."""
    steering, place, state = Dynamic(), np.array([0.0, 0.0, HEIGHT_M]), np.zeros((3, 4))
    model, command, clearance_m = steering.parameters.response, np.zeros(3), math.inf
    response, meeting_s, meeting_x = response_of(model, STEP_S), 6.0, 5.5
    for t in np.arange(0.0, 10.0, PERIOD_S).tolist():
        load = box(meeting_x, 0.0, max(0.01, HEIGHT_M - sinks * (t - meeting_s)), edge_m)
        motion = Motion(t, tuple(place.tolist()), LEVEL, tuple(state[:, 1].tolist()), HEIGHT_M - place[2])
        decision = steering.steer(NO_SCAN, (1.0, 0.0), tuple(state[:2, 1]), motion, cloud_of(load, place))
        late, command = command, np.array([*decision.velocity_xy, decision.climb_m_s or 0.0])
        state[:, 0] = 0.0
        commands = np.array([[0.0, 9.0, *late], [model.delay_s, 9.0, *command]])
        fly(state, commands, 0, 2, 0.0, PERIOD_S, response)
        place = place + state[:, 0]
        clearance_m = min(clearance_m, load.clearance(place, 0.35, 0.3, 0.15))
    assert clearance_m > 0.1


@pytest.mark.table("seed", [1, 2])
def test_the_lowest_points_are_those_of_a_slow_search(seed):
    rng = np.random.default_rng(seed)
    points, origin = rng.uniform(-3.0, 3.0, (300, 3)), tuple(rng.uniform(-20.0, 20.0, 3).tolist())
    lowest = np.empty((8 * 8, 3))
    lowest_over(points, origin, (0.2, 2.5), 0.3, 1.5, 0.5, lowest)
    expected, reach_down = np.full((8 * 8, 3), math.inf), set()
    for point in points:
        if max(abs(point[:2])) >= 1.5:
            continue
        x, y, z = point + origin
        cell = int(y // 0.5) % 8 * 8 + int(x // 0.5) % 8
        if 0.2 < point[2] < 2.5 and z < expected[cell, 2]:
            expected[cell] = x, y, z
        if -0.1 < point[2] <= 0.2:
            reach_down.add(cell)
    expected[list(reach_down)] = math.inf
    assert 0 < len(reach_down) < np.isfinite(expected[:, 2]).sum()
    assert np.array_equal(lowest, expected)


def test_a_rate_of_fall_is_that_of_the_line_of_least_squares():
    rng = np.random.default_rng(1)
    times_s, heights_m = np.sort(rng.uniform(5.0, 6.0, 12)), rng.normal(2.0, 0.3, (12, 5))
    heights_m[4, 2] = math.inf
    slopes, residuals = np.empty((2, 5))
    fall_rates(times_s, heights_m, slopes, residuals)
    for k in (0, 1, 3, 4):
        line = np.polyfit(times_s, heights_m[:, k], 1)
        assert slopes[k] == pytest.approx(line[0])
        assert residuals[k] == pytest.approx(
            np.sqrt(np.mean((heights_m[:, k] - np.polyval(line, times_s)) ** 2))
        )
    assert np.isnan([slopes[2], residuals[2]]).all()
