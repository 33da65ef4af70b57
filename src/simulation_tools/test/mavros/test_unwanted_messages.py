"""A codec that is told what is wanted checks the other messages, and does not unpack them."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.mavlink import Codec

ATTITUDE = mavlink.MAVLink_attitude_message(1000, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
HEARTBEAT = mavlink.MAVLink_heartbeat_message(2, 12, 81, 0, 3, 3)


@pytest.fixture
def codec():
    """A codec that wants heartbeats alone."""
    found = Codec(1, 240)
    found.wanted = {mavlink.MAVLINK_MSG_ID_HEARTBEAT}
    return found


def packed(*messages, signed=False):
    sender = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    if signed:
        sender.signing.secret_key, sender.signing.sign_outgoing = b"k" * 32, True
    return b"".join(bytes(message.pack(sender)) for message in messages)


def kinds(codec, datagram):
    return [message.get_type() for message in codec.decode(datagram)]


def test_only_wanted_messages_come_and_the_others_are_counted(codec, monkeypatch):
    unpacked = []
    decode = codec._mav.decode
    monkeypatch.setattr(codec._mav, "decode", lambda frame: unpacked.append(1) or decode(frame))
    datagram = packed(ATTITUDE, HEARTBEAT, ATTITUDE, ATTITUDE)
    assert kinds(codec, datagram) == ["HEARTBEAT"]
    assert (codec.unwanted, codec.bad, len(unpacked)) == (3, 0, 1)
    codec.wanted.add(mavlink.MAVLINK_MSG_ID_ATTITUDE)
    assert kinds(codec, datagram) == ["ATTITUDE", "HEARTBEAT", "ATTITUDE", "ATTITUDE"]


def test_a_corrupted_unwanted_message_is_bad_and_hides_nothing(codec):
    datagram = bytearray(packed(ATTITUDE, HEARTBEAT))
    datagram[12] ^= 0xFF
    assert kinds(codec, bytes(datagram)) == ["HEARTBEAT"]
    assert codec.unwanted == 0
    assert codec.bad > 0


@pytest.mark.parametrize("cut", [1, 5, 20, 39])
def test_a_truncated_unwanted_message_is_bad(codec, cut):
    assert kinds(codec, packed(ATTITUDE)[:cut]) == []
    assert (codec.unwanted, codec.bad > 0) == (0, True)


def test_a_codec_that_is_told_nothing_yields_everything():
    codec = Codec(1, 240)
    assert kinds(codec, packed(ATTITUDE, HEARTBEAT)) == ["ATTITUDE", "HEARTBEAT"]
    assert codec.unwanted == 0
