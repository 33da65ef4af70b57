"""What leads an exploration, without a flight."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from voxel_room import PLANNER, Flight, next_places, open_box, room

from exploration.energy import EnergyWatch
from exploration.next_view import (
    End,
    Exploration,
    ExplorationParameters,
    Explorer,
    ExplorerParameters,
)
from exploration.next_view.steps import in_steps
from exploration.next_view.unknown.leftovers import Why
from exploration.planning import OCCUPIED, PathPlanner
from flight_basics.errors import ParameterError

HOVER_M = np.array((1.0, 2.0, 3.0))


def test_without_a_map_it_stays_over_its_home_and_decides_nothing():
    exploration = Exploration(PathPlanner(), Explorer(), ExplorationParameters(first_sink=0.7))
    exploration.begin(0.0, HOVER_M)
    for stamp_s in range(60):
        if exploration.follow(float(stamp_s), HOVER_M):
            exploration.look(float(stamp_s), HOVER_M)
        np.testing.assert_allclose(exploration.setpoint_m, HOVER_M - (0.0, 0.0, 0.7))
    assert exploration.explored.views == 0
    assert exploration.explored.end is None
    assert not exploration.is_home


@pytest.mark.table(("hover_m", "home_m"), [(2.0, 1.3), (1.3, 0.71), (0.5, 0.31)])
def test_home_of_a_low_hover_is_not_in_the_ground(hover_m, home_m):
    # Given a UAV that it saw rise from 0.12 m: home is 0.7 m lower, but not below the middle of the climb
    exploration = Exploration(PathPlanner(), Explorer(), ExplorationParameters(first_sink=0.7))
    for z_m in (0.12, hover_m):
        exploration.follow(0.0, np.array((1.0, 2.0, z_m)))
    exploration.begin(1.0, np.array((1.0, 2.0, hover_m)))
    np.testing.assert_allclose(exploration.home_m, (1.0, 2.0, home_m))


def test_a_uav_that_was_pushed_over_a_limit_flies_back_the_way_it_came_and_goes_on():
    # Given a UAV that flew along x to 4.5 m, where it may not be
    exploration = Exploration(open_box(), Explorer(), ExplorationParameters())
    exploration.begin(0.0, HOVER_M)
    for x in np.arange(1.0, 4.6, 0.25):
        exploration.follow(0.0, np.array((x, 2.0, 2.3)))
    here_m = np.array((4.5, 2.0, 2.3))
    exploration._guide.hover(here_m)
    exploration.explored.views = 1
    # When it decides, then it turns back, and the exploration has not ended
    exploration.look(1.0, here_m)
    assert exploration.explored.end is None
    assert exploration.rest_m[-1][0] == 1.0
    # When it is back, then it goes on
    exploration.look(3.0, np.array((3.0, 2.0, 2.3)))
    assert exploration.explored.end is not End.SHUT_IN
    # When it cannot come back, then that is told in the end
    lost = Exploration(open_box(), Explorer(), ExplorationParameters())
    lost.begin(0.0, here_m)
    lost.explored.views = 1
    for stamp_s in range(1, 60):
        lost.look(float(stamp_s), here_m)
    assert lost.explored.end is End.SHUT_IN
    assert not lost.must_land
    # And when it does not move on its way home, then it must land where it is
    for stamp_s in range(60, 140):
        lost.look(float(stamp_s), here_m)
    assert lost.must_land
    assert not lost.is_home
    assert lost.explored.reason.count("stood still for 60 s") == 1


def test_a_home_too_far_from_all_walls_is_reached_the_way_the_uav_came():
    near = dataclasses.replace(PLANNER, landmark_reach=2.0)
    flight = Flight(room((10.0, 10.0, 2.4)), (5.0, 5.0, 1.2), sees_m=6.0, parameters=near)
    asked = ExplorationParameters(first_sink=0.0)
    exploration = Exploration(flight.planner, Explorer(ExplorerParameters(spacing=0.4, reach=3.0)), asked)
    exploration.begin(0.0, flight.place_m)
    for stamp_s in np.arange(0.0, 300.0, 0.5):
        if exploration.follow(float(stamp_s), flight.place_m):
            exploration.look(float(stamp_s), flight.place_m)
        if exploration.is_home or exploration.must_land:
            break
        away_m = exploration.setpoint_m - flight.place_m
        flight.place_m = flight.place_m + away_m * min(1.0, 0.5 / max(math.hypot(*away_m), 1e-9))
        flight.places_m.append(flight.place_m)
        flight.look()
    assert exploration.explored.end is End.EXPLORED
    assert exploration.is_home
    assert math.dist(flight.place_m, exploration.home_m) < asked.arrived
    assert max(math.dist(place_m, exploration.home_m) for place_m in flight.places_m) > 3.0


def test_a_pause_on_the_way_home_is_no_standstill():
    exploration = Exploration(open_box(), Explorer(), ExplorationParameters(first_sink=0.0))
    far_m = HOVER_M + np.array((2.0, 0.0, 0.0))
    exploration.begin(0.0, HOVER_M)
    exploration.abort("enough")
    exploration.look(1.0, far_m)
    exploration.pause(far_m)
    exploration.look(100.0, far_m)
    exploration.resume()
    exploration.look(101.0, far_m)
    assert not exploration.must_land


def test_a_uav_that_cannot_reach_the_first_place_explores_from_where_it_is():
    exploration = Exploration(open_box(), Explorer(), ExplorationParameters(first_sink=0.7))
    exploration.begin(0.0, HOVER_M)
    exploration.look(5.0, HOVER_M)
    assert exploration.explored.views == 0
    exploration.look(12.0, HOVER_M)
    assert exploration.explored.views == 1


def test_a_lidar_that_sees_only_where_the_uav_hovers_gets_its_time_before_each_decision():
    # Given a lidar that needs 10 s to look around, in a room with more to see
    flight = Flight(room((8.0, 4.6, 2.4), [((3.0, 0.0, 0.0), (3.2, 2.6, 2.4))]), (1.3, 1.3, 1.2))
    explorer = Explorer(ExplorerParameters(spacing=0.4, reach=4.0))
    exploration = Exploration(flight.planner, explorer, ExplorationParameters(first_sink=0.0, sweep=10.0))
    exploration.begin(0.0, flight.place_m)
    hovers_since_s, decided = 0.0, []
    for stamp_s in np.arange(0.0, 200.0, 0.5):
        views = exploration.explored.views
        if exploration.follow(float(stamp_s), flight.place_m):
            exploration.look(float(stamp_s), flight.place_m)
        if exploration.explored.end is not None:
            break
        if exploration.explored.views > views:
            decided.append(stamp_s - hovers_since_s)
        # When the UAV flies, then nothing is decided until it has hovered so long
        away_m = exploration.setpoint_m - flight.place_m
        far_m = math.hypot(*away_m)
        if far_m > 0.0:
            flight.place_m = flight.place_m + away_m * min(1.0, 0.5 / far_m)
            hovers_since_s = stamp_s
        if far_m <= 0.5:
            flight.look()
    assert len(decided) > 2
    assert min(decided) >= 9.5
    # And the way home needs no sweeps
    assert exploration.explored.end is End.EXPLORED
    exploration.look(float(stamp_s) + 0.5, flight.place_m)
    assert exploration.is_home or exploration.rest_m


def test_a_uav_that_is_kept_off_its_way_gives_the_goal_up():
    """CEPA may not let it come nearer. It does not wait for ever, nor does it choose the same place again."""
    exploration = Exploration(open_box(), Explorer(), ExplorationParameters(first_sink=0.0, patience=6.0))
    exploration.begin(0.0, HOVER_M)
    tried = set()
    for stamp_s in np.arange(0.0, 40.0, 0.5):
        if exploration.follow(float(stamp_s), HOVER_M):
            exploration.look(float(stamp_s), HOVER_M)
            tried.add(tuple(exploration.rest_m[-1].round(3)) if exploration.rest_m else None)
    tried -= {tuple(HOVER_M), None}
    assert len(tried) > 2


def test_what_lies_behind_a_door_that_cepa_does_not_fly_is_named_in_the_end():
    wall = [((3.0, 0.0, 0.0), (3.2, 2.0, 2.4)), ((3.0, 3.2, 0.0), (3.2, 4.6, 2.4))]
    flight = Flight(room((6.2, 4.6, 2.4), wall), (1.3, 1.3, 1.2))
    explorer = Explorer(ExplorerParameters(spacing=0.4, reach=8.0))
    asked = ExplorationParameters(first_sink=0.0, patience=4.0)
    exploration = Exploration(flight.planner, explorer, asked)
    exploration.begin(0.0, flight.place_m)
    refusals, was_held = 0, False
    for there_m in next_places(exploration, flight, 0.2):
        # When CEPA lets nothing come to x > 2.8 m, then the UAV stays before the door
        is_held = there_m[0] > 2.8
        refusals += is_held and not was_held
        was_held = is_held
        if not is_held:
            flight.place_m = there_m
            flight.look()
    # Then it tries again, but not for ever, and says why the rest is unknown
    assert exploration.explored.end is End.EXPLORED
    assert refusals >= 2
    exploration.look(900.0, flight.place_m)  # on the way home, which CEPA may hold up for long
    assert exploration.explored.left_m2(Why.REFUSED) > 0.5
    assert "CEPA refused" in exploration.explored.reason


@pytest.mark.table("has_door", [True, False])
def test_a_pane_that_the_lidar_does_not_see_is_pressed_once(has_door):
    """A wall at x = 3 m with a window of 2 x 2 m, whose pane no beam meets, and a door beside it, or none."""
    door = ((3.0, 4.0, 0.0), (3.2, 4.2, 2.4)) if has_door else ((3.0, 4.0, 0.0), (3.2, 6.4, 2.4))
    wall = [
        ((3.0, 0.0, 0.0), (3.2, 0.8, 2.4)),
        ((3.0, 2.8, 0.0), (3.2, 4.0, 2.4)),
        ((3.0, 0.8, 2.2), (3.2, 2.8, 2.4)),
        door,
        ((3.0, 5.8, 0.0), (3.2, 6.4, 2.4)),
    ]
    flight = Flight(room((6.2, 6.4, 2.4), wall), (1.3, 1.8, 1.2))
    asked = ExplorationParameters(first_sink=0.0)
    exploration = Exploration(flight.planner, Explorer(ExplorerParameters(spacing=0.4, reach=4.0)), asked)
    exploration.begin(0.0, flight.place_m)
    pressed, was_pressed = [], False
    for there_m in next_places(exploration, flight, 0.3):
        x, y, _ = there_m
        is_pressed = abs(x - 3.1) < PLANNER.radius and 0.8 < y < 2.8
        if is_pressed and not was_pressed:
            pressed.append(0.0)
        pressed[-1:] = [each + 0.5 for each in pressed[-1:] if is_pressed] or pressed[-1:]
        was_pressed = is_pressed
        if not is_pressed:
            flight.place_m = there_m
            flight.places_m.append(there_m)
            flight.look()
    assert exploration.explored.end is End.EXPLORED
    assert len(pressed) == 1
    assert pressed[0] <= asked.patience + 2.0
    assert (max(place_m[0] for place_m in flight.places_m) > 3.6) == has_door
    exploration.look(900.0, flight.place_m)
    assert "no beam shows" in exploration.explored.reason


def test_on_the_way_home_what_is_closed_is_tried_again_when_there_is_no_other_way():
    wall = [((3.0, 0.0, 0.0), (3.2, 2.0, 2.4)), ((3.0, 3.2, 0.0), (3.2, 4.6, 2.4))]
    flight = Flight(room((6.2, 4.6, 2.4), wall), (1.3, 1.3, 1.2))
    flight.explore(Explorer(ExplorerParameters(spacing=0.4, reach=8.0)))
    flight.fly_to((4.9, 2.6, 1.2))
    exploration = Exploration(flight.planner, Explorer(), ExplorationParameters(first_sink=0.0))
    exploration.begin(0.0, np.array((1.3, 1.3, 1.2)))
    exploration.abort("enough")
    # Given a door that CEPA refused often, on the only way home
    for stamp_s in (0.0, 1.0, 2.0, 3.0):
        flight.planner.close(np.array((3.1, 2.6, 1.2)), stamp_s)
    # When it looks for the way home, then it flies through the door
    exploration.look(4.0, flight.place_m)
    np.testing.assert_allclose(exploration.rest_m[-1], (1.3, 1.3, 1.2))
    assert len(exploration.rest_m) > 1


def coming_home(energy=None):
    """An exploration that was aborted 2 m from home, with a UAV that CEPA lets go nowhere."""
    exploration = Exploration(open_box(), Explorer(), ExplorationParameters(first_sink=0.0), energy)
    exploration.begin(0.0, HOVER_M)
    exploration.abort("enough")
    return exploration, HOVER_M + np.array((2.0, 0.0, 0.0))


def test_on_the_way_home_each_way_gets_its_time_before_it_is_closed(monkeypatch):
    closed_s = []
    monkeypatch.setattr(PathPlanner, "note_held_off", lambda *given: closed_s.append(given[3]))
    exploration, here_m = coming_home()
    for stamp_s in np.arange(0.0, 40.0, 0.5).tolist():
        if exploration.follow(stamp_s, here_m):
            exploration.look(stamp_s, here_m)
    assert 4 <= len(closed_s) <= 6
    assert np.diff(closed_s).min() > 6.0  # the patience


def test_a_uav_that_comes_no_nearer_goes_on_by_short_steps_before_the_way_is_closed():
    exploration, here_m = coming_home()
    steps_m = {}
    for stamp_s in np.arange(0.0, 5.0, 0.5).tolist():
        if exploration.follow(stamp_s, here_m):
            exploration.look(stamp_s, here_m)
        steps_m[stamp_s] = longest_step_m(here_m, exploration.rest_m)
    assert steps_m[1.0] == pytest.approx(2.0)
    assert steps_m[4.5] < 0.61
    np.testing.assert_allclose(exploration.rest_m[-1], HOVER_M)


def test_behind_the_place_where_it_was_held_up_it_flies_fast_again():
    # Given a UAV on its way home that CEPA holds up at first
    goes_on_s = 5.0
    exploration, here_m = coming_home()
    here_m = HOVER_M + np.array((0.0, 3.2, 0.0))
    steps_m = {}
    for stamp_s in np.arange(0.0, goes_on_s + 10.0, 0.5).tolist():
        if exploration.follow(stamp_s, here_m):
            exploration.look(stamp_s, here_m)
        steps_m[stamp_s] = longest_step_m(here_m, exploration.rest_m) if exploration.rest_m else math.nan
        if stamp_s >= goes_on_s:
            here_m = here_m - np.array((0.0, 0.2, 0.0))
        if exploration.is_home:
            break
    # Then it flies by short steps past that place, and not all of the way
    assert steps_m[4.5] < 0.61
    assert steps_m[goes_on_s + 2.0] < 0.6 + 0.3  # it aims at the next place before it is at one
    assert steps_m[goes_on_s + 5.0] > 1.0


@pytest.mark.table(("off_m", "most_m", "least_s"), [(0.0, 0.15, 0.0), (0.4, 0.41, 5.0)])
def test_it_lands_over_its_home_or_where_it_is_held_off_for_some_seconds(off_m, most_m, least_s):
    exploration, here_m = coming_home()
    near_s = None
    for stamp_s in np.arange(0.0, 40.0, 0.5).tolist():
        if exploration.follow(stamp_s, here_m):
            exploration.look(stamp_s, here_m)
        if exploration.is_home:
            break
        way_m = exploration.setpoint_m - here_m
        here_m = here_m + way_m * min(1.0, 0.2 / max(float(np.linalg.norm(way_m)), 1e-9))
        here_m[0] = max(here_m[0], HOVER_M[0] + off_m)
        near_s = stamp_s if near_s is None and math.dist(here_m, HOVER_M) < 0.5 else near_s
    assert exploration.is_home
    assert math.dist(here_m, HOVER_M) < most_m
    assert stamp_s - near_s > least_s


def test_when_a_door_closes_behind_it_the_way_home_is_told_anew_by_the_map_as_it_is():
    # Given a UAV behind a wall at x = 3 m with two doors, 12 m apart, on its way home through the near one
    wall = [((3.0, 0.0, 0.0), (3.2, 0.6, 2.4)), ((3.0, 2.2, 0.0), (3.2, 8.4, 2.4))]
    flight = Flight(room((6.0, 10.0, 2.4), wall), (1.5, 1.4, 1.2))
    flight.explore(Explorer(ExplorerParameters(spacing=0.4, reach=8.0)))
    flight.fly_to((4.5, 1.4, 1.2))
    energy = EnergyWatch()
    exploration = Exploration(flight.planner, Explorer(), ExplorationParameters(first_sink=0.0), energy)
    exploration.begin(0.0, np.array((1.5, 1.4, 1.2)))
    energy.offer(0.0, 1.0)
    exploration.abort("enough")
    exploration.look(0.0, flight.place_m)
    assert exploration.way_home.length_m == pytest.approx(3.0, abs=0.5)
    # When the near door closes, and the lidar sees that
    flight.filled[:, 3:11, 15] = True
    flight.kinds[:, 3:11, 15] = OCCUPIED
    flight.look()
    exploration.look(1.0, flight.place_m)
    # Then the way through the far one is told at once, and in the end
    assert exploration.way_home.length_m > 14.0
    assert "longer" in exploration.explored.reason


def test_for_want_of_energy_it_does_not_fly_home_by_short_steps():
    energy = EnergyWatch()
    exploration, here_m = coming_home(energy)
    exploration.explored.end = None
    energy.offer(0.5, 0.13)
    exploration.look(1.0, here_m)
    assert exploration.explored.end is End.BATTERY
    assert longest_step_m(here_m, exploration.rest_m) > 1.0


def longest_step_m(here_m, rest_m):
    return max(math.dist(a, b) for a, b in zip((here_m, *rest_m), rest_m))


@given(st.lists(st.tuples(*[st.integers(-9, 9)] * 3), min_size=1, max_size=6), st.floats(0.2, 9.0))
def test_a_way_in_steps_leads_through_its_places_on_its_legs(places, step_m):
    places_m = [np.array(place, float) for place in places]
    stepped = in_steps(places_m, step_m)
    np.testing.assert_array_equal(stepped[0], places_m[0])
    np.testing.assert_array_equal(stepped[-1], places_m[-1])
    assert all(math.dist(a, b) <= step_m + 1e-9 for a, b in zip(stepped, stepped[1:]))
    length_m, stepped_m = (sum(math.dist(a, b) for a, b in zip(way, way[1:])) for way in (places_m, stepped))
    assert stepped_m == pytest.approx(length_m)


def test_a_uav_that_is_kept_off_its_home_lands_beside_it():
    exploration = Exploration(open_box(), Explorer(), ExplorationParameters(first_sink=0.0))
    exploration.begin(0.0, HOVER_M)
    beside_m = HOVER_M + np.array((1.0, 0.0, 0.0))
    exploration.abort("enough")
    for stamp_s in np.arange(0.0, 20.0, 0.5):
        assert not exploration.is_home or stamp_s > 6.0
        if exploration.follow(float(stamp_s), beside_m):
            exploration.look(float(stamp_s), beside_m)
    assert exploration.is_home


def test_each_goal_has_its_own_time():
    exploration = Exploration(open_box(), Explorer(), ExplorationParameters(time_max=500.0))
    ends_s = []
    for begin_s, given_s in ((0.0, 20.0), (1000.0, 40.0), (2000.0, None)):
        exploration.begin(begin_s, HOVER_M, time_max_s=given_s)
        exploration.explored.views = 1
        stamp_s = begin_s
        while exploration.explored.end is not End.TIME and stamp_s < begin_s + 100.0:
            stamp_s += 1.0
            exploration.explored.end = None  # it has nothing else to do here
            exploration.look(stamp_s, HOVER_M)
        ends_s.append(stamp_s - begin_s)
    assert ends_s == [21.0, 41.0, 100.0]
    with pytest.raises(ParameterError, match="time_max is nan"):
        exploration.begin(3000.0, HOVER_M, time_max_s=math.nan)
