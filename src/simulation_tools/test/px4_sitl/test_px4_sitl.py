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

from simulation_tools.autopilot import Px4Error, VehicleState
from simulation_tools.geometry import Pose
from simulation_tools.px4_sitl.hil_sensors import HilParameters, HilSensors
from simulation_tools.px4_sitl.own_links import OwnLinks
from simulation_tools.px4_sitl.px4_sitl import Px4Sitl
from simulation_tools.px4_sitl.simulator_link import SimulatorLink
from simulation_tools.running.pacing import PacingParameters
from simulation_tools.running.run_loop import RunLoop
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


def test_a_reset_parts_with_px4_and_a_strict_peer_then_hovers_at_2_m(simulation, start_peer):
    """Real PX4 cannot be reset, nor see its clock go back: it is started again, and flies from its start."""
    said = []
    simulation.autopilot.on_warning = said.append
    peer = start_peer(9.0)
    while not simulation.autopilot.answers:
        simulation.step()
    while simulation.world.get_state("iris").pose.position_m[2] < 1.0:
        simulation.step()
        assert simulation.time_us < 20e6, "the peer does not fly"
    simulation.reset()
    assert "start it again" in said[0]
    peer.wait(60.0)
    assert simulation.world.get_state("iris").pose.position_m[2] < 0.3
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


def test_px4s_clock_is_simulated_time_whenever_it_connects(simulation, start_peer):
    for _ in range(500):
        simulation.step()
    peer = start_peer(1.2)
    while not simulation.autopilot.answers:
        simulation.step()
    before_us = simulation.time_us
    report = run_until_ended(simulation, peer)
    assert report["violations"] == []
    assert before_us <= report["ended_us"] <= simulation.time_us


def test_px4_thinks_while_the_simulator_does_other_work(link):
    """The measurement of an instant is on its way before `step` asks for the answer."""
    autopilot = Px4Sitl(link, HilParameters(), np.random.default_rng(1))
    with socket.create_connection(("127.0.0.1", link.port)) as px4:
        px4.settimeout(20.0)
        while not link.connected:
            autopilot.begin(VehicleState(4000))
        mav = common.MAVLink(None, srcSystem=1, srcComponent=1)
        kinds = [message.get_type() for message in mav.parse_buffer(px4.recv(65536))]
        assert "HIL_SENSOR" in kinds
        answer = common.MAVLink_hil_actuator_controls_message(4000, [0.25] * 16, 129, 1)
        px4.sendall(answer.pack(mav))
        assert autopilot.step(VehicleState(4000)) == pytest.approx([0.25] * 4)
        px4.settimeout(0.05)
        with pytest.raises(socket.timeout):
            px4.recv(65536)  # the same instant is not sent twice


def test_a_px4_that_does_not_come_is_asked_for_by_its_start(link, monkeypatch):
    said, now_s = [], [1000.0]
    monkeypatch.setattr("simulation_tools.px4_sitl.px4_sitl.time.monotonic", lambda: now_s[0])
    autopilot = Px4Sitl(link, HilParameters(), np.random.default_rng(1))
    autopilot.on_warning = said.append
    for step in range(70):
        now_s[0] += 0.5
        autopilot.step(VehicleState(4000 * step))
    assert 3 <= len(said) <= 4  # every 10 s of 35
    assert f"connects to TCP port {link.port}" in said[0]


def test_time_waits_for_px4_and_not_for_ever(link, monkeypatch):
    """Real PX4's clock begins with its first measurement: so does simulated time."""
    now_s = [1000.0]
    monkeypatch.setattr("simulation_tools.px4_sitl.px4_sitl.time.monotonic", lambda: now_s[0])
    autopilot = Px4Sitl(link, HilParameters(), np.random.default_rng(1), patience_s=60.0)
    assert not autopilot.is_ready()
    now_s[0] += 59.0
    assert not autopilot.is_ready()
    now_s[0] += 2.0
    with pytest.raises(Px4Error, match=r"within 60 s.*connects to TCP port"):
        autopilot.is_ready()
    with socket.create_connection(("127.0.0.1", link.port)):
        while not autopilot_comes(autopilot):
            pass
        now_s[0] += 1000.0
        assert autopilot.is_ready()


def autopilot_comes(autopilot):
    """Whether it has connected; the connection may take a moment."""
    try:
        return autopilot.is_ready()
    except Px4Error:
        return False


def test_the_loop_begins_with_px4(link, simulation):
    class Output:
        def publish(self, output):
            times_us.append(output.time_us)

        def report(self, figures, paused):
            pass

    times_us, asked = [], [0]
    loop = RunLoop(simulation, OwnLinks(), Output(), PacingParameters(real_time_factor=0.0))

    def enough():
        asked[0] += 1
        return asked[0] > 20 or len(times_us) > 10

    loop.run(enough)
    assert times_us == [0]  # the first instant is told; then time waits
    asked[0] = 0
    with socket.create_connection(("127.0.0.1", link.port)):
        RunLoop(simulation, OwnLinks(), Output(), PacingParameters(real_time_factor=0.0)).run(enough)
    assert times_us[-1] > 0


def test_garbage_on_the_link_is_counted_and_harmless(link):
    with socket.create_connection(("127.0.0.1", link.port)) as peer:
        while not link.accept():
            pass
        heartbeat = common.MAVLink_heartbeat_message(0, 12, 0, 0, 0, 3).pack(common.MAVLink(None, 1, 1))
        peer.sendall(b"\x00garbage\xfd\x05" + bytes(heartbeat)[:7] + b"x" * 30 + bytes(heartbeat) * 3)
        kinds = [message.get_type() for message in link.receive(1.0)]
    assert "HEARTBEAT" in kinds
    assert link.bad > 0


def test_an_impact_is_felt_whole_but_never_beyond_what_px4_measures():
    """At touch-down a rigid body stops in one step; PX4 takes 16 g for clipping, more for its opposite."""
    sensors = HilSensors(HilParameters(accelerometer_noise_m_s2=1e-6), np.random.default_rng(0))
    forces = [(0.0, 0.0, 9.81)] * 5 + [(30.0, -170.0, 9.81 + 0.9 / 0.004)] + [(0.0, 0.0, 9.81)] * 20
    felt = []
    for step, force in enumerate(forces):
        m = sensors.sensor(VehicleState(4000 * step, specific_force_body_m_s2=force), 4000 * (step + 1))
        felt.append((m.xacc, m.yacc, m.zacc))
    felt = np.array(felt)
    assert np.all(np.abs(felt) < 0.6 * 16 * 9.80665)
    true = np.array(forces) * (1.0, -1.0, -1.0)  # FLU to FRD
    assert felt.sum(axis=0) == pytest.approx(true.sum(axis=0), abs=1e-3)
    assert felt[:5] == pytest.approx(true[:5], abs=1e-4)  # untouched before
    assert felt[12:] == pytest.approx(true[12:], abs=1e-4)  # and soon after


def test_the_limit_leaves_flight_as_it_is():
    sensors = HilSensors(HilParameters(accelerometer_noise_m_s2=1e-6), np.random.default_rng(0))
    for step in range(500):
        force = (6.0 * math.sin(0.1 * step), 5.0, 9.81 + 8.0 * math.cos(0.3 * step))  # 0.8 g more or less
        m = sensors.sensor(VehicleState(4000 * step, specific_force_body_m_s2=force), 4000 * (step + 1))
        assert (m.xacc, -m.yacc, -m.zacc) == pytest.approx(force, abs=1e-4)


def test_without_gnss_px4_gets_no_fix():
    sensors = HilSensors(HilParameters(gnss=False), np.random.default_rng(0))
    assert all(sensors.gps(VehicleState(t_us), t_us) is None for t_us in range(4000, 1_000_000, 4000))


def test_gps_is_late_by_its_delay_in_closed_form():
    sensors = HilSensors(HilParameters(), np.random.default_rng(0))
    fixes = []
    for time_us in range(4000, 2_000_000, 4000):
        rising = VehicleState(time_us, Pose((0.0, 0.0, 1e-6 * time_us)))  # 1 m/s
        fixes.append((time_us, sensors.gps(rising, time_us)))
    late_s = [1e-6 * t - (1e-3 * fix.alt - 488.0) for t, fix in fixes if fix and t > 200_000]
    assert late_s == pytest.approx([0.11] * len(late_s), abs=0.004 + 5e-4)
