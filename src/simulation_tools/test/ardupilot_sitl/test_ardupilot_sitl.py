"""ArduPilot's JSON physics link, against a fake program; and the program itself where there is one."""

from __future__ import annotations

import json
import math
import os
import re
import signal
import socket
import struct
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest

from node_tools.ending import CLOSING_S
from simulation_tools.ardupilot_sitl.ardupilot_sitl import ArduPilotSitl
from simulation_tools.ardupilot_sitl.json_link import JsonLink, frame_of
from simulation_tools.ardupilot_sitl.json_sensors import JsonSensorParameters, JsonSensors
from simulation_tools.ardupilot_sitl.program import ENVIRONMENT, Program, ProgramParameters, check_program
from simulation_tools.autopilot import AutopilotError, VehicleState
from simulation_tools.geometry import Pose
from simulation_tools.sensors.impacts import ImpactLimiter
from simulation_tools.simulation import Simulation, SimulationParameters

HERE = Path(__file__).resolve().parent
PACKAGE = HERE.parents[1]
FAKE = HERE / "fake_arducopter.py"
QUIET = JsonSensorParameters(accelerometer_noise_m_s2=0.0, gyroscope_noise_rad_s=0.0)


def packet(count, magic=18458, channels=16, pulse=1500):
    return struct.pack(f"<HHI{channels}H", magic, 1200, count, *[pulse] * channels)


def sensors():
    return JsonSensors(QUIET, np.random.default_rng(1))


def state(time_us, **changes):
    return VehicleState(time_us, **changes)


@pytest.fixture
def link():
    link = JsonLink(port=0)
    link.said = []
    link.on_warning = link.said.append
    yield link
    link.close()


@pytest.fixture
def peer(link):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.connect(("127.0.0.1", link.port))
        peer.settimeout(2.0)
        yield peer


@pytest.fixture
def start(link, tmp_path, monkeypatch):
    """Returns an `ArduPilotSitl` with the fake program, which obeys the given variables."""
    autopilots = []

    def start(path=FAKE, **variables):
        monkeypatch.setenv("FAKE_RESULTS", str(tmp_path))
        for name, value in variables.items():
            monkeypatch.setenv(name, str(value))
        program = Program(ProgramParameters(str(path)), link.port)
        autopilots.append(ArduPilotSitl(link, sensors(), program))
        return autopilots[-1]

    yield start
    for one in autopilots:
        one.close()


def wait_until_ready(autopilot):
    end_s = time.monotonic() + 60.0
    while not autopilot.is_ready():
        assert time.monotonic() < end_s
        time.sleep(0.01)


def test_a_frame_is_read_whether_it_has_16_or_32_channels():
    assert frame_of(packet(7)) == (1200, 7, (1500,) * 16)
    assert frame_of(packet(7, magic=29569, channels=32)).pulses_us == (1500,) * 32


@pytest.mark.parametrize(
    "garbage", [b"", b"\x00" * 40, b"x" * 1000, packet(1)[:-1], packet(1, magic=4711), b"\n{}\n"]
)
def test_garbage_is_ignored_with_one_sentence(link, peer, garbage):
    """A physics that also believes itself the server would send JSON: the roles are not PX4's."""
    for _ in range(3):
        peer.send(garbage)
    peer.send(packet(0))
    assert link.receive(2.0).number == 0
    assert len(link.said) == 1
    assert f"{len(garbage)} bytes that are no servo outputs" in link.said[0]


def test_a_repeated_frame_gets_one_answer(link, peer):
    for _ in range(3):
        peer.send(packet(5))
    assert link.receive(2.0).number == 5
    assert link.receive(0.05) is None
    peer.send(packet(6))
    assert link.receive(2.0).number == 6


def test_a_second_ardupilot_on_the_port_is_ignored_with_a_sentence(link, peer):
    peer.send(packet(0))
    assert link.receive(2.0) is not None
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.sendto(packet(1), ("127.0.0.1", link.port))
        assert link.receive(0.1) is None
    assert "second ArduPilot" in link.said[0]


def test_a_line_tells_the_range_below_twenty_times_a_second():
    given = iter([1.5, math.inf, -math.inf])
    told = sensors()
    assert "rng_1" not in json.loads(told.line(state(0), state(1000), 1000))
    told.look_down = lambda: next(given)
    ranges = [json.loads(told.line(state(0), state(t), t))["rng_1"] for t in range(1000, 150_000, 10_000)]
    # Five answers for each reading: it meets something, then nothing, then it is too close
    assert ranges == [1.5] * 5 + [1000.0] * 5 + [0.0] * 5


def test_a_line_tells_the_state_in_ned_and_frd():
    yaw_rad = 0.3  # from east, counter-clockwise
    before = state(0, pose=Pose.from_xyz_rpy(1.0, 2.0, 3.0, yaw=yaw_rad))
    now = state(
        4000,
        pose=Pose.from_xyz_rpy(1.4, 2.0, 3.0, yaw=yaw_rad),
        velocity_world_m_s=(4.0, 0.0, 0.0),
        angular_velocity_body_rad_s=(0.1, 0.2, 0.4),
        specific_force_body_m_s2=(1.0, 2.0, 9.8),
    )
    said = json.loads(sensors().line(before, now, 1000))
    assert said["timestamp"] == pytest.approx(1e-3, rel=1e-6)
    assert said["timestamp"] > 1e-3  # ArduPilot cuts to whole microseconds
    assert said["position"] == pytest.approx([2.0, 1.1, -3.0])
    assert said["velocity"] == pytest.approx([0.0, 1.0, 0.0])
    assert said["imu"]["gyro"] == pytest.approx([0.025, -0.05, -0.1])
    assert said["imu"]["accel_body"] == pytest.approx([1.0, -2.0, -9.8])
    w, x, y, z = said["quaternion"]
    assert (x, y) == pytest.approx((0.0, 0.0))
    assert 2.0 * math.atan2(z, w) == pytest.approx(0.5 * math.pi - yaw_rad)  # from north, clockwise
    assert said["no_time_sync"] == 1


def test_an_impact_is_spread_and_its_sum_stays():
    limiter = ImpactLimiter(80.0)
    felt = [limiter.felt(np.array([0.0, 0.0, 200.0 if i == 0 else 10.0]))[2] for i in range(5)]
    assert max(felt) == 80.0
    assert sum(felt) == pytest.approx(200.0 + 4 * 10.0)


def test_each_step_is_four_frames_in_lockstep(start, tmp_path):
    autopilot = start(FAKE_FRAMES=40)
    wait_until_ready(autopilot)
    assert autopilot.step(state(0)) == pytest.approx([0.0, 0.01, 0.02, 0.03])
    for step in range(1, 10):
        now = state(4000 * step)
        autopilot.begin(now)
        if step == 5:
            time.sleep(0.3)  # it asks again for a frame that was answered late: no answer too many
        autopilot.step(now)
    autopilot.begin(state(40_000))
    last = state(40_000)
    while autopilot._program.runs and not (tmp_path / "heard.json").exists():
        autopilot.step(last)
    heard = json.loads((tmp_path / "heard.json").read_text())
    stamps_us = [round(1e6 * line["timestamp"]) for line in heard["lines"]]
    assert stamps_us == list(range(1000, 41_000, 1000))
    assert not heard["surplus"]
    assert heard["options"]["model"] == "JSON"


def test_the_world_goes_on_when_ardupilot_ends_and_it_is_started_again(start):
    said = []
    autopilot = start(FAKE_FRAMES=4)
    autopilot.on_warning = said.append
    wait_until_ready(autopilot)
    autopilot.step(state(0))
    first = autopilot._program._process.pid
    autopilot.begin(state(4000))
    end_s = time.monotonic() + 60.0
    time_us = 4000
    while autopilot._program._process is None or autopilot._program._process.pid == first:
        assert time.monotonic() < end_s
        autopilot.step(state(time_us))
        time_us += 4000
    assert "The rotors stop, and it is started again" in said[0]


def test_after_a_reset_the_new_program_is_heard_and_not_the_old_one(start):
    """The new one's frames would count as old ones, for its numbers begin again."""
    autopilot = start(FAKE_STAYS=1)
    for _ in range(2):
        said = []
        autopilot.on_warning = said.append
        wait_until_ready(autopilot)
        for step in range(20):
            autopilot.step(state(4000 * step))
        assert said == []
        assert autopilot._told_us == 4000 * 19
        autopilot.reset()


@pytest.mark.parametrize("ends_by", ["close", "reset"])
def test_nothing_is_left_of_an_ardupilot_that_waits_for_its_physics(start, tmp_path, monkeypatch, ends_by):
    """A node has `CLOSING_S` for its end, and ArduPilot does not obey SIGTERM then."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    autopilot = start(FAKE_STAYS=1)
    assert not list(tmp_path.iterdir())  # nothing is started before the simulation runs
    wait_until_ready(autopilot)
    (folder,), process = tmp_path.glob("ardupilot_*"), autopilot._program._process
    begun_s = time.monotonic()
    getattr(autopilot, ends_by)()
    assert time.monotonic() - begun_s < 0.8 * CLOSING_S
    assert process.returncode == -signal.SIGKILL
    assert not folder.exists()


def test_a_program_that_a_script_has_started_ends_with_it(start, tmp_path):
    script = tmp_path / "arducopter"
    script.write_text(f'#!/bin/sh\n{FAKE} "$@" &\necho $! > {tmp_path}/pid\nwait\n')
    script.chmod(0o755)
    autopilot = start(script)
    wait_until_ready(autopilot)
    pid = (tmp_path / "pid").read_text().strip()
    assert runs(pid)
    autopilot.close()
    end_s = time.monotonic() + 60.0
    while runs(pid):
        assert time.monotonic() < end_s
        time.sleep(0.01)


def runs(pid):
    """Whether a process is there, and not only waits for somebody to read its exit status."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] not in "ZX"
    except OSError:
        return False


def test_a_program_that_ends_at_once_is_an_error_with_its_last_words(start):
    autopilot = start(FAKE_EXIT=1, FAKE_SAYS="Vehicle model (JSON) not found")
    with pytest.raises(AutopilotError, match=r"exit status 1.*Vehicle model .JSON. not found.*4\.6"):
        wait_until_ready(autopilot)


def test_an_ardupilot_that_asks_for_nothing_is_an_error_after_the_patience(link):
    autopilot = ArduPilotSitl(link, sensors(), None, patience_s=0.05)
    assert not autopilot.is_ready()
    with pytest.raises(AutopilotError, match=rf"UDP port {link.port} within 0\.05 s"):
        wait_until_ready(autopilot)


def test_the_console_is_kept_apart_from_mavlink():
    command = Program(ProgramParameters(str(FAKE), offboard_port=14541, gcs_port=14551), 9012).command(FAKE)
    assert "--serial0=none:" in command  # ArduPilot prints its banner there
    assert "--serial1=udpclient:127.0.0.1:14541" in command
    assert "--serial2=udpclient:127.0.0.1:14551" in command


def test_parameters_that_a_version_does_not_know_are_named(start):
    autopilot = start(FAKE_SAYS="Ignored unknown param GPS1_TYPE in defaults file x", FAKE_FRAMES=1)
    wait_until_ready(autopilot)
    assert autopilot._program.unknown_parameters() == ["GPS1_TYPE"]


@pytest.mark.table(("path", "says"), [("", "ardupilot:="), ("/nowhere", "not there"), (__file__, "executed")])
def test_a_program_that_is_not_there_is_one_sentence(path, says):
    with pytest.raises(AutopilotError, match=says) as caught:
        check_program(path)
    assert str(caught.value).count(". ") == 0


@pytest.mark.table(
    ("content", "why"),
    [
        (Path("/bin/true").read_bytes(), "it does not know the option --sim-port-out"),
        (
            b"\x7fELF\x01\x01\x01" + bytes(60),
            "it does not know the option --sim-port-out",
        ),  # built for a board
        (b"arducopter\n", "it is neither a program nor a script"),
        (b"", "it is empty"),
        (b"#!/nowhere/sh\n", "its first line names a program that is not there"),
        (b"#!\n", "its first line names a program that is not there"),
        (b"\x7fELF and somewhere --sim-port-out", None),
        (b"#! /bin/sh -e\nexec arducopter $@\n", None),
    ],
)
def test_what_cannot_be_arducopter_is_refused_before_it_is_started(tmp_path, content, why):
    program = tmp_path / "arducopter"
    program.write_bytes(content)
    program.chmod(0o755)
    if why is None:
        check_program(str(program))
        return
    with pytest.raises(AutopilotError, match=re.escape(f"built for the board sitl: {why}; ")):
        check_program(str(program))


@pytest.mark.skipif(
    not os.access(os.environ.get(ENVIRONMENT, ""), os.X_OK),
    reason=f"{ENVIRONMENT} does not name ArduPilot's program (doc/ardupilot.md)",
)
def test_real_ardupilot_runs_in_lockstep():
    link = JsonLink(port=0)
    files = (str(PACKAGE / "config/ardupilot.parm"),)
    program = Program(ProgramParameters(os.environ[ENVIRONMENT], files), link.port)
    autopilot = ArduPilotSitl(link, sensors(), program, patience_s=30.0)
    world = str(PACKAGE / "worlds/empty.world")
    simulation = Simulation(SimulationParameters(world=world, lidar=None), autopilot)
    said = []
    autopilot.on_warning = said.append
    try:
        wait_until_ready(autopilot)
        for _ in range(1000):
            simulation.step()
        assert autopilot.answers
        assert said == []
    finally:
        simulation.close()
