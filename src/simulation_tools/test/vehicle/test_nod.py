"""The nodding lidar: the gimbal's angles in closed form, what it refuses, and a room that its scans fill."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.sdf.parser import load_model
from simulation_tools.simulation import Simulation, SimulationError, SimulationParameters
from simulation_tools.vehicle.gimbal import Gimbal, GimbalError
from simulation_tools.vehicle.nod import Nod
from simulation_tools.world.world import BodyState

PACKAGE = Path(__file__).resolve().parents[2]
IRIS = load_model("model://iris", [PACKAGE / "models"])
STEP_S = 0.004
NOD = Nod(0.6, 2.0, sweeps=2)


def angles_of(gimbal, body, steps):
    """Roll and pitch of the hinges (steps, 2), step by step."""
    found = []
    for _ in range(steps):
        gimbal.step(body.orientation_xyzw, STEP_S)
        found.append(gimbal.angles_rad)
    return np.array(found)


@pytest.mark.table(("roll", "pitch"), [(0.0, 0.0), (0.05, -0.1)])
def test_a_nod_is_a_sine_about_level_in_pitch_then_in_roll(roll, pitch):
    gimbal, body = Gimbal.from_sdf(IRIS), Pose.from_xyz_rpy(0.0, 0.0, 0.0, roll, pitch)
    gimbal.switch(True)
    level = angles_of(gimbal, body, 10)[-1]  # the lean is taken back
    gimbal.start_nod(NOD)
    found = angles_of(gimbal, body, 1050) - level
    times_s = STEP_S * np.arange(1, 1001)
    sine = 0.6 * np.sin(math.pi * times_s)
    np.testing.assert_allclose(found[:499, 1], sine[:499], atol=1e-9)
    np.testing.assert_allclose(found[501:999, 0], sine[501:999], atol=1e-9)
    np.testing.assert_allclose(found[:499, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(found[501:999, 1], 0.0, atol=1e-12)
    np.testing.assert_allclose(found[1000:], 0.0, atol=1e-12)  # after two sweeps it is over
    assert gimbal.nod is None


def test_a_nod_that_is_told_to_end_is_level_within_the_gimbals_rate():
    gimbal, body = Gimbal.from_sdf(IRIS), Pose.identity()
    gimbal.start_nod(NOD)
    angles_of(gimbal, body, 125)  # a quarter: 0.6 rad down
    assert gimbal.angles_rad == pytest.approx((0.0, 0.6))
    gimbal.start_nod(Nod(0.0, 2.0))
    angles_of(gimbal, body, 15)  # 0.06 s at 10 rad/s
    assert gimbal.angles_rad == pytest.approx((0.0, 0.0), abs=1e-9)


@pytest.mark.table(("nod", "words"), [(Nod(0.9, 4.0), "too wide"), (Nod(0.7, 0.4), "longer period")])
def test_what_the_gimbal_cannot_do_is_refused_and_changes_nothing(nod, words):
    gimbal = Gimbal.from_sdf(IRIS)
    with pytest.raises(GimbalError, match=words):
        gimbal.start_nod(nod)
    assert not gimbal.is_active


def test_a_uav_without_a_gimbal_cannot_nod():
    empty = str(PACKAGE / "worlds" / "empty.world")
    simulation = Simulation(SimulationParameters(empty, model="reference_quad"))
    with pytest.raises(SimulationError, match="no gimbal"):
        simulation.nod_lidar(NOD)
    simulation.close()


ROOM = """<?xml version="1.0"?><sdf version="1.6"><world name="room"><model name="room"><static>true</static>
<link name="link">{}</link></model></world></sdf>"""
BOX = '<collision name="{}"><pose>{} 0 0 0</pose><geometry><box><size>{}</size></box></geometry></collision>'
HALF_M = np.array((4.0, 3.0, 2.0))
"""Of the inside of the room, whose middle is at (0, 0, 2)."""


@pytest.fixture
def in_a_room(tmp_path):
    """A simulation with a UAV in the middle of a closed room of 8 x 6 x 4 m, with a lidar without noise."""
    sides = (
        ("ahead", "4.1 0 2", "0.2 8 5"),
        ("behind", "-4.1 0 2", "0.2 8 5"),
        ("left", "0 3.1 2", "10 0.2 5"),
        ("right", "0 -3.1 2", "10 0.2 5"),
        ("floor", "0 0 -0.1", "10 8 0.2"),
        ("ceiling", "0 0 4.1", "10 8 0.2"),
    )
    world = tmp_path / "room.world"
    world.write_text(ROOM.format("".join(BOX.format(*side) for side in sides)))
    given = SimulationParameters(str(world), lidar="ust", lidar_noise_factor=0.0)
    simulation = Simulation(given)
    yield simulation
    simulation.close()


def test_the_scans_of_a_nod_lie_on_walls_floor_and_ceiling_of_a_room(in_a_room):
    simulation = in_a_room
    body = Pose.from_xyz_rpy(0.0, 0.0, 1.9, 0.02, -0.03, 0.4)
    simulation.nod_lidar(Nod(0.7, 1.0, sweeps=2))
    ends = []
    for _ in range(250):
        simulation.world.set_state("iris", BodyState(body))
        simulation.models_moved()
        simulation.gimbal.step(body.orientation_xyzw, 0.008)
        simulation._sensors.aim_lidar()
        ranges = simulation.lidar.scan(simulation.world.rays, body, "iris")
        pose = body @ simulation.lidar.pose_in_body
        ends.append(pose.position_m + ranges[:, None] * (simulation.lidar.directions @ pose.rotation.T))
    beyond = np.abs(np.concatenate(ends) - (0.0, 0.0, 2.0)) - HALF_M
    assert np.abs(beyond.max(axis=1)).max() < 0.002  # the lidar rounds to a millimetre
    is_on = np.abs(beyond) < 0.002
    assert (is_on.mean(axis=0) > (0.2, 0.2, 0.1)).all()  # walls both ways, and floor with ceiling
