"""What counts as landed, with paths known in closed form: sinking, drifting, sliding, tipping, falling."""

import math

import pytest

from flights.flight.course import Phase, PhaseLimits
from flights.flight.judging.contacts import UavParts
from flights.flight.judging.landing import OFF_MOST_M, SIDEWAYS_MOST_M_S, SINK_MOST_M_S, TILT_MOST_RAD
from flights.flight.monitor import Monitor
from flights.results.metrics import flight_metrics
from simulation_tools.geometry import quaternion_from_rpy

STANDS_M, FLIES_M = 0.12, 2.0
GROUND, LEG, ROTOR = "ground_plane::link::floor", "iris::base_link::leg_0", "iris::rotor_2::disc"
LANDS_S = 7.0
STEP_S = 0.01


def land(
    sink_m_s=0.7,
    sideways_m_s=0.0,
    roll_deg=0.0,
    slides_m_s=0.0,
    braking_m=0.0,
    part=LEG,
    tells_contact=True,
    rest_s=2.0,
    ground_m=0.0,
):
    """Fly to a goal over the start, hover, and land along a straight line; then stand, or slide.

    sideways_m_s: while it sinks. roll_deg: on the ground. Returns the monitor and the time of the touch.
    """
    monitor = Monitor(PhaseLimits(hover_s=2.0), UavParts("iris", frozenset(("rotor_2",))))
    course = monitor.course
    course.on_ready(True)

    def pose(t_s, x_m, z_m, roll_deg=0.0):
        monitor.on_truth(t_s, (x_m, 0.0, z_m), quaternion_from_rpy(math.radians(roll_deg), 0.0, 1.0))

    stands_m, steps = ground_m + STANDS_M, round(LANDS_S / STEP_S)
    for step in range(steps):
        pose(STEP_S * step, 0.0, FLIES_M)
        if step == 450:
            monitor.on_goal_reached(True)
    assert course.phase is Phase.LANDING
    t_s, z_m, x_m = STEP_S * steps, FLIES_M, braking_m
    while z_m > stands_m:
        pose(t_s, x_m, z_m)
        t_s, z_m, x_m = t_s + STEP_S, z_m - STEP_S * sink_m_s, x_m + STEP_S * sideways_m_s
    if tells_contact:
        monitor.on_contact(t_s, part, GROUND, 1.0)
    for _ in range(round(rest_s / STEP_S)):
        pose(t_s, x_m, stands_m, roll_deg)
        t_s, x_m = t_s + STEP_S, x_m + STEP_S * slides_m_s
    monitor.on_armed(False)
    assert course.phase is Phase.DONE
    return monitor


def test_a_soft_landing_where_it_was_ordered_is_a_success():
    outcome = land().course.outcome
    assert outcome.success
    assert outcome.landed
    assert outcome.landing.sink_m_s == pytest.approx(0.7, abs=0.01)
    assert outcome.landing.landing_error_m == pytest.approx(0.0, abs=1e-9)
    assert outcome.landing.tilt_rad == pytest.approx(0.0, abs=1e-6)


def test_a_uav_that_hit_the_ground_sideways_and_lies_on_two_rotors_has_not_landed():
    """ArduPilot's "Crash: Disarming": 1.8 m/s sideways, 3.9 m off, at 45 degrees, then disarmed."""
    way_m = 3.9
    sink = (FLIES_M - STANDS_M) * 1.8 / way_m
    outcome = land(sink_m_s=sink, sideways_m_s=1.8, roll_deg=45.0, part=ROTOR).course.outcome
    assert not outcome.landed
    assert not outcome.success
    assert outcome.collision
    assert outcome.touched == (GROUND,)
    for words in ("1.8 m/s sideways (at most 0.8)", "tilted by 45 degrees (at most 15)", "3.9 m from where"):
        assert words in outcome.failure


@pytest.mark.table(
    ("how", "words"),
    [
        ({"sideways_m_s": 1.2 * SIDEWAYS_MOST_M_S}, "at 1.0 m/s sideways"),
        ({"sink_m_s": 1.2 * SINK_MOST_M_S}, "at 1.8 m/s downwards"),
        ({"roll_deg": 1.2 * math.degrees(TILT_MOST_RAD)}, "tilted by 18 degrees"),
        ({"roll_deg": -178.0}, "tilted by 178 degrees"),
        ({"braking_m": 1.2 * OFF_MOST_M}, "1.8 m from where it was told to land"),
        ({"slides_m_s": 0.2}, "it still moved at 0.2 m/s when the motors stopped"),
        ({"slides_m_s": 1.2, "rest_s": 0.2}, "at 1.2 m/s sideways"),
    ],
)
@pytest.mark.table("tells_contact", [True, False])
def test_each_fault_alone_fails_the_landing_and_is_named_with_its_figure(how, words, tells_contact):
    outcome = land(**how, tells_contact=tells_contact).course.outcome
    assert not outcome.landed
    assert not outcome.success
    assert words in outcome.failure
    assert outcome.failure.startswith("The landing failed: ")


@pytest.mark.table(
    "how",
    [
        {"sideways_m_s": 0.5, "sink_m_s": 0.9},
        {"sink_m_s": 1.4},
        {"roll_deg": 12.0},
        {"braking_m": 1.2},
        {"ground_m": 1.0},
        {"sink_m_s": 0.3, "sideways_m_s": 0.1},
    ],
)
def test_drift_slopes_and_higher_ground_are_no_faults(how):
    assert land(**how).course.outcome.success


def test_a_uav_whose_motors_stop_in_the_air_has_not_landed():
    outcome = land(rest_s=0.0).course.outcome
    assert not outcome.landed
    assert "it still moved at 0.7 m/s when the motors stopped" in outcome.failure


def test_a_fall_from_an_edge_after_the_touch_counts():
    """It stands on a shelf, tips over its edge, and falls for 0.3 s: 9.81 * 0.3 = 2.9 m/s."""
    monitor = land(ground_m=1.0)
    course = monitor.course
    course.phase, course._landing, course._failure = Phase.LANDING, None, None
    began_s = monitor.now_s
    for step in range(1, 200):
        fell_m = 0.5 * 9.81 * min(0.01 * step, 0.3) ** 2
        monitor.log.truth.add(began_s + 0.01 * step, 0.0, 0.0, 1.12 - fell_m, 0.0, 0.0, 0.0, 1.0)
    monitor.on_armed(False)
    assert "m/s downwards" in course.outcome.failure
    assert course.outcome.landing.sink_m_s == pytest.approx(9.81 * 0.275, abs=0.05)  # a mean of 0.05 s


def test_a_flight_that_is_told_to_land_while_it_flies_may_brake():
    """At 2 m/s it needs 1.9 m to stop, of which a second of its speed is allowed."""
    monitor = Monitor(PhaseLimits(), UavParts("iris", frozenset()))
    monitor.course.on_ready(True)
    upright, t_s, x_m, speed = (0.0, 0.0, 0.0, 1.0), 0.0, 0.0, 2.0
    while t_s < 12.0:
        if t_s > 4.0:
            speed = max(speed - 0.01 * 1.05, 0.0)
        x_m += 0.01 * speed
        monitor.on_truth(t_s, (x_m, 0.0, max(2.0 - 0.5 * max(t_s - 6.0, 0.0), 0.12)), upright)
        t_s += 0.01
        if 4.0 <= t_s < 4.01:
            monitor.land_here("The UAV did not come home: a test.")
    monitor.on_armed(False)
    outcome = monitor.course.outcome
    assert outcome.landing.landing_error_m == pytest.approx(1.9, abs=0.1)
    assert outcome.landing.off_most_m == pytest.approx(OFF_MOST_M + 2.0, abs=0.05)
    assert outcome.landed
    assert outcome.failure == "The UAV did not come home: a test."


def test_nobody_knows_how_a_uav_without_true_poses_has_landed():
    monitor = Monitor(PhaseLimits(), UavParts("iris", frozenset()))
    course = monitor.course
    course.on_time(0.0)
    course.on_ready(True)
    course.on_time(1.0)
    course.on_goal_reached(2.0, True)
    course.on_time(5.0)
    course.on_armed(9.0, False)
    assert course.outcome.failure == "The landing failed: nobody told the UAV's true pose."


@pytest.mark.table("in_flight", [True, False])
def test_a_rotor_on_the_ground_is_a_contact_whenever_it_happens(in_flight):
    monitor = Monitor(PhaseLimits(), UavParts("iris", frozenset(("rotor_2",))))
    monitor.on_truth(0.0, (0.0, 0.0, 0.12), (0.0, 0.0, 0.0, 1.0))
    monitor.on_contact(0.0, LEG, GROUND, 1.0)
    assert not monitor.course.outcome.collision
    monitor.course.on_ready(in_flight)
    monitor.decide()
    monitor.on_contact(1.0, GROUND, ROTOR, -1.0)
    assert monitor.course.outcome.failure == f"The UAV touched {GROUND} with rotor_2."


def test_a_bad_landing_between_two_parts_ends_the_run():
    monitor = land()
    course = monitor.course
    course.phase = Phase.FLYING
    monitor.land_between()
    for _ in range(300):
        lying = quaternion_from_rpy(math.radians(50.0), 0.0, 0.0)
        monitor.log.truth.add(monitor.now_s + 0.01, 0.0, 0.0, 0.12, *lying)
    actions = monitor.on_armed(False)
    assert [action.name for action in actions] == ["FINISH"]
    assert course.outcome.failure == "The landing failed: it is tilted by 50 degrees (at most 15)."


def test_the_result_tells_the_landing_apart_from_the_hover():
    """It hovers at the goal, and sinks at 0.4 m/s while it drifts at 0.2 m/s: 0.94 m off."""
    monitor = land(sink_m_s=0.4, sideways_m_s=0.2)
    found = flight_metrics(monitor.log, monitor.course.outcome, (0.0, 0.0, FLIES_M))
    assert found["goal_error_m"] == pytest.approx(0.0, abs=1e-9)
    assert found["landed_off_goal_m"] == found["landing_error_m"] == pytest.approx(0.94, abs=0.01)
    assert found["landing"] == pytest.approx(
        {"sink_m_s": 0.4, "sideways_m_s": 0.2, "tilt_deg": 0.0, "speed_m_s": 0.0}, abs=0.01
    )


def test_the_parts_of_a_uav_are_those_of_its_model_whatever_names_it():
    rotors = frozenset(f"rotor_{number}" for number in range(4))
    assert UavParts.load("iris") == UavParts("iris", rotors)
    assert UavParts.load("model://small_quad").rotors == rotors
