"""PX4 SITL's simulator protocol, against a strict peer in a process of its own that flies by it."""

from __future__ import annotations

import json
import math
import socket
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import common

from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Pose
from simulation_tools.mavlink import LinkError
from simulation_tools.px4.autopilot import VehicleState
from simulation_tools.px4_sitl.hil_sensors import HilParameters, HilSensors
from simulation_tools.px4_sitl.px4_sitl import Px4Sitl
from simulation_tools.px4_sitl.simulator_link import SimulatorLink
from simulation_tools.simulation import Simulation, SimulationParameters

HERE = Path(__file__).resolve().parent
EMPTY = str(HERE.parents[1] / "worlds" / "empty.world")


@pytest.fixture
def link():
    link = SimulatorLink(port=0)
    yield link
    link.close()


@pytest.fixture
def simulation(link):
    autopilot = Px4Sitl(link, HilParameters(), np.random.default_rng(1))
    parameters = SimulationParameters(world=EMPTY, lidar=None, spawn_pose=Pose.from_xyz_rpy(0, 0, 0, yaw=0.7))
    simulation = Simulation(parameters, autopilot)
    yield simulation
    simulation.close()


@pytest.fixture
def start_peer(link):
    started = []

    def start(seconds):
        command = [sys.executable, str(HERE / "protocol_peer.py"), str(link.port), str(seconds)]
        started.append(subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True))
        return started[-1]

    yield start
    for peer in started:
        peer.kill()
        peer.communicate()


def run_until_ended(simulation, peer, most_s=60.0):
    while peer.poll() is None:
        simulation.step()
        assert simulation.time_us < 1e6 * most_s, "the peer does not end"
    said, complaints = peer.communicate()
    assert peer.returncode == 0, complaints
    return json.loads(said)


def test_a_strict_peer_finds_nothing_wrong_and_hovers_at_2_m(simulation, start_peer):
    report = run_until_ended(simulation, start_peer(14.0))
    assert report["violations"] == []
    assert report["counts"]["HIL_SENSOR"] == pytest.approx(3500, abs=2)
    assert report["counts"]["HIL_STATE_QUATERNION"] == pytest.approx(1750, abs=10)  # 5 ms: every other step
    low_us, high_us = report["gps_gaps_us"]
    assert 46_000 <= low_us <= high_us <= 54_000  # 20 Hz, on steps of 4 ms
    assert report["gps_late_s"] == pytest.approx(0.11, abs=0.012)
    assert report["place_m"] == pytest.approx([1.0, 0.0, 2.0], abs=0.2)  # north, east, up
    east_m, north_m, _ = simulation.world.get_state("iris").pose.position_m
    assert (north_m, east_m) == pytest.approx((1.0, 0.0), abs=0.3)  # it has fallen since
    assert report["speed_cm_s"] < 20.0


def test_without_px4_the_world_goes_on_and_the_rotors_stand(simulation):
    for _ in range(50):
        simulation.step()
    assert simulation.time_us == 200_000
    assert simulation.world.get_state("iris").pose.position_m[2] < 0.3
    assert not simulation.autopilot.answers


def test_when_px4_dies_the_rotors_stop_and_another_one_may_come(simulation, start_peer):
    said = []
    simulation.autopilot.on_warning = said.append
    run_until_ended(simulation, start_peer(1.5))
    simulation.step()
    assert np.all(simulation.autopilot.step(VehicleState(simulation.time_us)) == 0.0)
    assert any("start PX4 again" in sentence for sentence in said)
    assert run_until_ended(simulation, start_peer(1.2))["violations"] == []


def test_time_never_goes_back_for_px4_when_the_simulation_is_reset(simulation, start_peer):
    said = []
    simulation.autopilot.on_warning = said.append
    peer = start_peer(2.0)
    while not simulation.autopilot.answers:
        simulation.step()
    for _ in range(20):
        simulation.step()
    simulation.reset()
    assert "reset" in said[0]
    assert not any(
        "time went on" in violation for violation in run_until_ended(simulation, peer)["violations"]
    )


def test_a_port_already_taken_is_one_sentence(link):
    with pytest.raises(
        LinkError, match=rf"Cannot listen on TCP 127.0.0.1:{link.port} .* choose another port"
    ):
        SimulatorLink(port=link.port)


def test_garbage_on_the_link_is_counted_and_harmless(link):
    with socket.create_connection(("127.0.0.1", link.port)) as peer:
        while not link.accept():
            pass
        heartbeat = common.MAVLink_heartbeat_message(0, 12, 0, 0, 0, 3).pack(common.MAVLink(None, 1, 1))
        peer.sendall(b"\x00garbage\xfd\x05" + bytes(heartbeat)[:7] + b"x" * 30 + bytes(heartbeat) * 3)
        kinds = [message.get_type() for message in link.receive(1.0)]
    assert "HEARTBEAT" in kinds
    assert link.bad > 0


@pytest.mark.parametrize("name", ["accelerometer_noise_m_s2", "pressure_noise_pa", "gps_rate_hz"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_parameters_that_px4_would_take_for_dead_sensors_are_refused(name, value):
    with pytest.raises(SimulationToolsError, match=name):
        HilParameters(**{name: value})


def test_gps_is_late_by_its_delay_in_closed_form():
    sensors = HilSensors(HilParameters(), np.random.default_rng(0))
    fixes = []
    for time_us in range(4000, 2_000_000, 4000):
        rising = VehicleState(time_us, Pose((0.0, 0.0, 1e-6 * time_us)))  # 1 m/s
        fixes.append((time_us, sensors.gps(rising, time_us)))
    late_s = [1e-6 * t - (1e-3 * fix.alt - 488.0) for t, fix in fixes if fix and t > 200_000]
    assert late_s == pytest.approx([0.11] * len(late_s), abs=0.004 + 5e-4)
