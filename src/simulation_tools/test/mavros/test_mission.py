"""The mission protocol's client against the stand-in's side, and against others."""

from __future__ import annotations

import math
import threading

import pytest
from fake_uas import FakeClient
from pymavlink.dialects.v20 import common

from simulation_tools.mavros.mission import MissionClient, MissionError, MissionItem
from simulation_tools.px4.mavlink.missions.protocol import MissionProtocol, UploadLock
from simulation_tools.px4.plan.plan import Plan

ITEMS = [
    MissionItem(3, 22, True, True, (0.0, 0.0, 0.0, math.nan), 47.5, 8.5, 3.0),
    MissionItem(3, 16, False, True, (1.0, 0.0, 0.0, math.nan), 47.6, -8.5, 4.0),
    MissionItem(1, 16, False, False, (0.0, 2.0, 0.0, 0.0), 1.5, -2.5, 5.0),  # in the local frame
]


class Peer(FakeClient):
    """Answers what is sent to it at once; `answer` returns the answers to a message."""

    def __init__(self, answer):
        super().__init__()
        self._answer = answer

    def send(self, message):
        super().send(message)
        for answer in self._answer(message):
            self.hear(answer)
        return True


class WithMissions:
    """A flight controller that keeps a mission, as PX4 does."""

    def __init__(self):
        self.items = []
        self.count = 0

    def __call__(self, m):
        kind = m.get_type()
        if kind == "MISSION_REQUEST_LIST":
            yield common.MAVLink_mission_count_message(1, 240, len(self.items), 0)
        elif kind == "MISSION_REQUEST_INT":
            yield self.items[m.seq]
        elif kind == "MISSION_COUNT":
            self.items, self.count = [], m.count
            yield common.MAVLink_mission_request_int_message(1, 240, 0, 0)
        elif kind == "MISSION_ITEM_INT":
            self.items.append(m)
            if len(self.items) < self.count:
                yield common.MAVLink_mission_request_int_message(1, 240, len(self.items), 0)
            else:
                yield common.MAVLink_mission_ack_message(1, 240, 0, 0)
        elif kind == "MISSION_CLEAR_ALL":
            self.items = []
            yield common.MAVLink_mission_ack_message(1, 240, 0, 0)
        elif kind == "MISSION_SET_CURRENT" and m.seq < len(self.items):
            yield common.MAVLink_mission_current_message(m.seq)


class StandIn:
    """The stand-in's protocol and plan."""

    def __init__(self):
        self.plan = Plan()
        self.said = []
        say = lambda severity, text: self.said.append(text)  # noqa: E731
        self._protocol = MissionProtocol(self.plan, UploadLock(), (1, 1), say)

    def __call__(self, m):
        m._header.srcSystem, m._header.srcComponent = 1, 240
        if m.get_type() in self._protocol.messages:
            answer = self._protocol.handle(m, ("", 0), 0)
            if answer is not None:
                yield answer
        if m.get_type() == "MISSION_SET_CURRENT" and self.plan.chosen == m.seq:
            yield common.MAVLink_mission_current_message(m.seq)


def client(peer, timeout_s=0.02):
    return MissionClient(Peer(peer), timeout_s)


def test_a_mission_survives_its_way_there_and_back():
    mission = client(WithMissions())
    mission.write(ITEMS)
    items = mission.read()
    assert [item.command for item in items] == [22, 16, 16]
    assert [(item.frame, item.is_current, item.autocontinue) for item in items] == [
        (3, True, True),
        (3, False, True),
        (1, False, False),
    ]
    assert [(item.x, item.y, item.z) for item in items] == [pytest.approx((i.x, i.y, i.z)) for i in ITEMS]
    assert math.isnan(items[0].params[3])
    mission.set_current(2)
    mission.clear()
    assert mission.read() == []


def test_the_fence_is_a_list_of_its_own():
    """A circle of 20 m and a mission, on one flight controller, with one transfer at a time."""
    peer, lock = Peer(StandIn()), threading.Lock()
    fence = MissionClient(peer, 0.02, common.MAV_MISSION_TYPE_FENCE, lock)
    mission = MissionClient(peer, 0.02, lock=lock)
    circle = MissionItem(3, 5003, False, True, (20.0, 0.0, 0.0, 0.0), 47.397742, 8.545594, 0.0)
    fence.write([circle])
    assert mission.read() == []
    (item,) = fence.read()
    assert (item.command, item.params[0]) == (5003, 20.0)
    assert (item.x, item.y) == pytest.approx((47.397742, 8.545594))
    fence.clear()
    assert fence.read() == []


def test_places_travel_as_whole_numbers():
    peer = WithMissions()
    client(peer).write(ITEMS)
    assert (peer.items[1].x, peer.items[1].y) == (476000000, -85000000)  # 1e-7 degrees
    assert (peer.items[2].x, peer.items[2].y) == (15000, -25000)  # 1e-4 m


def test_the_stand_in_keeps_a_mission():
    stand_in = StandIn()
    mission = client(stand_in)
    assert mission.read() == []
    mission.write(ITEMS[:2])
    items = mission.read()
    assert [(item.command, item.frame) for item in items] == [(22, 6), (16, 6)]
    assert [(i.x, i.y, i.z) for i in items] == [pytest.approx((i.x, i.y, i.z)) for i in ITEMS[:2]]
    assert [item.is_current for item in items] == [True, False]
    mission.set_current(1)
    mission.clear()
    assert mission.read() == []
    assert stand_in.said == []


def test_the_stand_in_refuses_a_local_frame():
    with pytest.raises(MissionError, match="MAV_MISSION_UNSUPPORTED_FRAME"):
        client(StandIn()).write(ITEMS)


def test_an_unknown_item_cannot_be_chosen():
    mission = client(WithMissions())
    mission.write(ITEMS)
    with pytest.raises(MissionError, match="MISSION_SET_CURRENT"):
        mission.set_current(3)


def test_a_flight_controller_that_is_silent_is_asked_three_times():
    mission = client(lambda m: ())
    with pytest.raises(MissionError, match="does not answer MISSION_REQUEST_LIST"):
        mission.read()
    assert [m.get_type() for m in mission._client.sent] == ["MISSION_REQUEST_LIST"] * 3


@pytest.mark.table("bad", [math.nan, math.inf, 1e6])
def test_an_item_that_mavlink_cannot_carry_is_refused(bad):
    mission = client(WithMissions())
    item = MissionItem(3, 16, False, True, (0.0, 0.0, 0.0, 0.0), bad, 8.5, 3.0)
    with pytest.raises(MissionError, match="item 1 holds NaN"):
        mission.write([ITEMS[0], item])
    assert not mission._client.sent


def test_a_flight_controller_that_asks_for_too_much_is_told_of():
    peer = WithMissions()

    def greedy(m):
        if m.get_type() == "MISSION_COUNT":
            yield common.MAVLink_mission_request_message(1, 240, 7, 0)
        else:
            yield from peer(m)

    with pytest.raises(MissionError, match="asks for item 7 of 3"):
        client(greedy).write(ITEMS)
