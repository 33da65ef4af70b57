"""Flights without ROS: physics against closed form, hover, sensor times, determinism."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Pose
from simulation_tools.px4.modes import Mode, Result
from simulation_tools.px4.setpoint import Setpoint
from simulation_tools.sensors.odometry import OdometryParameters
from simulation_tools.simulation import Simulation, SimulationError, SimulationParameters
from simulation_tools.simulation.random_streams import RandomStreams
from simulation_tools.world.world import BodyState

EMPTY = str(Path(__file__).resolve().parents[2] / "worlds" / "empty.world")
GRAVITY_M_S2 = 9.80665


@pytest.fixture
def make():
    """Returns a function that makes simulations, and closes them afterwards."""
    made = []

    def build(**changes):
        made.append(Simulation(SimulationParameters(**{"world": EMPTY, **changes})))
        return made[-1]

    yield build
    for simulation in made:
        simulation.close()


def hover(simulation, seconds, position=(0.0, 0.0, 2.0)):
    """Takes off and holds a position; yields the output of every step."""
    simulation.sense()
    yaw_rad = 0.0
    for step in range(round(seconds / simulation.time_step_s)):
        px4 = simulation.px4
        if step % 12 == 0:  # a stream of 21 Hz
            px4.offer_setpoint(Setpoint.hold(position, yaw_rad))
        asks = step % 50 == 49 and not px4.status.armed
        if asks and px4.request_mode(Mode.OFFBOARD) is Result.ACCEPTED:
            px4.request_arm()
        yield simulation.step()


@pytest.mark.parametrize(("lidar", "its_mass_kg"), [("ust", 0.13), ("m8", 0.80)])
@pytest.mark.flight
def test_hover_holds_its_place_with_the_lightest_and_heaviest_lidar(make, lidar, its_mass_kg):
    """Closed form of the thrust: n k w^2 = m g, with k the SDF's motorConstant and m including the lidar."""
    simulation = make(lidar=lidar)
    places, thrusts_n = [], []
    for output in hover(simulation, 24.0):
        if output.ground_truth:
            places.append(output.ground_truth.pose.position_m)
        if output.time_us > 12_000_000:
            thrusts_n.append(5.84e-6 * (simulation.airframe.rotor_states**2).sum())
    last = np.array(places[-1000:])  # 10 s
    assert simulation.px4.status.mode is Mode.OFFBOARD
    place = (0.0, 0.0, 2.0 + 0.12)  # PX4's local frame begins where it stood
    np.testing.assert_allclose(last.mean(axis=0), place, atol=0.05)
    assert np.abs(last - place).max() < 0.05
    mass_kg = simulation.world.mass_kg("iris")
    assert mass_kg == pytest.approx(1.5 + its_mass_kg, abs=0.05)
    assert np.mean(thrusts_n) == pytest.approx(mass_kg * GRAVITY_M_S2, rel=0.002)


@pytest.mark.parametrize(("lidar", "rate_hz"), [("ust", 40.0), ("tim", 15.0), ("m8", 30.0)])
def test_a_scan_fires_at_the_first_step_at_or_after_its_due_time(make, lidar, rate_hz):
    simulation = make(lidar=lidar)
    outputs = [simulation.sense(), *(simulation.step() for _ in range(1000))]
    scans = [output for output in outputs if output.scan is not None]
    due_s = np.arange(len(scans)) / rate_hz
    expected_us = np.ceil(np.round(due_s / 0.004, 6)) * 4000
    np.testing.assert_array_equal([output.time_us for output in scans], expected_us)
    assert len(scans) == pytest.approx(4.0 * rate_hz, abs=1)
    assert all(output.odometry is not None and output.ground_truth is not None for output in scans)
    poses = [output for output in outputs if output.ground_truth is not None]
    assert len(poses) >= 400  # 100 Hz, which TF needs


def test_in_free_fall_the_imu_feels_nothing_and_odometry_counts_the_way(make):
    only_scale = replace(OdometryParameters.none(), scale_error=0.1)
    simulation = make(spawn_pose=Pose.from_xyz_rpy(3.0, -2.0, 50.0, yaw=1.0), odometry=only_scale)
    start = simulation.world.get_state("iris").pose
    simulation.world.set_state("iris", BodyState(start, (5.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    simulation.models_moved()
    outputs = [simulation.step() for _ in range(50)]
    felt = np.array([output.imu.linear_acceleration_m_s2 for output in outputs if output.imu])
    assert np.abs(felt).max() < 1.0  # its noise, and the drag at 5 m/s
    last = [output for output in outputs if output.odometry][-1]
    true_m, (x, y, z) = last.ground_truth.pose.position_m, last.odometry.pose.position_m
    assert true_m[0] - 3.0 > 0.9
    assert (x, y, z) == pytest.approx(
        (3.0 + 1.1 * (true_m[0] - 3.0), -2.0 + 1.1 * (true_m[1] + 2.0), true_m[2])
    )
    assert last.odometry.pose.yaw_rad == pytest.approx(last.ground_truth.pose.yaw_rad)


def flight(simulation, seconds):
    """All that a flight says, as bytes."""
    record = []
    for output in hover(simulation, seconds, position=(0.5, -0.3, 1.5)):
        record.append(repr(output[2:]).encode())
        if output.scan is not None:
            record.append(output.scan.tobytes())
        record.append(simulation.px4.commands.tobytes())
    return b"".join(record)


@pytest.mark.flight
def test_the_same_seed_gives_the_same_flight_also_after_a_reset(make):
    simulation = make(seed=7)
    first = flight(simulation, 6.0)
    simulation.reset()
    assert simulation.time_us == 0
    assert flight(simulation, 6.0) == first
    warm = make(seed=7)
    warm.warm_up()
    assert flight(warm, 6.0) == first
    assert flight(make(seed=8), 6.0) != first


def test_a_longer_time_step_makes_time_run_faster_per_step(make):
    simulation = make()
    simulation.set_time_step(0.008)
    assert simulation.step().time_us == 8000
    fall = make(spawn_pose=Pose.from_xyz_rpy(0.0, 0.0, 50.0))
    fall.set_time_step(0.002)
    for _ in range(500):
        fall.step()
    speed = fall.world.get_state("iris").linear_velocity_m_s[2]
    assert speed == pytest.approx(-GRAVITY_M_S2, abs=1e-3)


def test_physics_that_diverges_says_so(make):
    simulation = make()
    simulation.world.set_state("iris", BodyState(Pose.from_xyz_rpy(0.0, 0.0, 5.0), (1e200, 0.0, 0.0)))
    with pytest.raises(SimulationError, match="diverged"):
        flight(simulation, 0.1)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"world": "/nowhere.world"}, "nowhere.world"),
        ({"lidar": "velodyne"}, "urg, ust, utm, puck, tim, m8"),
        ({"model": "no_such_model"}, "no_such_model"),
        ({"seed": -1}, "seed"),
        ({"time_step_s": 0.0005}, "time step"),
        ({"time_step_s": math.nan}, "time step"),
        ({"lidar_range_max_m": 0.01}, "range_max"),
    ],
)
def test_what_cannot_be_simulated_is_refused_with_a_sentence(make, changes, words):
    with pytest.raises(SimulationToolsError, match=words) as caught:
        make(**changes)
    assert "\n" not in str(caught.value)


def test_random_streams_are_independent_and_rewind():
    streams = RandomStreams(3, ("a", "b"))
    a, b = streams["a"].random(5), streams["b"].random(5)
    assert not np.array_equal(a, b)
    streams["a"].random(100)
    np.testing.assert_array_equal(streams["b"].random(5), RandomStreams(3, ("a", "b"))["b"].random(10)[5:])
    streams.rewind()
    np.testing.assert_array_equal(streams["a"].random(5), a)
    np.testing.assert_array_equal(RandomStreams(3, ("a", "b", "c"))["a"].random(5), a)
