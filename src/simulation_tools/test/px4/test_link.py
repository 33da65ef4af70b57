"""The MAVLink link over real UDP sockets: streams, commands, parameters, several clients, nonsense."""

from __future__ import annotations

import math
import socket
from collections import Counter

import pytest
from flight import NO_NOISE, Flight
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.mavlink import Codec, LinkError, parameter_from_wire, receive_all, send
from simulation_tools.px4.mavlink_link import MavlinkLink
from simulation_tools.px4.modes import Mode, Severity
from simulation_tools.px4.telemetry import OFFBOARD_RATES_HZ

HOST = "127.0.0.1"
VELOCITY_ONLY = 0b0000_0101_1100_0111  # and a yaw rate
GCS, ONBOARD = 6, 18


class Client:
    """An ordinary MAVLink client."""

    def __init__(self, port, system=255, component=190):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((HOST, 0))
        self.socket.setblocking(False)
        self.to = (HOST, port)
        self.codec = Codec(system, component)
        self.inbox = []

    def send(self, message):
        assert send(self.socket, self.codec.pack(message), self.to)

    def send_raw(self, data):
        assert send(self.socket, data, self.to)

    def heartbeat(self, kind=ONBOARD):
        self.send(mavlink.MAVLink_heartbeat_message(kind, 8, 0, 0, 0, 3))

    def velocity(self, frame=8, mask=VELOCITY_ONLY, stamp=0, system=1, component=1, **fields):
        values = dict.fromkeys(("x", "y", "z", "vx", "vy", "vz", "afx", "afy", "afz", "yaw", "yaw_rate"), 0.0)
        values.update(fields)
        self.send(
            mavlink.MAVLink_set_position_target_local_ned_message(
                stamp, system, component, frame, mask, *values.values()
            )
        )

    def command(self, number, *params, system=1, component=1):
        padded = (*params, *(0.0,) * (7 - len(params)))
        self.send(mavlink.MAVLink_command_long_message(system, component, number, 0, *padded))

    def receive(self):
        for datagram, _ in receive_all(self.socket):
            self.inbox.extend(self.codec.decode(datagram))

    def take(self, kind):
        """Return the received messages of a kind and forget everything."""
        self.receive()
        found = [message for message in self.inbox if message.get_type() == kind]
        self.inbox.clear()
        return found

    def close(self):
        self.socket.close()


class Setup:
    """A flight with a link, stepped together."""

    def __init__(self):
        self.flight = Flight.of_iris(noise=NO_NOISE)
        self.link = MavlinkLink(self.flight.px4, offboard_port=0, gcs_port=0)
        self.warnings = []
        self.link.on_warning = self.warnings.append
        self.stamps = []
        self.link.on_setpoint = self.stamps.append
        self.clients = []

    def client(self, on_ground_port=False, **identity):
        channel = self.link.ground if on_ground_port else self.link.offboard
        client = Client(channel.port, **identity)
        self.clients.append(client)
        return client

    def run(self, seconds, each=lambda: None):
        for _ in range(round(seconds / 0.004)):
            self.link.poll(self.flight.body.time_us)
            each()
            self.flight.step()
            self.link.send_due(self.flight.body.time_us)
            for client in self.clients:
                client.receive()

    def ack(self, client, act):
        """Do something and return (command, result) of its acknowledgements."""
        client.take("COMMAND_ACK")
        act()
        self.run(0.02)
        return [(ack.command, ack.result) for ack in client.take("COMMAND_ACK")]

    def close(self):
        self.link.close()
        for client in self.clients:
            client.close()


@pytest.fixture
def setup():
    setup = Setup()
    yield setup
    setup.close()


@pytest.fixture
def ready(setup):
    """A setup after a second, and an onboard client that it knows."""
    client = setup.client()
    client.heartbeat()
    setup.run(1.0)
    client.inbox.clear()
    return setup, client


# Ports


def test_a_taken_port_is_one_sentence(setup):
    port = setup.link.offboard.port
    with pytest.raises(LinkError, match=f"127.0.0.1:{port}") as caught:
        MavlinkLink(setup.flight.px4, 0, 0, offboard_local_port=port)
    assert "\n" not in str(caught.value)


def test_ports_follow_px4s_convention():
    flight = Flight.of_iris(noise=NO_NOISE)
    link = MavlinkLink(flight.px4, offboard_port=34540, gcs_port=34550)
    assert (link.offboard.port, link.ground.port) == (34580, 38570)
    link.close()


def test_the_default_remote_is_served_without_asking():
    listener = Client(1)
    flight = Flight.of_iris(noise=NO_NOISE)
    own_port = listener.socket.getsockname()[1]
    link = MavlinkLink(flight.px4, own_port, 0, offboard_local_port=0)
    flight.step()
    link.send_due(0)
    assert listener.take("HEARTBEAT")
    link.close()
    listener.close()


# Streams


def test_default_rates_are_the_references(setup):
    client = setup.client()
    client.heartbeat()
    setup.run(2.0)
    client.inbox.clear()
    seconds = 20.0
    heartbeats = iter(range(10**6))
    setup.run(seconds, each=lambda: client.heartbeat() if next(heartbeats) % 500 == 0 else None)
    counts = Counter(message.get_type() for message in client.inbox)
    for name, rate in OFFBOARD_RATES_HZ.items():
        assert counts[name] / seconds == pytest.approx(rate, abs=max(0.01 * rate, 1.01 / seconds)), name


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


# Commands


def test_acknowledgements_are_those_of_the_reference(ready):
    setup, client = ready
    mode = mavlink.MAVLink_set_mode_message
    assert setup.ack(client, lambda: client.command(176, 1, 6)) == [(176, 1)]
    assert setup.ack(client, lambda: client.send(mode(1, 1, 6 << 16))) == [(176, 1)]
    assert setup.ack(client, lambda: client.send(mode(1, 1, 4 << 16 | 4 << 24))) == [(176, 1)]
    assert setup.ack(client, lambda: client.send(mode(1, 1, 42 << 16))) == [(176, 0)]
    assert setup.ack(client, lambda: client.command(31000)) == [(31000, 3)]
    assert setup.ack(client, lambda: client.command(400, 1, system=9)) == []
    assert setup.ack(client, lambda: client.command(400, 1, component=77)) == []
    assert setup.ack(client, lambda: client.command(400, 1, component=0)) == [(400, 0)]
    assert setup.flight.px4.status.armed


def test_offboard_is_accepted_within_27_ms_of_the_first_setpoint(ready):
    setup, client = ready
    client.velocity()
    setup.run(0.024)
    assert setup.ack(client, lambda: client.command(176, 1, 6)) == [(176, 0)]


def test_command_int_is_answered_too(ready):
    setup, client = ready
    message = mavlink.MAVLink_command_int_message(1, 1, 0, 400, 0, 0, 1, 0, 0, 0, 0, 0, 0)
    assert setup.ack(client, lambda: client.send(message)) == [(400, 0)]


@pytest.mark.parametrize(
    "fields",
    [
        {"mask": 0xFFF},
        {"vx": math.nan},
        {"x": math.nan},
        {"vz": math.inf},
        {"frame": 7},
        {"frame": 9},
        {"frame": 200},
        {"system": 2},
        {"component": 50},
    ],
)
def test_what_px4_does_not_take_for_a_setpoint(ready, fields):
    setup, client = ready
    client.velocity(**fields)
    setup.run(0.02)
    assert setup.link.statistics.setpoints == 0
    assert setup.link.statistics.refused_setpoints == 1
    assert setup.stamps == []


@pytest.mark.parametrize("frame", [1, 8])
def test_setpoints_are_reported_at_receipt_with_their_stamp(ready, frame):
    setup, client = ready
    client.velocity(frame=frame, stamp=1234)
    setup.link.wait(0.1)
    setup.link.poll(setup.flight.body.time_us)
    assert setup.stamps == [1234]


def test_a_whole_flight_over_mavlink(ready):
    setup, client = ready

    def stream():
        if setup.flight.body.time_us % 40_000 == 0:
            client.velocity(frame=1, mask=0b0000_1001_1111_1000, z=-2.0)
        if setup.flight.body.time_us % 1_000_000 == 0:
            client.heartbeat()

    setup.run(0.1, stream)
    client.command(176, 1, 6)
    setup.run(0.02, stream)
    client.command(400, 1)
    setup.run(14.0, stream)
    assert setup.flight.body.position[2] == pytest.approx(2.0, abs=0.1)
    states = {m.landed_state for m in client.take("EXTENDED_SYS_STATE")}
    assert states == {1, 2}
    client.velocity(frame=8, vx=1.0)  # the position setpoints' yaw of 0 is north, y in ENU
    setup.run(0.9)
    assert setup.flight.body.velocity[1] > 0.3
    setup.run(1.0)
    assert setup.flight.px4.status.mode is Mode.AUTO_LAND  # the stream has stopped
    setup.run(1.1)
    assert client.take("HEARTBEAT")[-1].system_status == 5


def test_attitude_targets_are_taken(ready):
    setup, client = ready
    target = mavlink.MAVLink_set_attitude_target_message
    client.send(target(5, 1, 1, 0b111, [1.0, 0.0, 0.0, 0.0], 0, 0, 0, 0.5))
    client.send(target(6, 1, 1, 0b1000_0000, [0.0] * 4, 0, 0, 0.1, 0.5))
    client.send(target(7, 1, 1, 0b111, [0.0] * 4, 0, 0, 0, 0.5))  # no rotation
    client.send(target(8, 1, 1, 0b111, [math.nan] * 4, 0, 0, 0, 0.5))
    setup.run(0.02)
    assert setup.stamps == [5, 6]


# Parameters


def test_the_whole_list_arrives_at_once_with_types(ready):
    setup, client = ready
    client.send(mavlink.MAVLink_param_request_list_message(1, 1))
    setup.run(0.1)
    values = {m.param_id: m for m in client.take("PARAM_VALUE")}
    parameters = setup.flight.px4.parameters
    assert set(values) == set(parameters)
    for name, message in values.items():
        assert parameter_from_wire(message.param_value, message.param_type) == pytest.approx(parameters[name])
        assert message.param_count == len(parameters)


def test_set_is_echoed_and_has_effect_and_bad_values_change_nothing(ready):
    setup, client = ready
    send_set = mavlink.MAVLink_param_set_message
    for value, expected in ((1.5, 1.5), (99.0, 1.5), (math.nan, 1.5)):
        client.send(send_set(1, 1, b"MPC_XY_P", value, 9))
        setup.run(0.02)
        assert [m.param_value for m in client.take("PARAM_VALUE")] == [expected]
    assert setup.flight.px4.parameters["MPC_XY_P"] == 1.5


def test_unknown_parameters_are_not_answered(ready):
    setup, client = ready
    read = mavlink.MAVLink_param_request_read_message
    for name, index in ((b"NO_SUCH", -1), (b"", 9999), (b"\xff\xfe", -1)):
        client.send(read(1, 1, name, index))
    client.send(mavlink.MAVLink_param_set_message(1, 1, b"NO_SUCH", 1.0, 9))
    setup.run(0.02)
    assert client.take("PARAM_VALUE") == []
    client.send(read(1, 1, b"COM_OBL_ACT", -1))
    setup.run(0.02)
    assert [m.param_id for m in client.take("PARAM_VALUE")] == ["COM_OBL_ACT"]


# Everything else


def test_timesync_is_answered_with_boot_time(ready):
    setup, client = ready
    client.send(mavlink.MAVLink_timesync_message(0, 777))
    setup.run(0.02)
    answers = [m for m in client.take("TIMESYNC") if m.tc1]
    assert [m.ts1 for m in answers] == [777]
    assert answers[0].tc1 == pytest.approx(1000 * setup.flight.body.time_us, abs=5e7)


def test_there_is_no_mission(ready):
    setup, client = ready
    client.send(mavlink.MAVLink_mission_request_list_message(1, 1))
    setup.run(0.02)
    assert [m.count for m in client.take("MISSION_COUNT")] == [0]


def test_status_texts_go_to_ground_stations_only(setup):
    onboard, ground = setup.client(), setup.client(on_ground_port=True)
    onboard.heartbeat(ONBOARD)
    ground.heartbeat(GCS)
    setup.run(1.0)
    ground.command(400, 1)
    setup.run(0.05)
    assert [m.text for m in ground.take("STATUSTEXT")] == ["Armed by external command"]
    assert onboard.take("STATUSTEXT") == []


def test_several_clients_are_served_at_once(setup):
    clients = [setup.client(), setup.client(), setup.client(on_ground_port=True)]
    for client in clients:
        client.heartbeat()
    setup.run(1.5)
    for client in clients:
        assert client.take("LOCAL_POSITION_NED")


def test_after_a_reset_streams_start_again(ready):
    setup, client = ready
    setup.run(3.0)
    setup.flight.px4.reset()
    setup.link.reset()
    setup.flight.body.time_us = 0
    client.inbox.clear()
    setup.run(1.0)
    assert len(client.take("ATTITUDE")) == pytest.approx(100, abs=2)


def test_long_status_texts_are_cut(setup):
    ground = setup.client(on_ground_port=True)
    ground.heartbeat(GCS)
    setup.run(0.02)
    setup.flight.px4.on_statustext(Severity.INFO, "x" * 80 + "ü")
    assert [m.text for m in ground.take("STATUSTEXT")] == ["x" * 50]


# Nonsense

valid = Codec(255, 190).pack(mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
headers = st.tuples(st.sampled_from([b"\xfd", b"\xfe"]), st.binary(max_size=300)).map(b"".join)
truncated = st.integers(0, len(valid) - 1).map(lambda n: valid[:n])
flipped = st.tuples(st.integers(0, len(valid) - 1), st.integers(1, 255)).map(
    lambda flip: valid[: flip[0]] + bytes([valid[flip[0]] ^ flip[1]]) + valid[flip[0] + 1 :]
)
nonsense = st.one_of(st.binary(max_size=400), headers, truncated, flipped)


@pytest.fixture(scope="module")
def one_setup():
    setup = Setup()
    setup.run(0.1)
    yield setup
    setup.close()


@settings(max_examples=500, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(nonsense)
def test_nonsense_is_counted_and_never_harms(one_setup, data):
    setup = one_setup
    client = setup.clients[0] if setup.clients else setup.client()
    before = setup.link.statistics.bad_packets
    client.send_raw(data)
    client.velocity(stamp=1)
    setup.link.poll(0)
    assert setup.stamps.pop() == 1  # the next datagram is read as if nothing had been
    assert not setup.flight.px4.status.armed
    assert setup.link.statistics.bad_packets > before or not data or b"\xfd" in data or b"\xfe" in data


def test_nonsense_is_warned_of_once(setup):
    client = setup.client()
    for _ in range(10):
        client.send_raw(b"\xfd\x00garbage")
    setup.run(0.02)
    assert len(setup.warnings) == 1
    assert setup.link.statistics.bad_packets >= 10


def test_valid_messages_around_garbage_are_read():
    codec = Codec(1, 1)
    beat = Codec(255, 1).pack(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3))
    found = list(codec.decode(b"xx" + beat + b"\xfd\x05" + beat + beat[:7]))
    assert [m.get_type() for m in found] == ["HEARTBEAT", "HEARTBEAT"]


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(sorted(mavlink.mavlink_map)), st.binary(max_size=255))
def test_every_message_type_with_any_payload_is_survived(one_setup, number, payload):
    """Frames that are whole and have a right checksum, of every type there is, with random payloads."""
    setup = one_setup
    client = setup.clients[0] if setup.clients else setup.client()
    kind = mavlink.mavlink_map[number]
    header = bytes((0xFD, len(payload), 0, 0, 0, 255, 190)) + number.to_bytes(3, "little")
    checksum = mavlink.x25crc(header[1:] + payload)
    checksum.accumulate(bytes([kind.crc_extra]))
    client.send_raw(header + payload + checksum.crc.to_bytes(2, "little"))
    setup.link.poll(0)
    setup.flight.step()
    setup.link.send_due(setup.flight.body.time_us)
    assert all(math.isfinite(value) for value in setup.flight.px4.commands)
