"""Garbage, truncated and corrupted MAVLink, lossy networks, clients that stall: the flight goes on."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lossy_proxy import LossyProxy
from mavlink_client import HOST, Client, Setup
from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.mavlink import Codec
from simulation_tools.px4.modes import Mode


@pytest.fixture(scope="module")
def one_setup():
    setup = Setup()
    setup.run(0.1)
    yield setup
    setup.close()


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


def test_what_ardupilot_writes_against_hanging_radios_is_no_garbage():
    """It opens each link with the bytes 0x30 0x20, three times (GCS_MAVLINK::init)."""
    codec = Codec(1, 1)
    beat = Codec(255, 1).pack(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3))
    assert [len(list(codec.decode(data))) for data in (b"0 ", b"0 0 0 ", b"0 " + beat)] == [0, 0, 1]
    assert codec.bad == 0
    assert list(codec.decode(b"0")) == []
    assert codec.bad == 1


LINK_NODE_STATUS, CURRENT_EVENT_SEQUENCE = 8, 411


@pytest.mark.parametrize("number", [LINK_NODE_STATUS, CURRENT_EVENT_SEQUENCE])
def test_messages_of_newer_dialects_are_skipped_in_silence(number):
    beat = Codec(255, 1).pack(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3))
    unknown = bytes((0xFD, 3, 0, 0, 0, 1, 1)) + number.to_bytes(3, "little") + b"abc" + b"\x12\x34"
    codec = Codec(1, 1)
    found = list(codec.decode(beat + unknown + beat + unknown))
    assert [m.get_type() for m in found] == ["HEARTBEAT", "HEARTBEAT"]
    assert (codec.unknown, codec.bad) == (2, 0)


# A hundred thousand packets


def random_packets(rng, count):
    """Yield random bytes, truncated messages, bit-flipped ones and whole ones with random payloads."""
    codec = Codec(255, 190)
    whole = [
        codec.pack(message)
        for message in (
            mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3),
            mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0),
            mavlink.MAVLink_param_set_message(1, 1, b"MPC_XY_P", 1.0, 9),
            mavlink.MAVLink_set_position_target_local_ned_message(1, 1, 1, 8, 0b0101_1100_0111, *(1.0,) * 11),
            mavlink.MAVLink_set_mode_message(1, 1, 6 << 16),
        )
    ]
    numbers = sorted(mavlink.mavlink_map)
    noise = rng.bytes(1 << 20)
    picks = rng.integers(0, 1 << 30, (count, 4)).tolist()
    for kind, (a, b, c, d) in enumerate(picks):
        if kind % 4 == 0:
            start = a % (len(noise) - 400)
            yield (b"\xfd", b"\xfe", b"")[b % 3] + noise[start : start + c % 300]
            continue
        packet = whole[a % len(whole)]
        if kind % 4 == 1:
            yield packet[: b % len(packet)]
        elif kind % 4 == 2:
            place = b % len(packet)
            yield packet[:place] + bytes([packet[place] ^ (1 << c % 8)]) + packet[place + 1 :]
        else:
            yield framed(numbers[a % len(numbers)], noise[d % 1_000_000 :][: b % 256])


def framed(number, payload):
    """A whole frame with a right checksum."""
    header = bytes((0xFD, len(payload), 0, 0, 0, 255, 190)) + number.to_bytes(3, "little")
    checksum = mavlink.x25crc(header[1:] + payload)
    checksum.accumulate(bytes([mavlink.mavlink_map[number].crc_extra]))
    return header + payload + checksum.crc.to_bytes(2, "little")


def test_thirty_thousand_packets_of_garbage_do_no_harm(setup):
    """Through the socket; flawless setpoints among them come through, and the vehicle stands still."""
    rng = np.random.default_rng(4)
    client = setup.client()
    setup.run(0.6)
    good = 0
    for index, packet in enumerate(random_packets(rng, 30_000)):
        client.send_raw(packet)
        if index % 100 == 99:
            client.velocity(stamp=index)
            setup.link.poll(setup.flight.body.time_us)
            assert setup.stamps[-1] == index
            good += 1
        if index % 1000 == 999:
            setup.flight.px4.request_arm(False, force=True)
            setup.flight.step()
            setup.link.send_due(setup.flight.body.time_us)
    assert good == 300
    assert setup.link.statistics.bad_packets > 15_000
    assert np.isfinite(setup.flight.px4.commands).all()
    assert setup.flight.body.position == (0.0, 0.0, 0.0)


# Networks and clients that fail


def test_a_flight_goes_on_over_a_network_that_loses_and_reorders_a_fifth(setup):
    proxy = LossyProxy(setup.link.offboard.port, loss=0.2, reordered=0.2, seed=1)
    client = setup.client()
    client.to = (HOST, proxy.port)
    modes = set()

    def stream(**target):
        def each():
            proxy.pump()
            if setup.flight.body.time_us % 40_000 == 0:
                client.velocity(frame=1, mask=0b0000_1001_1111_1000, **target)
            if setup.flight.body.time_us % 1_000_000 == 0:
                client.heartbeat()
            modes.add(setup.flight.px4.status.mode)

        return each

    def until_acknowledged(number, *params):
        """Repeat a command until its answer comes, as every ground station does."""
        for _ in range(20):
            client.take("")
            client.command(number, *params)
            setup.run(0.2, stream(z=-3.0))
            if any(ack.result == 0 for ack in client.take("COMMAND_ACK")):
                return
        raise AssertionError(f"no answer to {number} in 20 tries")

    setup.run(1.0, stream(z=-3.0))
    until_acknowledged(176, 1, 6)
    until_acknowledged(400, 1)
    setup.run(12.0, stream(z=-3.0))
    assert setup.flight.body.position == pytest.approx((0.0, 0.0, 3.0), abs=0.1)
    modes.clear()
    setup.run(10.0, stream(x=3.0, z=-3.0))
    assert modes == {Mode.OFFBOARD}
    assert setup.flight.body.position == pytest.approx((0.0, 3.0, 3.0), abs=0.15)
    total = proxy.passed + proxy.lost
    assert proxy.lost / total == pytest.approx(0.2, abs=0.03)
    assert proxy.late > 0.1 * total
    proxy.close()


def test_a_stalled_client_and_one_that_vanishes_hold_up_nobody(setup):
    """One never reads, one closes its socket: the third is served as before, and the flight goes on."""
    stalled, vanished = Client(setup.link.offboard.port), Client(setup.link.offboard.port)
    alive = setup.client()
    for client in (stalled, vanished, alive):
        client.heartbeat()
    setup.run(0.5)
    vanished.close()
    setup.flight.take_off(2.0, seconds=0.0)
    heartbeats = iter(range(10**6))
    setup.run(10.0, each=lambda: alive.heartbeat() if next(heartbeats) % 250 == 0 else None)
    assert setup.flight.body.position[2] == pytest.approx(2.0, abs=0.15)
    attitudes = [m.time_boot_ms for m in alive.inbox if m.get_type() == "ATTITUDE"]
    assert max(b - a for a, b in zip(attitudes[100:], attitudes[101:])) <= 20
    stalled.close()


# Numbers that make no sense, in messages that do

COMMANDS = (17, 20, 21, 22, 176, 178, 179, 192, 300, 400, 410, 510, 511, 512, 520, 528, 31000)
numbers = st.one_of(
    st.sampled_from([math.nan, math.inf, -math.inf, 3e38, -3e38, 1e30, 0.0, 1.0, -1.0, 21196.0, 242.0, 33.0]),
    st.floats(width=32),
)
whole_numbers = st.one_of(
    st.sampled_from([0, 1, -1, 2**31 - 1, -(2**31), 0x7FF80000]), st.integers(-(2**31), 2**31 - 1)
)


def everything_sent(setup):
    """Let every stream and every other message be packed once."""
    setup.flight.step()
    setup.link.reset()
    setup.link.send_due(setup.flight.body.time_us)
    for number in (242, 49, 87, 264):
        setup.clients[0].command(512, number)
    setup.link.poll(setup.flight.body.time_us)


@given(
    st.sampled_from(COMMANDS),
    st.lists(numbers, min_size=7, max_size=7),
    whole_numbers,
    whole_numbers,
    st.booleans(),
)
def test_commands_with_any_numbers_are_survived(one_setup, number, params, x, y, as_int):
    setup = one_setup
    client = setup.clients[0] if setup.clients else setup.client()
    client.take("")
    if as_int:
        message = mavlink.MAVLink_command_int_message
        client.send(message(1, 1, 5, number, 0, 0, *params[:4], x, y, params[6]))
    else:
        client.send(mavlink.MAVLink_command_long_message(1, 1, number, 0, *params))
    setup.run(0.008)
    everything_sent(setup)
    acks = [m.command for m in client.take("COMMAND_ACK")]
    assert acks == [number] + 4 * [512]


@given(
    st.lists(numbers, min_size=11, max_size=11),
    st.integers(0, 4095),
    st.sampled_from([1, 5, 6, 8]),
    whole_numbers,
)
def test_setpoints_with_any_numbers_are_survived(one_setup, values, mask, frame, latitude):
    setup = one_setup
    client = setup.clients[0] if setup.clients else setup.client()
    if frame in (1, 8):
        message = mavlink.MAVLink_set_position_target_local_ned_message
        client.send(message(1, 1, 1, frame, mask, *values))
    else:
        message = mavlink.MAVLink_set_position_target_global_int_message
        client.send(message(1, 1, 1, frame, mask, latitude, latitude, *values[2:]))
    client.send(mavlink.MAVLink_command_long_message(1, 1, 176, 0, 1, 6, 0, 0, 0, 0, 0))
    client.send(mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    setup.run(0.016)
    everything_sent(setup)
    assert np.isfinite(setup.flight.px4.commands).all()
    assert all(math.isfinite(value) for value in setup.flight.body.position)
