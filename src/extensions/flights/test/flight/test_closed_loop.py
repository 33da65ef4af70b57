"""Flights of the whole chain without ROS: to the goal, without contact, repeatable, and safe in failure.

Tolerances were taken from seeds 1 to 20; what they leave room for is said beside each.
"""

import cProfile
import functools
from dataclasses import replace

import numpy as np
import pytest
import yaml

from benchmarks.shared.forked import in_a_copy
from flights.errors import FlightError
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase, PhaseLimits
from flights.flight.parameters import ClosedLoopParameters
from flights.worlds.scenario import SCENARIOS
from simulation_tools.geometry import Pose
from simulation_tools.px4.modes import Mode
from simulation_tools.sdf.parser import parse_model
from simulation_tools.simulation import SimulationParameters

pytestmark = pytest.mark.flight

BOX = """<sdf version="1.6"><model name="box"><static>true</static><link name="link"><collision name="box">
  <pose>0 0 2 0 0 0</pose><geometry><box><size>1 3 4</size></box></geometry>
</collision></link></model></sdf>"""
HALF_A_BOX_M = 0.5


@pytest.fixture
def parameters(worlds_folder):
    def make(scenario="empty", seed=1, **changes):
        world = str(worlds_folder / f"{scenario}.world")
        return ClosedLoopParameters(SimulationParameters(world=world, seed=seed), **changes)

    return make


def speed_at_the_end(loop, over_s=0.2):
    poses = loop.log.between(loop.time_s - over_s, loop.time_s)
    return np.linalg.norm(poses[-1, 1:3] - poses[0, 1:3]) / (poses[-1, 0] - poses[0, 0])


# The others fly elsewhere: the UST and M8 in test_without_gnss.py, the URG in tests/bench
LIDAR_AND_WAY = {"forest": ("tim", 40.0), "hallway": ("utm", 20.0), "sparse": ("puck", 20.0)}


@pytest.mark.parametrize(
    "scenario",
    [
        name if name == "forest" else pytest.param(name, marks=pytest.mark.long)
        for name in SCENARIOS
        if name != "empty"
    ],
)
def test_the_improved_algorithm_flies_every_scenario_without_contact(parameters, scenario):
    lidar, way_m = LIDAR_AND_WAY[scenario]
    given = parameters(scenario, seed=2, goal_xyz_m=(way_m, 0.0, 2.0))
    with ClosedLoop(replace(given, simulation=replace(given.simulation, lidar=lidar))) as loop:
        outcome = loop.run_to(Phase.HOVERING)
    assert outcome.reached_goal, outcome.failure
    assert outcome.touched == ()
    # 40 m at 2 m/s take 20 s, getting up to speed and braking 1.5 s, detours in the forest a few more
    assert 0.5 * way_m < outcome.times_s[Phase.HOVERING] - outcome.times_s[Phase.FLYING] < 0.75 * way_m


FLOOR = """<sdf version="1.6"><world name="hall">
  <model name="floor"><static>true</static><link name="l"><collision name="c">
    <geometry><plane><normal>0 0 1</normal><size>90 90</size></plane></geometry></collision></link></model>
</world></sdf>"""


def test_the_uav_hovers_at_the_goal_and_lands_on_a_floor_of_any_name(tmp_path, parameters):
    """True distance over 5 s, 8 s after the goal was reached (PX4's own velocity steps settle in 6 s)."""
    world = tmp_path / "hall.world"
    world.write_text(FLOOR)
    goal = (3.0, 1.0, 2.0)
    given = parameters(goal_xyz_m=goal, limits=PhaseLimits(hover_s=13.0))
    with ClosedLoop(replace(given, simulation=replace(given.simulation, world=str(world)))) as loop:
        outcome = loop.run()
        hover = loop.log.between(outcome.times_s[Phase.HOVERING] + 8.0, outcome.times_s[Phase.LANDING])
    assert len(hover) >= 500
    assert np.linalg.norm(hover[:, 1:4] - goal, axis=1).max() < 0.05
    assert outcome.success, outcome.failure
    assert "floor" in outcome.ground


@pytest.fixture(scope="module")
def at_full_speed(worlds_folder):
    """A UAV at full speed in an empty field."""
    simulation = SimulationParameters(world=str(worlds_folder / "empty.world"), seed=1)
    with ClosedLoop(ClosedLoopParameters(simulation, goal_xyz_m=(15.0, 0.0, 2.0))) as loop:
        loop.run(until=lambda flight: flight.log.truth and flight.log.truth.rows[-1][1] > 5.0)
        assert speed_at_the_end(loop) > 1.8
        yield loop


def flown_on(test):
    """Let a test fly on in a copy of the process, so that several begin with one flight."""

    @functools.wraps(test)
    def fly_on(at_full_speed):
        in_a_copy(lambda: test(at_full_speed))

    return fly_on


@flown_on
def test_a_step_makes_few_calls(at_full_speed):
    # Half of the time of a flight is Python's, and this time goes with the number of calls. With a question
    # to each part in each step, a step makes more than 400.
    steps, profile = 500, cProfile.Profile()
    profile.runcall(lambda: [at_full_speed.step() for _ in range(steps)])
    assert sum(entry.callcount for entry in profile.getstats()) / steps < 220


@flown_on
def test_a_box_that_appears_2_5_m_ahead_is_not_touched(at_full_speed):
    # When a box 3 m wide appears across its way
    loop = at_full_speed
    _, x, y, *_ = loop.log.truth.rows[-1]
    box = Pose.from_xyz_rpy(x + 2.5 + HALF_A_BOX_M, y, 0.0)
    loop.simulation.world.spawn(parse_model(BOX, "a test"), "box", box)
    appeared_s = loop.time_s
    loop.run_to(Phase.HOVERING)
    # Then the UAV slows down or gives way, and gets to the goal without touching it
    assert loop.outcome.reached_goal, loop.outcome.failure
    assert loop.outcome.touched == ()
    after = [row for row in loop.log.v_safe if row[0] >= appeared_s]
    assert np.hypot(after[0][1], after[0][2]) < 1.5 or abs(after[0][2]) > 0.5
    behind = x + 2.5 + 2 * HALF_A_BOX_M
    assert loop.log.truth.rows[-1][1] > behind


@flown_on
def test_a_silent_publisher_leads_to_hover_and_landing(at_full_speed):
    # When nobody sends setpoints any more
    loop = at_full_speed
    loop.publisher.silent = True
    silent_s = loop.time_s
    loop.run(until=lambda flight: flight.simulation.px4.status.mode is Mode.AUTO_LAND)
    # Then PX4 lands by itself 1 s (COM_OF_LOSS_T) after the last setpoint, which is up to 25 ms old
    assert 0.97 <= loop.time_s - silent_s < 1.05
    assert loop.simulation.px4.status.failsafe
    loop.run(until=lambda flight: flight.time_s > silent_s + 4.0)
    assert speed_at_the_end(loop) < 0.3
    outcome = loop.run()
    assert outcome.touched == ("ground_plane::link::floor",)
    assert "disarmed while flying to the goal" in outcome.failure
    assert loop.log.truth.rows[-1][3] < 0.3


@flown_on
def test_a_publisher_that_comes_back_takes_the_flight_up_again(at_full_speed):
    loop = at_full_speed
    loop.publisher.silent = True
    silent_s = loop.time_s
    loop.run(until=lambda flight: flight.time_s > silent_s + 2.0)
    assert loop.simulation.px4.status.mode is Mode.AUTO_LAND
    loop.publisher.silent = False
    outcome = loop.run_to(Phase.HOVERING)
    assert outcome.reached_goal, outcome.failure


def test_with_drifting_odometry_the_goal_is_where_odometry_says(parameters):
    given = parameters(goal_xyz_m=(30.0, 0.0, 2.0), pose_source="odometry")
    with ClosedLoop(given) as loop:
        outcome = loop.run_to(Phase.HOVERING)
        goal = np.array(given.goal_xyz_m)
        believed = np.linalg.norm(loop.log.odometry.rows[-1][1:4] - goal)
        truly = np.linalg.norm(loop.log.truth.rows[-1][1:4] - goal)
    assert outcome.reached_goal
    assert believed <= given.position_controller.goal_tolerance
    # 1 % of 30 m ahead, and half of 0.002 rad/m x (30 m)^2 = 0.9 m aside; noise may take away half of it
    assert truly > 0.4


def test_the_limits_are_those_of_the_node_and_of_the_way(parameters, worlds_folder):
    written = yaml.safe_load((worlds_folder.parent / "config/experiment.yaml").read_text())
    assert PhaseLimits(**written) == PhaseLimits()
    assert parameters(goal_xyz_m=(300.0, 0.0, 2.0)).limits_of_way.flight_timeout_s == 450.0


def test_unknown_choices_are_refused_with_the_choices(parameters):
    with pytest.raises(FlightError, match="no algorithm 'best'; choose one of improved, original"):
        parameters(algorithm="best")
    with pytest.raises(FlightError, match="no pose source 'gps'; choose one of ground_truth, odometry"):
        parameters(pose_source="gps")


def test_it_flies_with_what_the_nodes_are_launched_with(parameters, worlds_folder):
    """The launch files' YAML and the library's defaults are the same numbers."""
    packages = worlds_folder.parents[2]
    tools = yaml.safe_load((packages / "inspection_tools/config/tools.yaml").read_text())
    launched = {**tools, "cepa": yaml.safe_load((packages / "cepa/config/cepa.yaml").read_text())}
    flown = parameters()
    for node, block in (
        ("lidar_median_filter", flown.median_filter),
        ("lidar_padding", flown.padding),
        ("position_controller", flown.position_controller),
        ("yaw_regulator", flown.yaw_regulator),
        ("cepa", flown.cepa),
    ):
        for name, value in launched[node].items():
            if name == "speed_fractions":
                value = tuple(float(word) for word in value.split())
            ours = flown.algorithm if name == "algorithm" else getattr(block, name)
            assert ours == value or (str(ours) == str(value) == "nan"), f"{node}/{name}"
