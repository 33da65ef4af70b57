"""The course of a run: phases, time-outs, collisions, and the outcome's sentences."""

import pytest

from flights.flight.course import Action, Course, Phase, PhaseLimits
from flights.flight.flight_log import POSE_COLUMNS, Series
from flights.flight.judging.contacts import UavParts

TREE, GROUND, UAV = "tree_007::link::trunk", "ground_plane::link::floor", "iris::base_link::body"

IRIS = UavParts("iris", frozenset(("rotor_0", "rotor_1")))


def at_rest():
    """True poses of a UAV that stands upright all the time: nothing is wrong with its landings."""
    truth = Series(POSE_COLUMNS)
    for step in range(1000):
        truth.add(0.1 * step, 0.0, 0.0, 0.12, 0.0, 0.0, 0.0, 1.0)
    return truth


@pytest.fixture
def run():
    limits = PhaseLimits(2.0, ready_timeout_s=30.0, flight_timeout_s=60.0, landing_timeout_s=20.0)
    course = Course(limits, IRIS, at_rest())
    course.on_time(0.0)
    return course


def fly(run):
    """Bring it to the goal at t = 30 s."""
    run.on_ready(True)
    assert run.on_time(10.0) == [Action.SEND_GOAL]
    run.on_goal_reached(30.0, True)


def test_the_course_of_a_successful_run(run):
    # Given a run that waits, nothing is asked for until the UAV is ready
    assert run.on_time(5.0) == []
    # When it hovers, the goal is sent, once
    run.on_ready(True)
    assert run.on_time(10.0) == [Action.SEND_GOAL]
    assert run.on_time(10.1) == []
    # When it is there, it hovers for two seconds and is then told to land, once
    run.on_goal_reached(30.0, True)
    assert run.on_time(31.9) == []
    assert run.on_time(32.0) == [Action.LAND]
    assert run.on_time(33.0) == []
    # When it disarms, the run is over
    assert run.on_armed(33.0, True) == []
    assert run.on_armed(38.0, False) == [Action.FINISH]
    outcome = run.outcome
    assert outcome.success
    assert outcome.times_s == {
        Phase.WAITING: 0.0,
        Phase.FLYING: 10.0,
        Phase.HOVERING: 30.0,
        Phase.LANDING: 32.0,
        Phase.DONE: 38.0,
    }


def test_a_goal_reached_before_it_was_sent_does_not_count(run):
    run.on_goal_reached(1.0, True)
    assert not run.outcome.reached_goal
    assert run.phase is Phase.WAITING


def test_a_uav_that_must_land_where_it_is_lands_and_the_run_fails(run):
    run.on_ready(True)
    run.on_time(10.0)
    run.land_here("The UAV did not come home: it is shut in.")
    assert run.on_time(20.0) == [Action.LAND]
    assert run.on_time(20.1) == []
    assert run.on_armed(25.0, False) == [Action.FINISH]
    assert not run.outcome.success
    assert run.outcome.landed
    assert run.outcome.failure == "The UAV did not come home: it is shut in."


def test_leaving_the_goal_again_does_not_unreach_it(run):
    fly(run)
    run.on_goal_reached(30.5, False)
    assert run.outcome.reached_goal


def test_a_uav_that_never_gets_ready_ends_the_run(run):
    assert run.on_time(29.9) == []
    assert run.on_time(30.0) == [Action.FINISH]
    assert run.outcome.failure == "Still waiting for the hover after 30 s."
    assert not run.outcome.success


def test_why_the_uav_does_not_hover_is_said_if_it_is_known(run):
    run.on_waiting("no home position yet")
    run.on_time(0.0)
    assert run.on_time(30.0) == [Action.FINISH]
    assert run.outcome.failure == "Still waiting for the hover after 30 s: no home position yet."


def test_what_a_flight_waits_for_in_vain_is_said_by_name():
    run = Course(PhaseLimits(ready_timeout_s=30.0), IRIS, at_rest())
    run.on_ready(False, awaited="SLAM")
    run.on_time(0.0)
    assert run.on_time(30.0) == [Action.FINISH]
    assert run.outcome.failure == "Still waiting for SLAM after 30 s."


def test_a_flight_that_ends_before_its_goal_says_how_far_away_it_was(run):
    run.on_ready(True)
    run.on_time(10.0)
    run.on_distance(12.34)
    run.on_time(70.0)
    assert run.outcome.failure == "Still flying to the goal after 60 s, 12.3 m from it."


def test_a_uav_that_is_stuck_lands_and_ends(run):
    run.on_ready(True)
    run.on_time(10.0)
    assert run.on_time(70.0) == [Action.LAND]
    assert run.on_armed(75.0, False) == [Action.FINISH]
    outcome = run.outcome
    assert outcome.failure == "Still flying to the goal after 60 s."
    assert outcome.landed
    assert not outcome.reached_goal
    assert not outcome.success


def test_a_landing_that_does_not_end_ends_the_run(run):
    fly(run)
    run.on_time(32.0)
    assert run.on_time(52.0) == [Action.FINISH]
    assert run.outcome.failure == "Still landing after 20 s."


def test_an_obstacle_is_named_once_whichever_side_it_stands_on(run):
    run.on_contact(0.0, TREE, UAV)
    run.on_contact(0.0, UAV, TREE)
    assert run.outcome.touched == (TREE,)
    assert run.outcome.collision
    assert run.outcome.failure == f"The UAV touched {TREE}."


def test_a_landing_for_another_battery_is_no_contact_but_a_tree_is(run):
    run.on_ready(True)
    run.on_time(1.0)
    run.land_between(2.0)
    run.on_contact(0.0, UAV, "ground_plane::link::c", 1.0)
    assert not run.outcome.collision
    run.on_contact(0.0, UAV, TREE, 1.0)  # also one that it stands on: it did not begin there
    assert run.outcome.touched == (TREE,)
    run.fly_on(9.0)
    assert run.outcome.between_s == ((2.0, 9.0),)
    run.on_contact(0.0, UAV, "ground_plane::link::c", 1.0)
    assert run.outcome.touched == (TREE, "ground_plane::link::c")


def test_a_uav_that_has_landed_between_may_stay_on_the_ground(run):
    run.on_ready(True)
    run.on_time(1.0)
    run.land_between(2.0)
    assert run.on_armed(9.0, False) == []
    assert run.stay_landed(20.0) == [Action.FINISH]
    assert run.outcome.success
    assert run.phase is Phase.DONE


FLOOR, SHELF = "floor::link::c", "shelf::link::board"


@pytest.mark.parametrize("contact", [(UAV, FLOOR, 1.0), (FLOOR, UAV, -1.0)])
def test_the_ground_is_what_carries_the_uav_whatever_its_name(run, contact):
    # Given a floor on which the UAV stands, and which a leg scrapes while it takes off
    run.on_contact(0.0, *contact)
    run.on_contact(0.0, "iris::base_link::leg", FLOOR, 0.1)
    fly(run)
    run.on_time(32.0)
    # When it lands on something else
    run.on_contact(0.0, UAV, SHELF, 0.8)
    # Then both are ground, and no collision
    assert not run.outcome.collision
    assert run.outcome.ground == ("ground_plane", "floor", "shelf")


def test_what_is_touched_sideways_or_from_below_is_no_ground(run):
    run.on_contact(0.0, UAV, GROUND)  # by its name it is
    run.on_contact(0.0, UAV, TREE, 0.0)
    run.on_contact(0.0, UAV, SHELF, -1.0)  # a board over its head
    assert run.outcome.touched == (TREE, SHELF)
    assert run.outcome.ground == ("ground_plane",)


@pytest.mark.parametrize("pair", [(UAV, GROUND), (GROUND, UAV), (UAV, FLOOR)])
def test_the_ground_is_an_obstacle_in_flight(run, pair):
    run.on_contact(0.0, *pair, 1.0 if pair[0] is UAV else -1.0)
    run.on_ready(True)
    run.on_time(10.0)
    run.on_contact(0.0, *pair)
    assert run.outcome.touched == (pair[pair[0] is UAV],)


def test_disarming_in_flight_is_a_failure(run):
    run.on_ready(True)
    run.on_time(10.0)
    assert run.on_armed(15.0, False) == [Action.FINISH]
    assert run.outcome.failure == "The flight controller disarmed while flying to the goal, at 15.0 s."


def test_being_disarmed_before_the_flight_is_how_every_run_starts(run):
    assert run.on_armed(0.5, False) == []
    assert run.phase is Phase.WAITING


def test_an_interruption_ends_the_run_with_its_sentence(run):
    assert run.abort(3.0, "Interrupted by the user.") == [Action.FINISH]
    assert run.abort(3.1, "Something else.") == []
    assert run.outcome.failure == "Interrupted by the user."
    assert not run.outcome.reached_goal


@pytest.mark.table(
    ("way_m", "speed_m_s", "expected_s"),
    [(40.0, 2.0, 120.0), (300.0, 2.0, 450.0), (60.0, 0.5, 360.0), (10_000.0, 0.02, 999_999.0)],
)
def test_a_far_or_slow_flight_may_last_three_times_its_way(way_m, speed_m_s, expected_s):
    limits = PhaseLimits().for_way(way_m, speed_m_s)
    assert limits == PhaseLimits(flight_timeout_s=expected_s)


def test_the_time_at_waypoints_does_not_count_as_flight():
    assert PhaseLimits().for_way(60.0, 0.5, hold_s=200.0).flight_timeout_s == 360.0 + 200.0


WHY = "The UAV came down in AUTO.LAND, which this run had not ordered; its battery was at 5%."


def test_where_the_flight_controller_lands_by_itself_the_ground_is_no_collision_and_the_cause_is_told(run):
    run.on_ready(True)
    run.on_time(10.0)
    run.on_own_descent(20.0, WHY)
    run.on_contact(23.0, UAV, "ground_plane::link::c", 1.0)
    assert run.on_time(24.0) == []
    assert run.on_armed(25.0, False) == [Action.FINISH]
    outcome = run.outcome
    assert (outcome.failure, outcome.collision, outcome.landed) == (WHY, False, True)
    assert not outcome.success


def test_what_it_hits_while_it_comes_down_by_itself_is_a_collision(run):
    run.on_ready(True)
    run.on_time(10.0)
    run.on_own_descent(20.0, WHY)
    run.on_contact(21.0, UAV, TREE, 0.1)
    assert run.outcome.collision


def test_a_failsafe_that_ends_in_the_air_is_forgotten(run):
    run.on_ready(True)
    run.on_time(10.0)
    run.on_own_descent(20.0, WHY)
    run.on_own_descent(21.0, "")
    run.on_contact(22.0, UAV, "ground_plane::link::c", 1.0)
    assert run.outcome.collision
    assert run.on_armed(25.0, False) == [Action.FINISH]
    assert run.outcome.failure == "The flight controller disarmed while flying to the goal, at 25.0 s."


def test_a_uav_that_stays_on_the_ground_in_its_flight_has_landed_though_its_motors_turn(run):
    run.on_landed(8.0, False)
    run.on_ready(True)
    run.on_time(10.0)
    run.on_landed(20.0, True)
    run.on_landed(24.0, False)
    run.on_landed(24.1, True)
    run.on_landed(25.0, True)
    assert run.on_time(29.0) == []
    assert run.on_time(29.2) == [Action.LAND]
    assert run.outcome.failure == "The UAV stood on the ground while flying to the goal."


def test_a_uav_that_lands_before_its_errand_ends_the_run_and_else_may_try_again():
    for once, actions in ((True, [Action.FINISH]), (False, [])):
        course = Course(PhaseLimits(takes_off_once=once), IRIS, at_rest())
        course.on_time(0.0)
        assert course.on_armed(1.0, False) == []  # it has not taken off yet
        course.on_landed(5.0, False)
        assert course.on_armed(9.0, False) == actions
        assert (course.outcome.failure or "").startswith("The flight controller landed") is once
