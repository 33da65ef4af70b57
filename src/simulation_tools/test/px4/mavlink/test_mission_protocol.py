"""Uploads and downloads of missions and fences by an ordinary client: MAVLink's mission protocol as PX4's."""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.px4.plan.items import Command
from simulation_tools.px4.plan.plan import PlanKind

MISSION, FENCE, RALLY, ALL = 0, 1, 2, 255
RELATIVE_INT, MISSION_FRAME = 6, 2
ACCEPTED, ERROR, BAD_FRAME, UNSUPPORTED, NO_SPACE, BAD_X = 0, 1, 2, 3, 4, 10
NAN = math.nan
LATITUDE, LONGITUDE = 473977420, 85455940


def item(seq, command, up=4.0, params=(0.0, 0.0, 0.0, NAN), kind=MISSION, frame=RELATIVE_INT, **fields):
    values = {"x": LATITUDE, "y": LONGITUDE, "current": 0, "system": 1, "component": 1, **fields}
    place = (0, 0, 0.0) if frame == MISSION_FRAME else (values["x"], values["y"], up)
    to = values["system"], values["component"]
    return mavlink.MAVLink_mission_item_int_message(
        *to, seq, frame, command, values["current"], 1, *params, *place, kind
    )


MISSION_ITEMS = [
    item(0, Command.TAKEOFF, current=1, params=(15.0, 0.0, 0.0, NAN)),
    item(1, Command.WAYPOINT, params=(2.0, 1.5, 7.0, -90.0), x=LATITUDE + 1000),
    item(2, Command.CHANGE_SPEED, params=(1.0, 3.0, -1.0, 0.0), frame=MISSION_FRAME),
    item(3, Command.RETURN_TO_LAUNCH, params=(0.0,) * 4, frame=MISSION_FRAME),
]
CORNERS = ((-1000, -1000), (-1000, 1000), (1000, 1000))
FENCE_ITEMS = [
    item(i, 5001, kind=FENCE, params=(3.0, 0.0, 0.0, 0.0), x=LATITUDE + x, y=LONGITUDE + y)
    for i, (x, y) in enumerate(CORNERS)
]


def ask(ready, message, kind):
    """Send a message and return the answers of a kind."""
    setup, client = ready
    client.take(kind)
    client.send(message)
    setup.run(0.02)
    return client.take(kind)


def upload(ready, items, kind=MISSION):
    """Upload as a ground station does; returns the result of the acknowledgement."""
    setup, client = ready
    client.send(mavlink.MAVLink_mission_count_message(1, 1, len(items), kind))
    for _ in range(len(items) + 1):
        setup.run(0.02)
        client.receive()
        acks = [m for m in client.inbox if m.get_type() == "MISSION_ACK"]
        requests = [m for m in client.inbox if m.get_type().startswith("MISSION_REQUEST")]
        client.inbox.clear()
        if acks:
            assert acks[0].mission_type == kind
            return acks[0].type
        client.send(items[requests[-1].seq])
    raise AssertionError("no acknowledgement")


def download(ready, kind=MISSION):
    (count,) = ask(ready, mavlink.MAVLink_mission_request_list_message(1, 1, kind), "MISSION_COUNT")
    items = []
    for seq in range(count.count):
        items += ask(ready, mavlink.MAVLink_mission_request_int_message(1, 1, seq, kind), "MISSION_ITEM_INT")
    ask(ready, mavlink.MAVLink_mission_ack_message(1, 1, ACCEPTED, kind), "MISSION_ACK")
    return items


def test_a_mission_comes_back_as_px4_keeps_it(ready):
    assert upload(ready, MISSION_ITEMS) == ACCEPTED
    items = download(ready)
    assert [(m.seq, m.command, m.frame, m.current) for m in items] == [
        (0, 22, 6, 1),
        (1, 16, 6, 0),
        (2, 178, 2, 0),
        (3, 20, 2, 0),
    ]
    assert [(m.x, m.y, m.z) for m in items[:2]] == [(m.x, m.y, m.z) for m in MISSION_ITEMS[:2]]
    # PX4 forgets the pitch of a take-off and the third parameter of a waypoint, and wraps a heading.
    assert (items[0].param1, items[1].param1, items[1].param2) == (0.0, 2.0, 1.5)
    assert (items[1].param3, items[1].param4) == (0.0, pytest.approx(270.0))
    assert math.isnan(items[0].param4)
    assert (items[2].param1, items[2].param2) == (1.0, 3.0)


def test_a_fence_comes_back_and_clears(ready):
    assert upload(ready, FENCE_ITEMS, FENCE) == ACCEPTED
    assert [(m.command, m.param1, m.x, m.y) for m in download(ready, FENCE)] == [
        (m.command, m.param1, m.x, m.y) for m in FENCE_ITEMS
    ]
    assert len(ready[0].flight.px4.plan.items(PlanKind.FENCE)) == 3
    clear = mavlink.MAVLink_mission_clear_all_message(1, 1, ALL)
    assert [m.type for m in ask(ready, clear, "MISSION_ACK")] == [ACCEPTED]
    assert download(ready, FENCE) == []
    assert download(ready) == []


def test_a_plan_uploaded_on_one_port_is_read_on_the_other(ready):
    setup, _ = ready
    assert upload(ready, MISSION_ITEMS) == ACCEPTED
    ground = setup.client(on_ground_port=True, system=254)
    ground.heartbeat(6)
    assert len(download((setup, ground))) == 4


@pytest.mark.parametrize(
    ("items", "kind", "result"),
    [
        ([item(0, Command.WAYPOINT, frame=1)], MISSION, BAD_FRAME),
        ([item(0, 84)], MISSION, UNSUPPORTED),  # NAV_VTOL_TAKEOFF
        ([item(0, Command.CHANGE_SPEED)], MISSION, UNSUPPORTED),  # with a place
        ([item(0, Command.WAYPOINT, x=910000000)], MISSION, BAD_X),
        ([item(0, 5001, params=(3.0, 0, 0, 0))], MISSION, ERROR),  # a fence's
        ([item(0, Command.WAYPOINT, kind=FENCE)], FENCE, ERROR),
        ([item(0, 5001, kind=FENCE, params=(2.0, 0, 0, 0)), FENCE_ITEMS[1]], FENCE, ERROR),
        ([item(0, 5100, kind=RALLY)], RALLY, UNSUPPORTED),
    ],
)
def test_what_px4_does_not_take_is_refused_by_its_reason(ready, items, kind, result):
    assert upload(ready, items, kind) == result
    assert upload(ready, MISSION_ITEMS) == ACCEPTED  # and leaves the way free


def test_a_fence_has_at_most_63_points(ready):
    ask_for = mavlink.MAVLink_mission_count_message(1, 1, 64, FENCE)
    assert [m.type for m in ask(ready, ask_for, "MISSION_ACK")] == [NO_SPACE]


@pytest.mark.parametrize(("system", "component", "answered"), [(1, 190, 1), (1, 0, 1), (0, 1, 0), (1, 5, 0)])
def test_only_its_own_messages_are_answered(ready, system, component, answered):
    ask_for = mavlink.MAVLink_mission_request_list_message(system, component, MISSION)
    assert len(ask(ready, ask_for, "MISSION_COUNT")) == answered


def test_a_lost_item_is_asked_for_again(ready):
    setup, client = ready
    client.send(mavlink.MAVLink_mission_count_message(1, 1, 2, MISSION))
    setup.run(0.02)
    assert [m.seq for m in client.take("MISSION_REQUEST")] == [0]
    setup.run(0.6)
    assert [m.seq for m in client.take("MISSION_REQUEST")] == [0, 0]  # every 0.25 s
    client.send(MISSION_ITEMS[1])  # the wrong one
    setup.run(0.02)
    assert [m.seq for m in client.take("MISSION_REQUEST_INT")] == [0]


def test_a_client_that_falls_silent_frees_the_way_after_5_s(ready):
    setup, client = ready
    other = setup.client(system=254)
    other.heartbeat(6)
    client.send(mavlink.MAVLink_mission_count_message(1, 1, 2, MISSION))
    setup.run(0.1)
    ask_for = mavlink.MAVLink_mission_count_message(1, 1, 4, MISSION)
    setup.run(5.2, each=lambda: None)
    texts = [m.text for m in other.take("STATUSTEXT")]
    assert texts == ["Operation timeout"]
    client.send(ask_for)
    setup.run(0.02)
    assert client.take("MISSION_REQUEST") or client.take("MISSION_REQUEST_INT")


def test_only_one_client_uploads_at_a_time(ready):
    setup, client = ready
    client.send(mavlink.MAVLink_mission_count_message(1, 1, 2, MISSION))
    setup.run(0.02)
    ground = setup.client(on_ground_port=True, system=254)
    answers = ask((setup, ground), mavlink.MAVLink_mission_count_message(1, 1, 2, MISSION), "MISSION_ACK")
    assert [m.type for m in answers] == [ERROR]


def test_the_current_item_is_told_and_can_be_chosen(ready):
    setup, client = ready
    setup.run(0.5)
    assert client.take("MISSION_CURRENT") == []  # no mission
    upload(ready, MISSION_ITEMS)
    client.take("MISSION_CURRENT")
    setup.run(1.0)
    assert [m.seq for m in client.take("MISSION_CURRENT")] == [0] * 10
    chosen = ask(ready, mavlink.MAVLink_mission_set_current_message(1, 1, 1), "MISSION_CURRENT")
    assert chosen[-1].seq == 1
    assert ask(ready, mavlink.MAVLink_mission_set_current_message(1, 1, 9), "MISSION_CURRENT") == []


def test_a_ground_stations_plan_is_flown_and_told(ready):
    """Upload, MISSION_START, and the messages by which QGroundControl follows a mission."""
    setup, client = ready
    north = [LATITUDE + round(1e7 * math.degrees(meters / 6371000.0)) for meters in (6.0, 10.0)]
    plan = [
        item(0, Command.TAKEOFF),
        item(1, Command.WAYPOINT, x=north[0]),
        item(2, Command.WAYPOINT, x=north[1]),
    ]
    assert upload(ready, plan) == ACCEPTED
    assert setup.ack(client, lambda: client.command(300)) == [(300, ACCEPTED)]
    current, reached = [], []

    def note():
        for m in client.inbox:
            if m.get_type() == "MISSION_CURRENT":
                current.append(m.seq)
            elif m.get_type() == "MISSION_ITEM_REACHED":
                reached.append(m.seq)
        client.inbox.clear()

    setup.run(18.0, note)
    assert list(dict.fromkeys(current)) == [0, 1, 2]
    assert list(dict.fromkeys(reached)) == [0, 1, 2]
    assert setup.flight.body.position[1] == pytest.approx(10.0, abs=0.3)
    assert setup.flight.px4.status.mode.name == "AUTO_MISSION"


def test_autopilot_version_claims_missions_and_fences(ready):
    setup, client = ready
    client.command(mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
    setup.run(0.02)
    (version,) = client.take("AUTOPILOT_VERSION")
    for bit in (mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT, mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE):
        assert version.capabilities & bit
    assert not version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
