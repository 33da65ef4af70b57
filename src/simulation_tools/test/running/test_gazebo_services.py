"""Gazebo's services by its conventions, on the real simulation, without ROS."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.running.gazebo_services import GazeboServices
from simulation_tools.running.run_loop import RunLoop
from simulation_tools.simulation import PhysicsDivergedError, Simulation, SimulationParameters
from simulation_tools.world.world import BodyState

EMPTY = str(Path(__file__).resolve().parents[2] / "worlds" / "empty.world")
BOX = (
    '<sdf version="1.6"><model name="box"><link name="link"><collision name="c"><geometry><box>'
    "<size>1 1 1</size></box></geometry></collision></link></model></sdf>"
)
SWING = (
    '<sdf version="1.6"><model name="swing"><link name="post"><pose>0 0 3 0 0 0</pose></link>'
    '<link name="arm"><pose>0 0 2 0 0 0</pose><inertial><mass>1</mass></inertial></link>'
    '<joint name="nail" type="fixed"><parent>world</parent><child>post</child></joint>'
    '<joint name="hinge" type="revolute"><pose>0 0 1 0 0 0</pose><parent>post</parent><child>arm</child>'
    "<axis><xyz>0 1 0</xyz></axis></joint></model></sdf>"
)


class NoLink:
    """A MAVLink link that nobody uses."""

    on_setpoint = None

    def poll(self, *_):
        pass

    send_due = flush = reset = poll

    def wait(self, _timeout_s):
        return False


class NoOutput:
    def publish(self, _output):
        pass

    def report(self, *_):
        pass


@pytest.fixture
def served():
    simulation = Simulation(SimulationParameters(EMPTY))
    loop = RunLoop(simulation, NoLink(), NoOutput())
    yield simulation, GazeboServices(simulation, loop, ()), loop
    simulation.close()


def test_a_link_is_where_its_joint_has_turned_it_and_moves_as_it_does(served):
    simulation, services, _ = served
    assert services.spawn("", SWING, Pose((5.0, 0.0, 0.0)), "world").success
    world = simulation.world
    spin = BodyState(Pose((5.0, 0.0, 0.0)))
    world.set_state("swing", spin)
    import pybullet

    (body,) = (body for _, body in world._there.owner.values() if len(body.parts) > 1)
    pybullet.resetJointState(body.uid, 0, 0.5, 2.0, physicsClientId=world._client)
    assert world.joint_angles() == pytest.approx({"swing::hinge": 0.5})
    answer = services.get_state("swing::arm", "")
    # The arm's frame hangs 1 m under the hinge at z = 3; turned by 0.5 rad, it moves at 2 rad/s x 1 m.
    s, c = math.sin(0.5), math.cos(0.5)
    np.testing.assert_allclose(answer.state.pose.position_m, (5.0 - s, 0.0, 3.0 - c), atol=1e-9)
    np.testing.assert_allclose(answer.state.linear_velocity_m_s, (-2.0 * c, 0.0, 2.0 * s), atol=1e-9)
    np.testing.assert_allclose(answer.state.angular_velocity_rad_s, (0.0, 2.0, 0.0), atol=1e-9)
    box = services.spawn("on_the_arm", BOX, Pose((0.0, 0.0, -1.0)), "swing::arm")
    assert box.success, box.status_message
    place = world.get_state("on_the_arm").pose.position_m
    np.testing.assert_allclose(place, (5.0 - 2.0 * s, 0.0, 3.0 - 2.0 * c), atol=1e-9)


def test_a_link_of_a_spinning_body_moves_with_the_spin(served):
    _, services, _ = served
    services.spawn("", BOX.replace('name="link"><', 'name="link"><pose>2 0 0 0 0 0</pose><'), Pose(), "")
    spinning = BodyState(Pose((0.0, 9.0, 5.0)), (1.0, 0.0, 0.0), (0.0, 0.0, 3.0))
    assert services.set_state("box", spinning, "").success
    state = services.get_state("box::link", "world").state
    np.testing.assert_allclose(state.pose.position_m, (2.0, 9.0, 5.0), atol=1e-9)
    np.testing.assert_allclose(state.linear_velocity_m_s, (1.0, 6.0, 0.0), atol=1e-9)


def test_a_state_tells_its_time_and_keeps_it_while_the_simulation_goes_on(served):
    simulation, services, _ = served
    simulation.step()
    asked_us, answer = simulation.time_us, services.get_state("iris", "")
    simulation.step()
    assert asked_us == answer.time_us < simulation.time_us


def test_the_imu_does_not_feel_a_hand_that_moves_the_uav(served):
    """Put elsewhere at another speed: no acceleration, but a place."""
    simulation, services, _ = served
    services.set_state("iris", BodyState(Pose((0.0, 0.0, 50.0))), "")
    simulation.step()
    services.set_state("iris", BodyState(Pose((3.0, 0.0, 60.0)), (0.0, 0.0, 20.0)), "")
    for _ in range(10):
        output = simulation.step()
        if output.imu is not None:
            assert np.abs(output.imu.linear_acceleration_m_s2).max() < 2.0  # falling, up to drag and noise


@pytest.mark.parametrize(
    ("name", "said"), [("box", "already exists"), ("map", "cannot be"), ("a::b", "cannot be")]
)
def test_a_name_that_cannot_be_is_refused_and_changes_nothing(served, name, said):
    simulation, services, _ = served
    assert services.spawn("box", BOX, Pose((3.0, 0.0, 1.0)), "").success
    names = simulation.world.model_names()
    answer = services.spawn(name, BOX, Pose(), "")
    assert not answer.success
    assert said in answer.status_message
    assert simulation.world.model_names() == names


SHAPE = "<box><size>1 1 1</size></box>"
BOMB = """<?xml version="1.0"?>
<!DOCTYPE b [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;">]><sdf version="1.6"><model name="&c;"/></sdf>"""


@pytest.mark.parametrize(
    ("xml", "said"),
    [
        (BOMB, "document type"),
        (BOX.replace("<collision", "<inertial><mass>-1</mass></inertial><collision"), "must be positive"),
        (BOX.replace("<collision", "<pose>nan 0 0 0 0 0</pose><collision"), "finite numbers"),
        (BOX.replace(SHAPE, "<mesh><uri>model://x/y.stl</uri></mesh>"), "no model"),
        (
            BOX.replace(SHAPE, "<mesh><uri>file:///etc/x.stl</uri></mesh>"),
            "leaves the",
        ),
    ],
)
def test_spawning_nonsense_is_refused_with_a_sentence_and_the_world_goes_on(served, xml, said):
    simulation, services, _ = served
    before = simulation.world.model_names()
    answer = services.spawn("x", xml, Pose(), "")
    assert not answer.success
    assert said in answer.status_message
    assert simulation.world.model_names() == before
    simulation.step()


class TestDivergence:
    """Physics that blows up is said, and reset; what blows up again at once is paused."""

    @pytest.fixture
    def watched(self, served):
        simulation, services, loop = served
        self.said = []
        loop.on_warning = self.said.append

        def reset():
            simulation.reset()
            loop.restart()

        loop.on_divergence = reset
        return simulation, services, loop

    @staticmethod
    def run(loop, simulation, steps):
        count = iter(range(steps))
        loop.set_pacing(type(loop.pacing)(real_time_factor=0.0))
        loop.run(lambda: next(count, None) is None)

    @staticmethod
    def explode(simulation, name):
        simulation.world.set_state(name, BodyState(Pose((0.0, 0.0, 5.0)), (1e200, 0.0, 0.0)))

    @pytest.mark.parametrize("name", ["iris", "box"])
    def test_it_is_said_and_the_simulation_begins_again(self, watched, name):
        simulation, services, loop = watched
        services.spawn("box", BOX, Pose((9.0, 0.0, 0.5)), "")
        self.run(loop, simulation, 100)
        self.explode(simulation, name)
        self.run(loop, simulation, 100)
        (sentence,) = self.said
        assert f'"{name}" diverged' in sentence
        assert "has been reset" in sentence
        assert not loop.paused
        assert simulation.time_us < 400_000
        assert simulation.world.get_state("iris").pose.position_m == pytest.approx((0, 0, 0.12), abs=0.01)
        assert simulation.world.get_state("box").pose.position_m == pytest.approx((9, 0, 0.5), abs=0.01)

    def test_a_relapse_pauses(self, watched):
        simulation, _, loop = watched
        for _ in range(2):
            self.run(loop, simulation, 20)
            self.explode(simulation, "iris")
            self.run(loop, simulation, 20)
        assert loop.paused
        assert "A reset did not help: paused" in self.said[-1]

    def test_without_somebody_who_resets_it_ends(self, served):
        simulation, _, loop = served
        self.explode(simulation, "iris")
        with pytest.raises(PhysicsDivergedError, match="iris"):
            self.run(loop, simulation, 20)


def test_a_spawned_model_is_at_the_pose_of_its_sdf_in_the_given_pose(served):
    """As gazebo_ros_api_plugin does: the SDF's <pose> is kept within the initial pose."""
    simulation, services, _ = served
    text = BOX.replace("<link", "<static>1</static><pose>1 0 0.5 0 0 0</pose><link", 1)
    services.spawn("box", text, Pose.from_xyz_rpy(10, 0, 0, yaw=math.pi / 2), "")
    np.testing.assert_allclose(simulation.world.get_state("box").pose.position_m, (10, 1, 0.5), atol=1e-12)
