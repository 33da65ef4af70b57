"""What an exploration does when its map, its battery or its surroundings are not what they should be."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from voxel_room import PLANNER, SIDE_M, TILE, Flight, reachable, room

from exploration.energy import EnergyParameters, EnergyWatch
from exploration.next_view import End, Exploration, ExplorationParameters, Explorer, ExplorerParameters
from exploration.next_view.unknown.leftovers import Why
from exploration.planning import OCCUPIED, UNKNOWN, PathPlanner
from flight_basics.pose.trust import Trust
from flight_limits import parse_limits

HOVER_M = np.array((1.3, 1.3, 1.2))
EXPLORER = ExplorerParameters(spacing=0.4, reach=8.0)
STEP_S, STEP_M = 0.5, 0.4
DOOR = [((3.0, 0.0, 0.0), (3.2, 2.0, 2.4)), ((3.0, 3.2, 0.0), (3.2, 4.6, 2.4))]
SHUT = ((3.0, 2.0, 0.0), (3.2, 3.2, 2.4))
"""What fills the door."""


class Led:
    """A UAV without dynamics that an exploration leads through a true world of voxels.

    CEPA stops it in front of what is filled. may_go: of a place (x, y, z), whether CEPA lets it go there.
    """

    def __init__(self, filled, start_m=HOVER_M, energy=None, limits=None, explorer=EXPLORER, **asked):
        self.flight = Flight(filled, start_m)
        if limits is not None:
            self.flight.planner = PathPlanner(PLANNER, parse_limits(limits))
            self.flight.look()
        given = ExplorationParameters(**{"first_sink": 0.0, "home_speed": 0.8, **asked})
        self.exploration = Exploration(self.flight.planner, Explorer(explorer), given, energy)
        self.exploration.begin(0.0, self.flight.place_m)
        self.now_s, self.energy, self.charge = 0.0, energy, 1.0
        self.may_go = lambda _: True
        self.nearest_m = math.inf

    @property
    def explored(self):
        return self.exploration.explored

    def step(self):
        """Fly on for half a second."""
        self.now_s += STEP_S
        here_m = self.flight.place_m
        if self.energy is not None:
            self.energy.offer(self.now_s, self.charge)
        if self.exploration.follow(self.now_s, here_m):
            self.exploration.look(self.now_s, here_m)
        setpoint_m = self.exploration.setpoint_m
        way_m = np.zeros(3) if setpoint_m is None else setpoint_m - here_m
        there_m = here_m + way_m * min(1.0, STEP_M / max(math.hypot(*way_m), 1e-9))
        if self.may_go(there_m) and self.is_free(here_m, there_m):
            self.flight.place_m = there_m
        self.flight.look()

    def is_free(self, here_m, there_m):
        places = np.linspace(here_m, there_m, 9) / SIDE_M
        return not self.flight.filled[tuple(places.astype(int)[:, ::-1].T)].any()

    def fly(self, until, seconds=400.0):
        """Fly until something is true."""
        end_s = self.now_s + seconds
        while not until():
            assert self.now_s < end_s, f"not within {seconds} s: {self.explored.end}, {self.explored.reason}"
            self.step()

    def fly_home(self):
        """Fly until it lands, somewhere."""
        self.fly(lambda: self.exploration.is_home or self.exploration.must_land)


def fill(led, box, is_filled=True):
    low, high = (np.round(np.array(corner[::-1]) / SIDE_M).astype(int) for corner in box)
    led.flight.filled[low[0] : high[0], low[1] : high[1], low[2] : high[2]] = is_filled
    part = led.flight.kinds[low[0] : high[0], low[1] : high[1], low[2] : high[2]]
    part[part == OCCUPIED] = OCCUPIED if is_filled else UNKNOWN


# the map


@pytest.mark.table("why", ["battery", "time", "aborted"])
def test_over_an_empty_map_it_comes_down_for_want_of_energy_or_time_or_when_it_is_told_to(why):
    energy = EnergyWatch(EnergyParameters())
    exploration = Exploration(PathPlanner(), Explorer(), ExplorationParameters(time_max=100.0), energy)
    exploration.begin(0.0, HOVER_M)
    for stamp_s in np.arange(0.5, 200.0, 0.5).tolist():
        energy.offer(stamp_s, 0.1 if why == "battery" and stamp_s > 20.0 else 0.9)
        if why == "aborted" and stamp_s > 20.0:
            exploration.abort("It was aborted.")
        if exploration.follow(stamp_s, HOVER_M):
            exploration.look(stamp_s, HOVER_M)
        assert exploration.explored.views == 0
        if exploration.is_home:
            break
    assert exploration.explored.end is End(why)
    assert exploration.is_home
    assert exploration.explored.reason


@pytest.mark.parametrize(
    "jump_m",
    [
        (1.6, 0.8, 0.0),
        pytest.param((0.4, -0.2, 0.0), marks=pytest.mark.long),
        pytest.param((-0.8, 2.4, 0.0), marks=pytest.mark.long),
    ],
)
def test_after_the_map_and_the_uav_in_it_jumped_it_explores_on_and_lands(jump_m):
    # Given a UAV that has seen half of two rooms; the map jumps by metres, as SLAM closes a loop
    led = Led(shifted_room((0, 0, 0)), HOVER_M + np.array((1.6, 1.6, 0.0)))
    led.fly(lambda: led.explored.views > 2)
    voxels = np.round(np.array(jump_m) / SIDE_M).astype(int)
    led.flight.filled = shifted_room(voxels)
    led.flight.kinds = np.roll(led.flight.kinds, voxels[::-1], (0, 1, 2))
    led.flight.place_m = led.flight.place_m + voxels * SIDE_M
    led.flight.look()
    # When it goes on, then it never flies into what is filled, knows both rooms in the end, and lands
    led.fly(lambda: led.explored.end is not None)
    assert led.explored.end is End.EXPLORED
    assert (led.flight.kinds[~led.flight.filled] != UNKNOWN).mean() > 0.98
    led.fly_home()


def shifted_room(voxels):
    """Two rooms with a door, farther from the edge of the grid, moved by voxels (x, y, z)."""
    filled = np.ones((TILE, TILE, TILE), bool)
    inner = room((6.2, 4.6, 2.4), DOOR)[:12, :23, :31]
    filled[:12, 8:31, 8:39] = inner
    return np.roll(filled, np.array(voxels)[::-1], (0, 1, 2))


# the ends of its ways


def test_a_uav_in_an_obstacle_says_so_and_lands_where_it_is_home():
    led = Led(room((5.0, 4.0, 2.4)))
    x, y, z = (HOVER_M / SIDE_M).astype(int)
    led.flight.kinds[z - 1 : z + 2, y - 1 : y + 2, x - 1 : x + 2] = OCCUPIED
    led.flight.planner.update_map(SIDE_M, TILE, np.zeros((1, 3), int), led.flight.kinds.reshape(1, -1))
    led.flight.look = lambda: None
    led.fly_home()
    assert led.explored.end is End.SHUT_IN
    assert "is in an obstacle" in led.explored.reason
    assert led.exploration.is_home


def test_a_keep_out_box_around_the_uav_is_named_and_it_lands_where_it_is_home():
    box = {"name": "hatch", "low": [0.5, 0.5, 0.5], "high": [2.0, 2.0, 2.0]}
    led = Led(room((5.0, 4.0, 2.4)), limits={"keep_out": [box]})
    led.fly_home()
    assert led.explored.end is End.SHUT_IN
    assert "is in the keep-out box hatch" in led.explored.reason
    assert led.exploration.is_home


def test_what_lies_behind_glass_is_seen_but_not_reached_and_named():
    # Given a pane in the door that no beam tells, so that the map shows a way through it
    led = Led(room((6.2, 4.6, 2.4), DOOR), patience=4.0)
    led.may_go = lambda place_m: place_m[0] < 2.7
    led.fly(lambda: led.explored.end is not None)
    assert led.explored.end is End.EXPLORED
    led.fly_home()
    assert led.exploration.is_home
    assert sum(left.area_m2 for left in led.explored.leftovers if left.place_m[0] > 2.7) > 0.3
    assert "no beam shows" in led.explored.reason


def test_a_door_that_closes_behind_it_strands_it_and_the_sentence_says_what_blocks_the_way():
    led = Led(room((6.2, 4.6, 2.4), DOOR), stranded=20.0)
    led.fly(lambda: led.flight.place_m[0] > 4.0)
    fill(led, SHUT)
    led.fly_home()
    assert led.exploration.must_land
    assert led.explored.end is End.CUT_OFF
    assert led.flight.place_m[0] > 3.2
    assert "stood still for 20 s" in led.explored.reason
    assert "(1.3, 1.3, 1.2)" in led.explored.reason  # the planner's sentence: no way leads home


def test_a_battery_that_gets_empty_on_the_way_home_ends_as_battery():
    # Given a UAV that has explored, and flies home
    led = Led(room((5.0, 4.0, 2.4)), energy=EnergyWatch(EnergyParameters(endurance=1e4)))
    led.fly(lambda: led.explored.end is not None)
    assert led.explored.end is End.EXPLORED
    # When its battery is nearly empty, told twice, then it lands, and says so
    led.charge = 0.04
    led.fly(lambda: led.exploration.must_land, seconds=20.0)
    assert led.explored.end is End.BATTERY
    assert re.search(r"The battery is at [0-4]%: land here\.$", led.explored.reason)


def test_a_door_that_opens_again_lets_it_home():
    led = Led(room((6.2, 4.6, 2.4), DOOR))
    led.fly(lambda: led.flight.place_m[0] > 4.0)
    fill(led, SHUT)
    led.exploration.abort("It was aborted.")
    for _ in range(40):
        led.step()
    assert led.flight.place_m[0] > 3.2
    fill(led, SHUT, is_filled=False)
    led.fly_home()
    assert led.exploration.is_home


@pytest.mark.parametrize("view_choice", ["border", pytest.param("volume", marks=pytest.mark.long)])
def test_a_person_who_follows_it_holds_it_up_for_a_while_only(view_choice):
    # Given somebody a metre behind the UAV, wherever it flies
    explorer = replace(EXPLORER, view_choice=view_choice)
    led = Led(room((6.2, 4.6, 2.4), DOOR), explorer=explorer, patience=4.0)
    trail, person = [], [None]

    def follow():
        trail.append(led.flight.place_m.copy())
        behind = [place for place in trail if math.dist(place, led.flight.place_m) > 1.0]
        if person[0] is not None:
            fill(led, person[0], is_filled=False)
            person[0] = None
        if behind:
            x, y, _ = behind[-1]
            box = ((x - 0.2, y - 0.2, 0.2), (x + 0.2, y + 0.2, 1.8))
            was = led.flight.filled.copy()
            fill(led, box)
            if (was & led.flight.filled).sum() == was.sum() and not was[led.flight.filled & ~was].any():
                person[0] = box

    def flown():
        follow()
        return led.exploration.is_home or led.exploration.must_land

    led.fly(flown)
    assert led.explored.end is not None
    # Then it knows both rooms, and is home, or has landed with a sentence
    assert (led.flight.kinds[1:11, 1:22, 17:30] != UNKNOWN).mean() > 0.9
    assert led.exploration.is_home or "stood still" in led.explored.reason


@settings(max_examples=settings.default.max_examples // 10)
@given(st.integers(0, 2**32 - 1))
def test_it_tells_explored_only_when_a_flood_fill_finds_nothing_or_cepa_refused(seed):
    """CEPA holds the UAV now and then, for up to 15 s. The end must be true all the same."""
    rng = np.random.default_rng(seed)
    door, half = rng.uniform(0.6, 2.6), rng.uniform(0.6, 0.9)
    wall = [((3.4, 0.0, 0.0), (3.6, door, 2.4)), ((3.4, door + 2 * half, 0.0), (3.6, 4.6, 2.4))]
    box_m = rng.uniform((4.4, 0.4, 0.4, 0.4, 0.4), (6.0, 3.6, 1.0, 1.0, 2.4))
    box = ((*box_m[:2], 0.0), (*(box_m[:2] + box_m[2:4]), box_m[4]))
    led = Led(room((7.4, 4.6, 2.4), [*wall, box]), patience=4.0)
    held_until_s = 0.0

    def may_go(_):
        nonlocal held_until_s
        if led.now_s >= held_until_s and rng.random() < 0.03:
            held_until_s = led.now_s + rng.uniform(0.0, 15.0)
        return led.now_s >= held_until_s

    led.may_go = may_go
    led.fly(lambda: led.explored.end is not None, seconds=1500.0)
    assert led.explored.end is End.EXPLORED
    unknown = reachable(led.flight) & (led.flight.kinds == UNKNOWN)
    led.fly_home()
    assert led.exploration.is_home
    assert not unknown.any() or led.explored.left_m2(Why.REFUSED) > 0.0


# the pose


@pytest.mark.table("end", [End.EXPLORED, End.ABORTED])
def test_a_uav_that_is_lost_hovers_until_it_is_found_or_comes_home(end):
    led = Led(room((6.2, 4.6, 2.4), DOOR))
    led.fly(lambda: led.flight.place_m[0] > 4.0)
    here_m, views = led.flight.place_m, led.explored.views
    led.exploration.trust(Trust.HOVER, "SLAM is lost.", here_m)
    for _ in range(20):
        led.step()
    assert led.exploration.is_in_doubt
    assert math.dist(led.flight.place_m, here_m) < STEP_M
    assert led.explored.views == views
    last = Trust.SURE if end is End.EXPLORED else Trust.COME_HOME
    led.exploration.trust(last, "SLAM is lost.", led.flight.place_m)
    led.fly_home()
    assert led.explored.end is end
    assert led.exploration.is_home


def test_a_uav_that_is_lost_minds_its_battery():
    energy = EnergyWatch()
    led = Led(room((6.2, 4.6, 2.4), DOOR), energy=energy)
    led.charge = 0.9
    led.fly(lambda: led.flight.place_m[0] > 4.0)
    led.exploration.trust(Trust.HOVER, "SLAM is lost.", led.flight.place_m)
    led.charge = 0.15
    led.fly_home()
    assert (led.explored.end, led.exploration.is_home) == (End.BATTERY, True)


# the battery


def test_a_battery_that_stops_brings_it_home_with_a_sentence():
    led = Led(room((6.2, 4.6, 2.4), DOOR), energy=EnergyWatch())
    led.fly(lambda: led.flight.place_m[0] > 4.0)
    led.energy.offer = lambda *_: ""  # nothing comes any more
    led.fly_home()
    assert led.explored.end is End.BATTERY
    assert "told nothing to believe" in led.explored.reason
    assert led.exploration.is_home


@pytest.mark.table(("reading", "end"), [(math.nan, End.BATTERY), (1.0, End.EXPLORED)])
def test_nan_counts_as_silence_and_a_charge_that_jumps_up_does_not_count(reading, end):
    energy = EnergyWatch()
    led = Led(room((6.2, 4.6, 2.4), DOOR), energy=energy)
    led.charge = 0.9
    led.fly(lambda: led.flight.place_m[0] > 4.0)
    led.charge = reading
    assert energy.offer(led.now_s, reading)
    led.fly_home()
    assert led.explored.end is end or (end is End.EXPLORED and led.explored.end is End.BATTERY)
    assert led.exploration.is_home


def test_what_the_time_did_not_suffice_for_is_told_with_this_reason():
    """A room behind a door, and a flight that turns home before it has looked through."""
    led = Led(room((6.4, 4.6, 2.4), DOOR), time_max=4.0)
    for _ in range(200):
        led.step()
        if led.exploration.is_home:
            break
    assert (led.explored.end, led.exploration.is_home) == (End.TIME, True)
    assert led.explored.left_m2(Why.NOT_YET) > 1.0
