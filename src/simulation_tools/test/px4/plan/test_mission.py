"""Missions in flight: what PX4 makes of a plan, item by item.

What is expected comes from PX4's rules (`Mission` and `MissionBlock` of its navigator), not from this code.
"""

from __future__ import annotations

import copy
import math
from functools import cache

import numpy as np
import pytest
from flight import NO_NOISE, Flight, hovering
from plans import Places, order

from simulation_tools.px4.modes import LandedState, Mode, Result
from simulation_tools.px4.plan.items import Command
from simulation_tools.px4.plan.plan import PlanKind
from simulation_tools.px4.setpoint import Setpoint

NAN = math.nan
START = 300
ACCEPTANCE_M = 2.0  # NAV_ACC_RAD


def on_ground(*items_of, **parameters):
    """A flight on the ground with a plan; `items_of` make each item from the flight's places."""
    flight = Flight.of_iris(noise=NO_NOISE)
    for name, value in parameters.items():
        flight.px4.parameters.set(name, value)
    flight.run(1.0)
    upload(flight, *items_of)
    return flight


def upload(flight, *items_of, chosen=None):
    places = Places(flight)
    items = [item(places) if callable(item) else item for item in items_of]
    flight.px4.plan.replace(PlanKind.MISSION, items, chosen)
    flight.run(0.1)


def takeoff(up=4.0):
    return lambda at: at.item(Command.TAKEOFF, 0, 0, up)


def waypoint(north, east, up=4.0, stay=0.0, radius=0.0, yaw=NAN, **how):
    return lambda at: at.item(Command.WAYPOINT, north, east, up, (stay, radius, 0.0, yaw), **how)


def land(north, east):
    return lambda at: at.item(Command.LAND, north, east)


def start(flight, first=-1):
    assert flight.px4.command(START, (first, *(0.0,) * 6)) is Result.ACCEPTED


def until_current(flight, seq, seconds=30.0):
    assert flight.run(seconds, until=lambda: flight.px4.plan.current == seq), flight.texts


def where(flight):
    """North, east, up."""
    east, north, up = flight.body.position
    return np.array([north, east, up])


PLAN = (
    takeoff(5.0),
    waypoint(20, 0, 5.0),
    order(Command.CHANGE_SPEED, 1, 3.0, -1),
    waypoint(20, 15, 8.0, stay=2.0),
    waypoint(0, 15, 8.0),
    land(0, 5),
)
# Real PX4 (master of July 2021) flew this plan on this body on 2026-11-23. Seconds from MISSION_START until
# an item was current, and until the landing was detected:
MEASURED_S = {1: 8.42, 3: 14.50, 4: 22.72, 5: 30.37}
MEASURED_LANDED_S = 47.29


@cache
def _flown():
    flight = Flight.of_reference_quad(noise=NO_NOISE)
    flight.run(1.0)
    upload(flight, *PLAN)
    start(flight)
    began_s, rows, states = flight.time_s, [], []
    while flight.px4.status.armed and flight.time_s < 80.0:
        flight.run(0.04)
        status = flight.px4.status
        speed = float(np.hypot(*flight.body.velocity[:2]))
        rows.append((flight.time_s - began_s, flight.px4.plan.current, *where(flight), speed))
        states.append((status.landed_state, status.mode))
    return flight, np.array(rows), states


@pytest.fixture
def flown():
    """(flight, rows of time, current item, north, east, up, speed over ground; (landed state, mode) each)."""
    return _flown()


def test_a_plan_is_flown_to_its_end(flown):
    flight, _, _ = flown
    assert not flight.px4.status.armed
    assert where(flight) == pytest.approx((0.0, 5.0, 0.0), abs=0.1)
    assert flight.texts == [
        "Armed by mission start",
        "Takeoff to 5.0 meters above home",
        "Takeoff detected",
        "Landing detected",
        "Mission finished, landed",
        "Disarmed by landing",
    ]


def test_it_takes_as_long_as_px4(flown):
    _, rows, states = flown
    for seq, measured_s in MEASURED_S.items():
        assert rows[rows[:, 1] == seq][0, 0] == pytest.approx(measured_s, abs=0.6)
    in_air = [row for row, (landed, _) in zip(rows, states) if landed is not LandedState.ON_GROUND]
    assert in_air[-1][0] == pytest.approx(MEASURED_LANDED_S, abs=0.8)


def test_an_item_is_left_at_the_acceptance_radius(flown):
    _, rows, _ = flown
    at_change = {int(after[1]): after for before, after in zip(rows, rows[1:]) if after[1] != before[1]}
    assert at_change[1][4] > 5.0 - 0.8  # NAV_MC_ALT_RAD
    assert np.hypot(*(at_change[1][2:4])) < 0.1  # the take-off is vertical
    # Item 2 only changes the speed; it lasts for one of PX4's looks at the mission, 0.05 s.
    assert math.hypot(at_change[3][2] - 20.0, at_change[3][3]) == pytest.approx(ACCEPTANCE_M, abs=0.3)
    assert math.hypot(at_change[5][2], at_change[5][3] - 15.0) == pytest.approx(ACCEPTANCE_M, abs=0.3)


def test_a_speed_item_holds_from_there_on(flown):
    _, rows, _ = flown
    before, after = rows[rows[:, 1] == 1], rows[rows[:, 1] >= 4]
    assert before[:, 5].max() > 4.0  # MPC_XY_CRUISE is 5 m/s
    assert after[:, 5].max() < 3.4


def test_the_landing_site_is_flown_to_before_the_landing(flown):
    _, rows, states = flown
    sinking = next(i for i, (landed, _) in enumerate(states) if landed is LandedState.LANDING)
    assert math.hypot(rows[sinking][2], rows[sinking][3] - 5.0) < ACCEPTANCE_M + 0.3
    assert rows[sinking][4] == pytest.approx(8.0, abs=0.4)


def test_the_landing_begins_without_a_step(flown):
    """PX4 limits the jerk of a mission's landing to MPC_JERK_AUTO: 0.45 m in the first second, measured."""
    _, rows, states = flown
    sinking = next(i for i, (landed, _) in enumerate(states) if landed is LandedState.LANDING)
    assert rows[sinking][4] - rows[sinking + 25][4] == pytest.approx(0.4, abs=0.2)


def test_what_a_ground_station_sees(flown):
    _, _, states = flown
    names = [landed.name for landed, _ in states]
    order = [name for i, name in enumerate(names) if i == 0 or names[i - 1] != name]
    assert order == ["ON_GROUND", "TAKEOFF", "IN_AIR", "LANDING", "ON_GROUND"]
    assert {mode for _, mode in states} == {Mode.AUTO_MISSION}


def test_it_looks_where_it_flies():
    flight = on_ground(takeoff(), waypoint(12, 0), waypoint(12, 12))
    start(flight)
    until_current(flight, 1)
    flight.run(3.5)
    yaw = float(flight.px4.estimate["yaw"][0])
    assert yaw == pytest.approx(0.0, abs=0.1)  # north
    until_current(flight, 2)
    flight.run(3.0)
    gap = np.array([12.0, 12.0]) - where(flight)[:2]
    assert float(flight.px4.estimate["yaw"][0]) == pytest.approx(math.atan2(gap[1], gap[0]), abs=0.2)


def test_a_yaw_and_a_time_at_a_waypoint_are_kept():
    flight = on_ground(takeoff(), waypoint(5, 0, stay=3.0, yaw=180.0), waypoint(5, 5))
    start(flight)
    until_current(flight, 1)
    assert flight.run(20.0, until=lambda: math.hypot(*(where(flight) - (5, 0, 4))[:2]) < ACCEPTANCE_M)
    arrived_s = flight.time_s
    until_current(flight, 2)
    assert flight.time_s - arrived_s > 3.0
    assert abs(float(flight.px4.estimate["yaw"][0])) == pytest.approx(math.pi, abs=math.radians(12.0))


def test_hold_in_the_middle_and_on_again():
    flight = on_ground(takeoff(), waypoint(20, 0), waypoint(20, 10))
    start(flight)
    until_current(flight, 1)
    flight.run(3.0)
    assert flight.px4.request_mode(Mode.AUTO_LOITER) is Result.ACCEPTED  # a ground station's pause
    flight.run(7.0)
    held = where(flight)
    flight.run(2.0)
    assert where(flight) == pytest.approx(held, abs=0.1)
    assert 2.0 < held[0] < 18.0
    assert flight.px4.request_mode(Mode.AUTO_MISSION) is Result.ACCEPTED
    until_current(flight, 2)
    assert where(flight)[0] > 17.0


def test_another_item_may_be_chosen_in_flight():
    flight = on_ground(takeoff(), waypoint(20, 0), waypoint(0, 15))
    start(flight)
    until_current(flight, 1)
    flight.run(2.0)
    assert flight.px4.plan.choose(2)
    assert flight.run(20.0, until=lambda: math.hypot(*(where(flight) - (0, 15, 4))[:2]) < ACCEPTANCE_M)
    flight.run(0.1)
    assert flight.px4.mission.reached == 2
    assert not flight.px4.plan.choose(3)


def test_after_the_last_waypoint_it_holds_there():
    flight = on_ground(takeoff(), waypoint(6, 0))
    start(flight)
    assert flight.run(30.0, until=lambda: "Mission finished, loitering" in flight.texts)
    flight.run(5.0)
    assert where(flight) == pytest.approx((6.0, 0.0, 4.0), abs=0.15)
    assert flight.px4.status.mode is Mode.AUTO_MISSION


def test_return_to_launch_ends_a_mission_at_home():
    flight = on_ground(takeoff(), waypoint(4, 0), order(Command.RETURN_TO_LAUNCH))
    start(flight)
    assert flight.run(40.0, until=lambda: flight.px4.status.mode is Mode.AUTO_RTL)
    flight.run(0.1)
    assert flight.px4.mission.reached == -1
    assert "Returning to launch" in flight.texts
    assert flight.run(60.0, until=lambda: not flight.px4.status.armed)
    assert where(flight) == pytest.approx((0.0, 0.0, 0.0), abs=0.3)
    assert flight.px4.plan.current == 0  # disarmed: from the beginning
    flight.texts.clear()
    start(flight)
    flight.run(0.1)
    assert flight.texts[:2] == ["Armed by mission start", "Executing Mission"]


def test_a_jump_repeats_items():
    flight = on_ground(takeoff(), waypoint(5, 0), waypoint(0, 0), order(Command.JUMP, 1, 1), waypoint(0, 5))
    start(flight)
    visited = []

    def note():
        current = flight.px4.plan.current
        if not visited or visited[-1] != current:
            visited.append(current)
        return current == 4

    assert flight.run(60.0, until=note)
    assert visited == [0, 1, 2, 1, 2, 4]


def test_a_plan_without_takeoff_takes_off_by_itself():
    flight = on_ground(waypoint(5, 0, 3.0))
    start(flight)
    assert flight.run(20.0, until=lambda: where(flight)[2] > 1.5)
    assert math.hypot(*where(flight)[:2]) < 0.1  # upwards first
    assert "Takeoff to 3.0 meters above home" in flight.texts


def test_what_to_look_at():
    flight = on_ground(
        takeoff(),
        lambda at: at.item(Command.SET_ROI_LOCATION, 15, -20),
        waypoint(30, 0),
        order(Command.SET_ROI_NONE),
    )
    start(flight)
    until_current(flight, 2)
    flight.run(5.0)  # 180 degrees at 45 degrees/s
    gap = np.array([15.0, -20.0]) - where(flight)[:2]
    assert float(flight.px4.estimate["yaw"][0]) == pytest.approx(math.atan2(gap[1], gap[0]), abs=0.15)


def test_a_mission_may_begin_in_flight():
    flight = copy.deepcopy(hovering())
    upload(flight, waypoint(8, 0, 4.0))
    assert flight.px4.request_mode(Mode.AUTO_MISSION) is Result.ACCEPTED
    assert flight.run(20.0, until=lambda: where(flight)[2] > 3.1)
    assert where(flight)[0] < 0.2
    assert flight.run(20.0, until=lambda: where(flight)[0] > 6.5)
    # Below the waypoint's height it rises first: it came from OFFBOARD.
    assert "Takeoff to 4.0 meters above home" in flight.texts


# What is refused


def test_without_a_mission_there_is_no_mission_mode():
    flight = on_ground()
    assert flight.px4.request_mode(Mode.AUTO_MISSION) is Result.TEMPORARILY_REJECTED
    assert flight.px4.command(START, (0.0,) * 7) is Result.DENIED
    assert flight.texts[-1] == "Mission start denied! No valid mission"


@pytest.mark.table(
    ("plan", "text"),
    [
        ((waypoint(1000, 0),), "First waypoint too far away: 1000m, 900 max"),
        ((waypoint(500, 0), waypoint(-500, 0)), "Distance between waypoints too far: 1000 meters, 900 max."),
        ((takeoff(2.5),), "Mission rejected: Takeoff altitude too low!"),
        ((land(0, 0),), "Mission rejected: starts with landing"),
        ((takeoff(), order(112, 1.0)), "Mission rejected: item 2: unsupported cmd: 112"),
    ],
)
def test_a_plan_that_cannot_be_flown_is_refused_in_words(plan, text):
    flight = on_ground(*plan)
    assert flight.texts == [text]
    assert flight.px4.request_mode(Mode.AUTO_MISSION) is Result.TEMPORARILY_REJECTED


def test_a_plan_outside_the_fence_is_refused():
    flight = on_ground(takeoff(), waypoint(30, 0), GF_MAX_HOR_DIST=20.0)
    assert flight.texts[-1] == "Geofence violation for waypoint 2"
    assert flight.px4.request_mode(Mode.AUTO_MISSION) is Result.TEMPORARILY_REJECTED


def test_a_takeoff_may_be_required():
    flight = on_ground(waypoint(5, 0), MIS_TAKEOFF_REQ=1)
    assert flight.texts == ["Mission rejected: takeoff waypoint required."]


def test_items_for_a_camera_are_skipped_and_said():
    flight = on_ground(takeoff(), order(206, 5.0), waypoint(5, 0))
    assert flight.texts == ["Mission item 2: no payload here, command 206 ignored"]
    start(flight)
    until_current(flight, 2)


def test_offboard_takes_over_at_any_time():
    flight = on_ground(takeoff(), waypoint(20, 0))
    start(flight)
    until_current(flight, 1)
    flight.run(1.0)
    flight.stream = Setpoint(velocity=(0.0, 0.0, 0.0), yaw_rate=0.0)
    flight.run(0.1)
    assert flight.px4.request_mode(Mode.OFFBOARD) is Result.ACCEPTED
    flight.run(3.0)
    assert np.linalg.norm(flight.body.velocity) < 0.3
