"""Missions in the closed loop, and the recording of a flight for SLAM."""

from dataclasses import replace

import numpy as np
import pytest

from flights.errors import FlightError, ScenarioError
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.flight_recording import FlightRecorder
from flights.mapping.mapping_flight import fly_and_record, parameters_of
from inspection_tools import Waypoint
from simulation_tools.geometry import Pose

pytestmark = pytest.mark.flight

SHORT = (Waypoint((1.5, -7.0, 2.0)), Waypoint((1.5, -5.5, 2.0), hold_s=1.0))


@pytest.fixture(scope="module")
def parameters():
    return replace(parameters_of("hold", "urg", seed=3), mission=SHORT)


@pytest.fixture(scope="module")
def recording(parameters):
    return fly_and_record("short", parameters)


def test_every_waypoint_is_flown_to_and_the_last_one_held(recording):
    places_m = np.array([moment.truth.position_m for moment in recording])
    for waypoint in SHORT:
        assert np.linalg.norm(places_m - waypoint.position_m, axis=1).min() <= waypoint.tolerance_m
    held = places_m[recording.times_s > recording.times_s[-1] - 0.89]  # 1 s, less a scan's period
    assert np.all(np.linalg.norm(held - SHORT[-1].position_m, axis=1) <= 0.3)


def test_the_time_ends_a_mission_too(parameters):
    with ClosedLoop(replace(parameters, duration_s=1.0)) as loop:
        outcome = loop.run_to(Phase.HOVERING)
    assert outcome.reached_goal
    assert outcome.times_s[Phase.HOVERING] - outcome.times_s[Phase.FLYING] == pytest.approx(1.0, abs=0.011)


def test_a_recording_holds_every_scan_with_the_poses_of_its_instant(recording):
    assert np.allclose(np.diff(recording.times_s), 0.1, atol=0.0041)  # 10 Hz in steps of 4 ms
    assert recording.ranges_m.shape == (len(recording), 683)
    assert recording.lidar.range_max_m == 5.6
    first, *_, last = recording
    assert first.t_s == 0.0
    assert np.allclose(first.truth.position_m[:2], (0.0, -7.0))
    assert np.allclose(first.odometry.position_m, first.truth.position_m)
    drift = np.linalg.norm(np.subtract(last.odometry.position_m, last.truth.position_m))
    assert 0.0 < drift < 0.5  # 1 % of 3 m and 2 cm per root metre
    assert last.odometry.position_m[2] == last.truth.position_m[2]


def test_a_slower_lidar(recording):
    assert np.array_equal(recording.one_of(5).times_s, recording.times_s[::5])
    assert np.array_equal(recording.one_of(5).ranges_m[1], recording.ranges_m[5])


def test_listeners_change_nothing_of_the_flight(parameters):
    """What stands beside the control chain must not be felt in it."""
    truths = []
    for listens in (False, True):
        with ClosedLoop(parameters) as loop:
            if listens:
                loop.listeners.append(FlightRecorder("a flight", loop.simulation.lidar))
            loop.run(until=lambda flight: flight.time_s > 3.0)
            truths.append(np.array(loop.log.truth.rows))
    assert np.array_equal(*truths)


def test_a_flight_that_fails_is_no_recording(parameters):
    """A waypoint in the plating: CEPA keeps the UAV away until the time is over."""
    limits = replace(parameters.limits, flight_timeout_s=2.0)
    blocked = replace(
        parameters,
        mission=(Waypoint((0.0, -9.9, 2.0), tolerance_m=0.1),),
        limits=limits,
        simulation=replace(parameters.simulation, spawn_pose=Pose.from_xyz_rpy(0.0, -7.0, 0.0)),
    )
    with pytest.raises(FlightError, match="The flight blocked failed: Still flying to the goal"):
        fly_and_record("blocked", blocked)


def test_an_unknown_scenario_is_refused_with_the_choices():
    with pytest.raises(ScenarioError, match=r"no scenario 'attic'; choose scenario:=room\|hold"):
        parameters_of("attic", "ust", 1)
