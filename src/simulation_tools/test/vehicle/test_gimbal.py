"""The lidar's gimbal: level against closed form, limits, rate, and what the levelled lidar sees."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.geometry import Pose
from simulation_tools.sdf.parser import load_model, parse_model
from simulation_tools.simulation import Simulation, SimulationError, SimulationParameters
from simulation_tools.vehicle.gimbal import Gimbal, GimbalError, level_angles
from simulation_tools.world.world import BodyState

PACKAGE = Path(__file__).resolve().parents[2]
EMPTY = str(PACKAGE / "worlds" / "empty.world")
IRIS = load_model("model://iris", [PACKAGE / "models"])
MOUNT = IRIS.link("lidar_mount").pose
LONG_S = 10.0
ANGLE = st.floats(-0.7, 0.7)


def gimbal_at(roll, pitch, yaw=0.0):
    """The Iris's gimbal, levelling for long, and the orientation of the UAV."""
    gimbal = Gimbal.from_sdf(IRIS)
    gimbal.switch(True)
    body = Pose.from_xyz_rpy(0.0, 0.0, 0.0, roll, pitch, yaw)
    gimbal.step(body.orientation_xyzw, LONG_S)
    return gimbal, body


@given(ANGLE, ANGLE, st.floats(-3.0, 3.0))
def test_what_it_carries_points_straight_up_and_stays_over_its_hinges(roll, pitch, yaw):
    gimbal, body = gimbal_at(roll, pitch, yaw)
    mount = body @ gimbal.turned(MOUNT)
    np.testing.assert_allclose(mount.rotation[:, 2], (0.0, 0.0, 1.0), atol=1e-9)
    np.testing.assert_allclose(gimbal.turned(MOUNT).position_m, MOUNT.position_m, atol=1e-12)
    # A lidar 5 cm above the hinges is 5 cm straight above them, however the UAV leans.
    lidar = body @ gimbal.turned(MOUNT @ Pose((0.0, 0.0, 0.05)))
    np.testing.assert_allclose(np.subtract(lidar.position_m, mount.position_m), (0, 0, 0.05), atol=1e-9)


def test_a_lean_about_one_axis_is_taken_back_by_its_hinge():
    assert level_angles(Pose.from_xyz_rpy(0, 0, 0, 0.3, 0.0, 1.2).orientation_xyzw) == pytest.approx(
        (-0.3, 0.0)
    )
    assert level_angles(Pose.from_xyz_rpy(0, 0, 0, 0.0, 0.3, 1.2).orientation_xyzw) == pytest.approx(
        (0.0, -0.3)
    )


def test_it_stops_at_its_limits_and_turns_no_faster_than_its_rate():
    gimbal, _ = gimbal_at(1.2, 0.0)
    assert gimbal.angles_rad == pytest.approx((-0.8, 0.0))  # the joint's limit
    gimbal.switch(False)
    gimbal.step((0.0, 0.0, 0.0, 1.0), 0.02)
    assert gimbal.angles_rad == pytest.approx((-0.6, 0.0))  # 10 rad/s for 20 ms
    assert gimbal.is_active
    gimbal.step((0.0, 0.0, 0.0, 1.0), LONG_S)
    assert gimbal.angles_rad == (0.0, 0.0)
    assert not gimbal.is_active
    assert gimbal.turned(MOUNT) == MOUNT


@pytest.fixture
def leaning():
    """A simulation whose UAV is 2 m over the floor; returns a function that leans it and scans."""
    simulation = Simulation(SimulationParameters(EMPTY, spawn_pose=Pose.from_xyz_rpy(0.0, 0.0, 2.0 - 0.12)))

    def scan(roll, pitch):
        """A scan taken while the UAV leans, without the time to fall."""
        pose = Pose.from_xyz_rpy(0.0, 0.0, 2.0, roll, pitch)
        simulation.world.set_state("iris", BodyState(pose))
        simulation.models_moved()
        for _ in range(50):
            simulation.gimbal.step(pose.orientation_xyzw, 0.004)
        simulation._sensors.aim_lidar()
        return simulation.lidar.scan(simulation.world.rays, pose, "iris")

    yield simulation, scan
    simulation.close()


def test_a_leaning_uav_sees_the_floor_unless_its_lidar_is_levelled(leaning):
    simulation, scan = leaning
    lean = 0.3
    tilted = scan(0.0, lean)
    # Nose down: the beam ahead leaves the lidar, 0.1145 m up the body's z axis, and meets the floor under it.
    height = 2.0 + 0.1145 * math.cos(lean)
    assert tilted[540] == pytest.approx(height / math.sin(lean), abs=0.07)  # five sigma
    assert np.isfinite(tilted).sum() > 300
    simulation.set_level_lidar(True)
    for roll, pitch in ((0.0, lean), (lean, 0.0), (-lean, -lean)):
        assert np.isinf(scan(roll, pitch)).all(), "a levelled scan saw the floor"
    simulation.set_level_lidar(False)
    np.testing.assert_allclose(scan(0.0, lean)[540], height / math.sin(lean), atol=0.07)


def test_the_joints_are_told_once_the_gimbal_has_been_used(leaning):
    simulation, scan = leaning
    assert simulation.joint_angles() == {}
    simulation.set_level_lidar(True)
    scan(0.2, 0.0)
    assert simulation.joint_angles() == pytest.approx(
        {"iris::lidar_roll_joint": -0.2, "iris::lidar_pitch_joint": 0.0}
    )
    simulation.set_level_lidar(False)
    scan(0.2, 0.0)
    assert simulation.joint_angles() == {"iris::lidar_roll_joint": 0.0, "iris::lidar_pitch_joint": 0.0}


def test_a_uav_without_a_gimbal_says_so():
    simulation = Simulation(SimulationParameters(EMPTY, model="reference_quad"))
    with pytest.raises(SimulationError, match="no gimbal"):
        simulation.set_level_lidar(True)
    simulation.close()
    with pytest.raises(SimulationError, match="no gimbal"):
        Simulation(SimulationParameters(EMPTY, model="reference_quad", level_lidar=True))


JOINT = (
    '<joint name="{0}" type="revolute"><parent>{1}</parent><child>{2}</child>'
    "<axis><xyz>{3}</xyz></axis></joint>"
)
PLUGIN = '<plugin name="g" filename="libsimulation_tools_gimbal.so">{}</plugin>'
NAMES = "<rollJoint>r</rollJoint><pitchJoint>p</pitchJoint>"
GOOD = JOINT.format("r", "a", "b", "1 0 0") + JOINT.format("p", "b", "c", "0 1 0")


@pytest.mark.table(
    ("joints", "plugin", "words"),
    [
        (GOOD, PLUGIN.format("<rollJoint>x</rollJoint>"), 'rollJoint "x", which does not exist'),
        (GOOD.replace("1 0 0", "0 0 1"), PLUGIN.format(NAMES), "rollJoint that turns about"),
        (
            GOOD.replace('"p" type="revolute"', '"p" type="fixed"'),
            PLUGIN.format(NAMES),
            "pitchJoint that turns",
        ),
        (GOOD.replace("<parent>b", "<parent>a"), PLUGIN.format(NAMES), "that the roll joint carries"),
        (GOOD, PLUGIN.format(NAMES + "<maxRate>fast</maxRate>"), "positive <maxRate>"),
        (GOOD, PLUGIN.format(NAMES + "<maxRate>-1</maxRate>"), "positive <maxRate>"),
        (GOOD, 2 * PLUGIN.format(NAMES).replace('"g"', '"h"'), "one gimbal only"),
    ],
)
def test_a_gimbal_that_cannot_be_is_refused_with_its_place(joints, plugin, words):
    links = "".join(f'<link name="{name}"/>' for name in "abc")
    model = parse_model(
        f'<sdf version="1.6"><model name="m">{links}{joints}{plugin}</model></sdf>', "m.sdf", []
    )
    with pytest.raises(GimbalError, match=words) as caught:
        Gimbal.from_sdf(model)
    assert str(caught.value).startswith("m.sdf:1: ")
