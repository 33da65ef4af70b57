"""The MAVLink link over real UDP sockets: ports, streams, several clients at once."""

from __future__ import annotations

import contextlib
import math
import struct
from collections import Counter

import pytest
from flight import NO_NOISE, Flight
from mavlink_client import GCS, ONBOARD, Client
from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.px4.mavlink.link import MavlinkLink
from simulation_tools.px4.mavlink.telemetry import OFFBOARD_RATES_HZ
from simulation_tools.px4.modes import Severity

# A target comes while an automatic mode flies, a distance if there is a range finder.
AT_REST_HZ = {**OFFBOARD_RATES_HZ, "POSITION_TARGET_GLOBAL_INT": 0.0, "DISTANCE_SENSOR": 0.0}

# Ports


def test_both_ports_are_on_the_loopback(setup):
    sockets = (setup.link.offboard.socket, setup.link.ground.socket)
    assert [socket.getsockname()[0] for socket in sockets] == ["127.0.0.1"] * 2


def test_ports_follow_px4s_convention():
    flight = Flight.of_iris(noise=NO_NOISE)
    link = MavlinkLink(flight.px4, offboard_port=34540, gcs_port=34550)
    assert (link.offboard.port, link.ground.port) == (34580, 38570)
    link.close()


@pytest.mark.table("streams_unasked", [True, False])
def test_the_default_remote_is_served_without_asking(streams_unasked):
    """A ground station gets heartbeats only, until it sends one itself."""
    listener = Client(1)
    flight = Flight.of_iris(noise=NO_NOISE)
    own_port = listener.socket.getsockname()[1]
    ports = (own_port, 0) if streams_unasked else (0, own_port)
    link = MavlinkLink(flight.px4, *ports, offboard_local_port=0, gcs_local_port=0)
    flight.step()
    link.send_due(0)
    listener.receive()
    kinds = {message.get_type() for message in listener.inbox}
    assert "HEARTBEAT" in kinds
    assert (len(kinds) > 1) is streams_unasked
    link.close()
    listener.close()


# Streams


def test_default_rates_are_the_references(setup):
    client = setup.client()
    client.heartbeat()
    setup.run(2.0)
    client.inbox.clear()
    seconds = 10.0
    heartbeats = iter(range(10**6))
    setup.run(seconds, each=lambda: client.heartbeat() if next(heartbeats) % 500 == 0 else None)
    counts = Counter(message.get_type() for message in client.inbox)
    for name, rate in AT_REST_HZ.items():
        assert counts[name] / seconds == pytest.approx(rate, abs=max(0.01 * rate, 1.01 / seconds)), name


def test_a_receiver_that_reads_296_bytes_of_a_datagram_gets_every_message(setup):
    """MAVROS reads so many; PX4's own datagrams hold 280 at most."""
    client = setup.client()
    client.heartbeat()
    setup.run(2.0)
    client.take("")
    datagrams = []

    def read_like_mavros():
        with contextlib.suppress(BlockingIOError):
            while True:
                datagrams.append(client.socket.recv(296))

    client.receive = read_like_mavros
    seconds = 5.0
    setup.run(seconds)
    messages = [message for datagram in datagrams for message in client.codec.decode(datagram)]
    counts = Counter(message.get_type() for message in messages)
    assert client.codec.bad == 0
    assert max(map(len, datagrams)) <= 280
    assert len(datagrams) < 0.6 * len(messages)  # each datagram wakes the receiver
    assert counts["EXTENDED_SYS_STATE"] == pytest.approx(5.0 * seconds, abs=1.0)
    for name, rate in AT_REST_HZ.items():
        assert counts[name] == pytest.approx(rate * seconds, abs=max(0.01 * rate * seconds, 1.01)), name


def test_streams_carry_simulation_time_and_ned(ready):
    setup, client = ready
    setup.run(0.1)
    local = client.take("LOCAL_POSITION_NED")[-1]
    assert local.time_boot_ms == pytest.approx(setup.flight.body.time_us / 1000, abs=40)
    assert (local.x, local.y, local.z) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    setup.run(0.1)
    attitude = client.take("ATTITUDE")[-1]
    assert attitude.yaw == pytest.approx(math.pi / 2)  # facing east
    setup.run(0.1)
    imu = client.take("HIGHRES_IMU")[-1]
    assert (imu.xacc, imu.yacc, imu.zacc) == pytest.approx((0.0, 0.0, -9.8), abs=1e-5)


def test_no_local_position_before_the_estimate_is_valid(setup):
    client = setup.client()
    client.heartbeat()
    setup.run(0.48)
    assert not client.take("LOCAL_POSITION_NED")
    setup.run(0.2)
    assert client.take("LOCAL_POSITION_NED")


def test_the_arming_checks_pass_with_the_local_position(setup):
    """As PX4's SYS_STATUS: present and enabled always, healthy when it would arm."""
    client = setup.client()
    client.heartbeat()
    setup.run(0.48)
    before = client.take("SYS_STATUS")[-1]
    setup.run(0.4)
    after = client.take("SYS_STATUS")[-1]
    for status, healthy in ((before, False), (after, True)):
        bits = (status.onboard_control_sensors_present, status.onboard_control_sensors_enabled)
        assert all(word & 0x10000000 for word in bits)
        assert bool(status.onboard_control_sensors_health & 0x10000000) is healthy


def test_heartbeat_says_px4_quadrotor(ready):
    setup, client = ready
    setup.run(1.1)
    heartbeat = client.take("HEARTBEAT")[0]
    assert (heartbeat.type, heartbeat.autopilot) == (2, 12)
    assert (heartbeat.base_mode, heartbeat.custom_mode, heartbeat.system_status) == (29, 0x03040000, 3)
    assert (heartbeat.get_srcSystem(), heartbeat.get_srcComponent()) == (1, 1)


def test_message_intervals_change_and_come_back(ready):
    setup, client = ready
    assert setup.ack(client, lambda: client.command(511, 30, 100_000)) == [(511, 0)]
    client.inbox.clear()
    setup.run(2.0)
    assert len(client.take("ATTITUDE")) == pytest.approx(20, abs=1)
    setup.ack(client, lambda: client.command(511, 30, -1))
    client.inbox.clear()
    setup.run(0.5)
    assert not client.take("ATTITUDE")
    setup.ack(client, lambda: client.command(511, 30, 0))
    client.inbox.clear()
    setup.run(1.0)
    assert len(client.take("ATTITUDE")) == pytest.approx(100, abs=2)


def test_the_interval_of_the_heartbeat_and_of_unknown_messages_fails(ready):
    setup, client = ready
    assert setup.ack(client, lambda: client.command(511, 0, 100_000)) == [(511, 4)]
    assert setup.ack(client, lambda: client.command(511, 9999, 100_000)) == [(511, 4)]
    assert setup.ack(client, lambda: client.command(511, math.nan, 100_000)) == [(511, 4)]
    assert setup.ack(client, lambda: client.command(511, 30, math.nan)) == [(511, 4)]


def test_messages_can_be_requested_one_by_one(ready):
    setup, client = ready
    client.command(512, 148)
    setup.run(0.02)
    client.receive()
    kinds = [m.get_type() for m in client.inbox]
    assert "AUTOPILOT_VERSION" in kinds
    client.inbox.clear()
    client.command(410)
    setup.run(0.02)
    assert len(client.take("HOME_POSITION")) == 1
    assert setup.ack(client, lambda: client.command(512, 9999)) == [(512, 2)]


# Everything else


def test_timesync_is_answered_with_boot_time(ready):
    setup, client = ready
    client.send(mavlink.MAVLink_timesync_message(0, 777))
    setup.run(0.02)
    answers = [m for m in client.take("TIMESYNC") if m.tc1]
    assert [m.ts1 for m in answers] == [777]
    assert answers[0].tc1 == pytest.approx(1000 * setup.flight.body.time_us, abs=5e7)


def test_timesync_at_time_zero_is_answered_by_no_question(ready):
    setup, client = ready
    client.take("TIMESYNC")
    client.send(mavlink.MAVLink_timesync_message(0, 777))
    setup.link.poll(0)
    assert [m.tc1 for m in client.take("TIMESYNC") if m.ts1 == 777] == [1]


LIST_DIRECTORY, OPEN_FILE, RESET_SESSIONS = 3, 4, 2
FTP_ACK, FTP_NAK, UNKNOWN_COMMAND = 128, 129, 7


def file_request(opcode, sequence, system=1, data=b"/etc"):
    header = struct.pack("<HBBBBBxI", sequence, 0, opcode, len(data), 0, 0, 0)
    return mavlink.MAVLink_file_transfer_protocol_message(0, system, 1, (header + data).ljust(251, b"\0"))


@pytest.mark.parametrize(
    ("opcode", "answer", "data"),
    [
        (LIST_DIRECTORY, FTP_NAK, [UNKNOWN_COMMAND]),
        (OPEN_FILE, FTP_NAK, [UNKNOWN_COMMAND]),
        (99, FTP_NAK, [UNKNOWN_COMMAND]),
        (RESET_SESSIONS, FTP_ACK, []),
    ],
)
def test_file_transfers_are_refused_at_once(ready, opcode, answer, data):
    setup, client = ready
    client.send(file_request(opcode, sequence=65535))
    setup.run(0.01)
    (found,) = client.take("FILE_TRANSFER_PROTOCOL")
    sequence, _, code, size, requested = struct.unpack("<HBBBB", bytes(found.payload[:6]))
    assert (sequence, code, size, requested) == (0, answer, len(data), opcode)
    assert list(found.payload[12 : 12 + size]) == data
    assert (found.target_system, found.target_component) == (255, 190)


def test_answers_about_files_and_requests_to_others_are_not_answered(ready):
    setup, client = ready
    for message in (file_request(FTP_ACK, 1), file_request(FTP_NAK, 2), file_request(OPEN_FILE, 3, system=2)):
        client.send(message)
    setup.run(0.01)
    assert not client.take("FILE_TRANSFER_PROTOCOL")


def test_status_texts_go_to_ground_stations_only(setup):
    onboard, ground = setup.client(), setup.client(on_ground_port=True)
    onboard.heartbeat(ONBOARD)
    ground.heartbeat(GCS)
    setup.run(1.0)
    ground.command(400, 1)
    setup.run(0.05)
    assert [m.text for m in ground.take("STATUSTEXT")] == ["Armed by external command"]
    assert onboard.take("STATUSTEXT") == []


def test_after_a_reset_streams_start_again(ready):
    setup, client = ready
    setup.run(3.0)
    setup.flight.px4.reset()
    setup.link.reset()
    setup.flight.body.time_us = 0
    client.inbox.clear()
    setup.run(1.0)
    assert len(client.take("ATTITUDE")) == pytest.approx(100, abs=2)


def test_long_status_texts_come_in_chunks(setup):
    """Of 50 bytes, with the same id: so a ground station puts them together."""
    ground = setup.client(on_ground_port=True)
    ground.heartbeat(GCS)
    setup.run(0.02)
    say = setup.flight.px4.on_statustext
    say(Severity.INFO, "x" * 50 + "y" * 29 + "ü")
    say(Severity.INFO, "z" * 200)
    say(Severity.INFO, "short")
    received = ground.take("STATUSTEXT")
    assert [m.text for m in received] == ["x" * 50, "y" * 29 + "?", "z" * 50, "z" * 50, "z" * 26, "short"]
    assert [m.chunk_seq for m in received] == [0, 1, 0, 1, 2, 0]
    assert [m.id for m in received] == [1, 1, 2, 2, 2, 3]
