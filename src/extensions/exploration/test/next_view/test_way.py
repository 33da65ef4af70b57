"""The way of an exploring UAV: at which place it aims."""

import math

import numpy as np
import pytest
from drawn_legs import of_legs

from exploration.next_view.way import Progress, Way

CORNER_M = np.array((2.0, 0.0, 1.0))
PLACES_M = [CORNER_M, np.array((2.0, 2.0, 1.0))]
"""From (0, 0, 1) along x, then along y."""


def flown(way, start_m, step_m=0.1, lag=1.0):
    """Places of a UAV that goes straight to each aim, and how far each aim was, until it arrives."""
    here_m, track_m, aims_m = np.array(start_m), [], []
    for step in range(400):
        way.follow(0.1 * step, here_m, 0.15)
        if not way.is_left:
            return np.array(track_m), aims_m
        away_m = way.setpoint_m - here_m
        far_m = math.hypot(*away_m)
        aims_m.append(far_m)
        here_m = here_m + away_m * min(1.0, step_m / far_m)
        track_m.append(here_m)
    raise AssertionError("it does not arrive")


def outside_the_corner(a_m, b_m):
    """Nothing may be nearer to the inside of the bend than the way itself: x + 0.05 < y is a wall."""
    shares = np.linspace(0.0, 1.0, 50)[:, None]
    points = a_m + shares * (b_m - a_m)
    return bool(((points[:, 0] > 1.9) | (points[:, 1] < 0.1)).all())


@of_legs
def no_wall(a_m, b_m):
    return math.dist(a_m, b_m)


@of_legs
def a_wall(a_m, b_m):
    return math.dist(a_m, b_m) if outside_the_corner(a_m, b_m) else math.inf


@of_legs
def less_room(a_m, b_m):
    """No wall, but what `outside_the_corner` forbids costs three times its length."""
    return math.dist(a_m, b_m) * (1.0 if outside_the_corner(a_m, b_m) else 3.0)


def test_without_sight_ahead_each_place_is_flown_to_in_turn():
    way = Way(PLACES_M)
    assert way.setpoint_m is CORNER_M
    track_m, _ = flown(way, (0.0, 0.0, 1.0))
    assert np.linalg.norm(track_m - CORNER_M, axis=1).min() < 0.15
    np.testing.assert_allclose(way.setpoint_m, PLACES_M[-1])


def test_in_the_open_a_corner_is_cut_and_the_aim_stays_ahead():
    way = Way(PLACES_M, no_wall, 1.0)
    track_m, aims_m = flown(way, (0.0, 0.0, 1.0))
    assert np.linalg.norm(track_m - CORNER_M, axis=1).min() > 0.3
    length_m = np.linalg.norm(np.diff(track_m, axis=0), axis=1).sum()
    assert length_m < 3.8
    # Only at the end the aim comes near
    assert min(aims_m[:-12]) > 0.7


@pytest.mark.table("cost_m", [a_wall, less_room])
def test_a_corner_with_something_inside_is_not_cut(cost_m):
    way = Way(PLACES_M, cost_m, 1.0)
    track_m, _ = flown(way, (0.0, 0.0, 1.0))
    for a_m, b_m in zip(track_m, track_m[1:]):
        assert outside_the_corner(a_m, b_m)
    np.testing.assert_allclose(track_m[-1], PLACES_M[-1], atol=0.15)


@of_legs
def a_manhole(a_m, b_m):
    """From x = 2.6 to 3.4 there is little room: a leg seems thrice as long, beside the middle longer."""
    shares = np.linspace(0.0, 1.0, 200)[:, None]
    points = a_m + shares * (b_m - a_m)
    aside = np.round(np.abs(points[:, 1:] - (0.0, 1.0)).max(axis=1) / 0.1)
    dearer = (np.abs(points[:, 0] - 3.0) < 0.4) * (2.0 + aside)
    return math.dist(a_m, b_m) * (1.0 + float(dearer.mean()))


@pytest.mark.table("corners_x_m", [(1.0, 6.0), (6.0,), (3.4, 6.0)])
def test_it_enters_a_narrow_part_slowly_and_so_in_its_middle(corners_x_m):
    aims_m, here_m = [], np.array((0.0, 0.0, 1.0))
    way = Way([np.array((x, 0.0, 1.0)) for x in corners_x_m], a_manhole, 2.0, begin_m=here_m)
    while way.is_left:
        way.follow(0.1 * len(aims_m), here_m, 0.15)
        aims_m.append((here_m[0], way.setpoint_m[0]))
        here_m = here_m + 0.1 * (way.setpoint_m - here_m) / max(math.dist(way.setpoint_m, here_m), 0.1)
    # Then it aims before the narrow part until it is there, then behind it, and only then far ahead again
    assert 2.0 < max(aim for x, aim in aims_m if x < 2.0) < 2.6
    assert 3.4 < max(aim for x, aim in aims_m if 2.6 < x < 3.2) < 4.2
    assert max(aim - x for x, aim in aims_m if x > 4.0) > 1.0


@pytest.mark.table(
    ("aside_m", "speed_m_s", "lead_m"),
    [
        (0.0, 0.0, 0.5),
        (0.03, 0.0, 0.35),
        (0.08, 0.0, 0.1),
        (0.0, 0.3, 0.0),
        (-0.04, 0.2, 0.3),
        (0.3, 0.0, 0.0),
    ],
)
def test_in_a_narrow_part_it_goes_on_only_in_the_middle_and_if_it_stays_there(aside_m, speed_m_s, lead_m):
    way = Way([np.array((6.0, 0.0, 1.0))], a_manhole, 2.0, begin_m=np.array((0.0, 0.0, 1.0)))
    for stamp_s in np.arange(0.0, 1.5, 0.02):
        way.follow(stamp_s, np.array((1.6 * stamp_s, 0.0, 1.0)), 0.15)
    inside_m = np.array((2.5, aside_m, 1.0))
    for stamp_s in (1.98, 2.0):
        way.follow(stamp_s, inside_m + np.array((0.0, speed_m_s * (stamp_s - 2.0), 0.0)), 0.15)
    np.testing.assert_allclose(way.setpoint_m, (2.5 + lead_m, 0.0, 1.0), atol=1e-9)


def test_a_way_that_begins_in_a_narrow_part_keeps_to_its_middle_at_once():
    begin_m = np.array((3.0, 0.0, 1.0))
    way = Way([np.array((6.0, 0.0, 1.0))], a_manhole, 2.0, begin_m=begin_m)
    for stamp_s in (0.0, 0.02):
        way.follow(stamp_s, begin_m + np.array((0.0, 4.0 * stamp_s, 0.0)), 0.15)
    np.testing.assert_allclose(way.setpoint_m, begin_m, atol=1e-9)  # it is carried aside at 4 m/s


SILL_M = np.array((3.0, 0.0, 0.5))


def under_a_lintel(a_m, b_m):
    """What is at x = 1.5 is open below a height of 1 m only."""
    shares = np.linspace(0.0, 1.0, 50)[:, None]
    points = a_m + shares * (b_m - a_m)
    beyond = np.abs(points[:, 0] - 1.5) < 0.2
    return math.dist(a_m, b_m) if (points[beyond, 2] < 1.0).all() else math.inf


@pytest.mark.table("climbs_first", [True, False])
def test_before_an_opening_at_another_height_it_climbs_or_sinks_first_if_it_shall(climbs_first):
    begin_m = np.array((0.5, 0.0, 1.2))
    assert under_a_lintel(begin_m, SILL_M) < math.inf  # straight down through the opening
    way = Way([SILL_M], under_a_lintel, 5.0, climbs_first)
    track_m, _ = flown(way, begin_m)
    high = track_m[track_m[:, 2] > 1.0]
    assert (np.ptp(high[:, 0]) < 1e-9) == climbs_first
    np.testing.assert_allclose(track_m[-1], SILL_M, atol=0.15)
    # In the open it flies straight
    straight_m, _ = flown(Way([SILL_M], no_wall, 5.0, climbs_first), begin_m)
    assert len(straight_m) == math.ceil((math.dist(begin_m, SILL_M) - 0.15) / 0.1)


def test_the_rest_begins_with_the_aim_and_ends_with_the_goal():
    way = Way(PLACES_M, no_wall, 1.0)
    way.follow(0.0, np.array((1.5, 0.0, 1.0)), 0.15)
    rest_m = way.rest_m
    assert len(rest_m) == 2
    assert rest_m[0] is way.setpoint_m
    assert rest_m[0][1] == pytest.approx(0.75)
    np.testing.assert_allclose(rest_m[-1], PLACES_M[-1])


def test_an_empty_way_has_no_aim():
    way = Way()
    way.follow(0.0, np.zeros(3), 0.3)
    assert not way.is_left
    assert way.setpoint_m is None
    assert way.rest_m == []


@pytest.mark.table(("goes_round", "is_held_off"), [(True, False), (False, True)])
def test_a_uav_whose_way_gets_longer_makes_progress_if_it_flies(goes_round, is_held_off):
    """It flies 5 m of 10 m. Then a hatch closes, and the way round is 30 m; it flies that, or it stays."""
    progress, end_m, round_m = Progress(), np.array((10.0, 0.0, 1.0)), np.array((5.0, 15.0, 1.0))
    for stamp_s in np.arange(0.0, 5.0, 0.1):
        here_m = np.array((stamp_s, 0.0, 1.0))
        progress.note(stamp_s, here_m, [end_m])
    for stamp_s in np.arange(5.0, 15.0, 0.1):
        here_m = np.array((5.0, stamp_s - 5.0 if goes_round else 0.0, 1.0))
        progress.note(stamp_s, here_m, [round_m, end_m])
    assert progress.is_held_off(15.0, 6.0) == is_held_off
