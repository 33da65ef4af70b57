"""What an ordinary ground station or SDK does: discover, read, command, fly; nothing of our own node."""

from __future__ import annotations

import math

import pytest
from mavlink_client import GCS, Setup
from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.px4.modes import LandedState, Mode

NAN = math.nan
ARM, TAKEOFF, LAND, RTL, HOLD, SET_MODE, REPOSITION = 400, 22, 21, 20, 17, 176, 192
ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED = range(5)
SYDNEY = GeodeticOrigin(-33.8568, 151.2153, 25.0)


@pytest.fixture
def station():
    """(setup, ground station that is known), a second after power-on in Sydney."""
    setup = Setup(origin=SYDNEY)
    client = setup.client(on_ground_port=True)
    client.heartbeat(GCS)
    setup.run(1.0)
    client.take("")
    yield setup, client
    setup.close()


def command_int(client, number, *params, x=0, y=0, z=0.0, frame=5):
    padded = (*params, *(0.0,) * (4 - len(params)))
    client.send(mavlink.MAVLink_command_int_message(1, 1, frame, number, 0, 0, *padded, x, y, z))


def fly(setup, client, seconds, until=lambda: False):
    """Run with a heartbeat each second; returns whether `until` became true."""
    for _ in range(round(seconds / 0.5)):
        client.heartbeat(GCS)
        setup.run(0.5)
        if until():
            return True
    return False


def take_off(setup, client, amsl_m):
    assert setup.ack(client, lambda: client.command(TAKEOFF, 0, 0, 0, NAN, NAN, NAN, amsl_m)) == [
        (TAKEOFF, 0)
    ]
    assert setup.ack(client, lambda: client.command(ARM, 1)) == [(ARM, 0)]
    assert fly(setup, client, 25.0, until=lambda: setup.flight.px4.status.mode is Mode.AUTO_LOITER)
    fly(setup, client, 6.0)  # LOITER begins 0.8 m below (NAV_MC_ALT_RAD)


def request(setup, client, number, name):
    """Ask for a message with REQUEST_MESSAGE; returns it."""
    client.take("")
    client.command(512, number)
    setup.run(0.01)
    found = client.take(name)
    assert found, name
    return found[0]


def test_a_flight_by_commands_alone(station):
    """Take off, hold, go somewhere, return, land: each acknowledged, each done."""
    setup, client = station
    body, px4 = setup.flight.body, setup.flight.px4
    px4.parameters.set("RTL_RETURN_ALT", 8.0)
    px4.parameters.set("RTL_DESCEND_ALT", 5.0)
    take_off(setup, client, 25.0 + 4.0)
    assert body.position[2] == pytest.approx(4.0, abs=0.15)

    latitude, longitude = SYDNEY.to_global(12.0, -6.0)

    def go():
        command_int(
            client, REPOSITION, -1.0, 1.0, 0.0, 1.0, x=round(1e7 * latitude), y=round(1e7 * longitude), z=31.0
        )

    assert setup.ack(client, go) == [(REPOSITION, ACCEPTED)]
    fly(setup, client, 14.0)
    assert body.position == pytest.approx((-6.0, 12.0, 6.0), abs=0.3)
    assert px4.estimate["yaw"][0] == pytest.approx(1.0, abs=0.05)
    position = request(setup, client, 33, "GLOBAL_POSITION_INT")
    assert (1e-7 * position.lat, 1e-7 * position.lon) == pytest.approx((latitude, longitude), abs=5e-6)
    assert (1e-3 * position.alt, 1e-3 * position.relative_alt) == pytest.approx((31.0, 6.0), abs=0.2)

    assert setup.ack(client, lambda: client.command(RTL)) == [(RTL, ACCEPTED)]
    highest = 0.0
    for _ in range(80):
        fly(setup, client, 0.5)
        highest = max(highest, body.position[2])
        if not px4.status.armed:
            break
    assert highest == pytest.approx(8.0, abs=0.4)
    assert not px4.status.armed
    assert math.hypot(*body.position[:2]) < 0.3


def test_reposition_keeps_what_is_not_given(station):
    setup, client = station
    take_off(setup, client, 25.0 + 3.0)
    x, y, _ = setup.flight.body.position
    yaw = float(setup.flight.px4.estimate["yaw"][0])
    not_given = 0x7FFFFFFF
    act = lambda: command_int(client, REPOSITION, -1.0, 1.0, 0.0, NAN, x=not_given, y=not_given, z=25.0 + 5.0)  # noqa: E731
    assert setup.ack(client, act) == [(REPOSITION, ACCEPTED)]
    fly(setup, client, 7.0)
    assert setup.flight.body.position == pytest.approx((x, y, 5.0), abs=0.15)
    assert setup.flight.px4.estimate["yaw"][0] == pytest.approx(yaw, abs=0.05)


def test_hold_and_land_by_command(station):
    setup, client = station
    take_off(setup, client, 25.0 + 2.0)
    assert setup.ack(client, lambda: client.command(SET_MODE, 1, 4, 3)) == [(SET_MODE, ACCEPTED)]
    assert setup.ack(client, lambda: client.command(ARM, 0)) == [(ARM, DENIED)]
    assert setup.ack(client, lambda: client.command(LAND)) == [(LAND, ACCEPTED)]
    setup.run(0.1)
    assert setup.flight.px4.status.landed_state is LandedState.LANDING
    assert fly(setup, client, 15.0, until=lambda: not setup.flight.px4.status.armed)
    texts = [m.text for m in client.inbox if m.get_type() == "STATUSTEXT"]
    assert (
        texts[-3:] == ["Landing detected", "Disarmed by landing"][-3:] or texts[-1] == "Disarmed by landing"
    )


@pytest.mark.parametrize(
    ("params", "mode"),
    [
        ((1, 4, 3), Mode.AUTO_LOITER),
        ((64 | 16,), Mode.STABILIZED),
        ((64 | 8,), Mode.POSCTL),
        ((0,), Mode.AUTO_LOITER),  # asks for nothing
    ],
)
def test_modes_by_custom_mode_or_by_base_mode(station, params, mode):
    setup, client = station
    assert setup.ack(client, lambda: client.command(SET_MODE, *params)) == [(SET_MODE, ACCEPTED)]
    assert setup.flight.px4.status.mode is mode


@pytest.mark.parametrize(
    ("number", "params", "result"),
    [
        (SET_MODE, (4,), TEMPORARILY_REJECTED),  # base mode "auto" means the mission, and there is none
        (SET_MODE, (1, 4, 99), TEMPORARILY_REJECTED),
        (SET_MODE, (1, NAN), DENIED),
        (300, (), DENIED),  # MISSION_START
        (ARM, (2.0,), UNSUPPORTED),
        (REPOSITION, (-1, 0, 0, NAN, NAN, NAN, NAN), ACCEPTED),
        (REPOSITION, (-1, 1, 0, NAN, 500.0, 500.0, NAN), DENIED),
        (178, (1, 3.0, -1), ACCEPTED),  # DO_CHANGE_SPEED
        (179, (1,), ACCEPTED),  # DO_SET_HOME, here
        (179, (0, 0, 0, 0, NAN, NAN, NAN), DENIED),
        (520, (1,), ACCEPTED),
        (512, (30,), ACCEPTED),
        (512, (9999,), DENIED),
        (510, (30,), ACCEPTED),
        (511, (30, 50_000), ACCEPTED),
        (511, (0, 50_000), FAILED),
        (31000, (), UNSUPPORTED),
    ],
)
def test_each_command_gets_its_answer(station, number, params, result):
    setup, client = station
    assert setup.ack(client, lambda: client.command(number, *params)) == [(number, result)]


def test_before_the_position_is_valid_commands_are_put_off():
    setup = Setup()
    client = setup.client()
    setup.run(0.1)
    for number, params in (
        (TAKEOFF, (0, 0, 0, NAN, NAN, NAN, NAN)),
        (ARM, (1,)),
        (REPOSITION, (-1, 1)),
        (179, (1,)),
    ):
        answers = setup.ack(client, lambda n=number, p=params: client.command(n, *p))
        assert answers == [(number, TEMPORARILY_REJECTED)]
    setup.close()


def test_the_speed_of_automatic_modes_changes(station):
    setup, client = station
    take_off(setup, client, 25.0 + 3.0)
    setup.ack(client, lambda: client.command(178, 1, 1.0, -1))
    latitude, longitude = SYDNEY.to_global(20.0, 0.0)
    client.command(REPOSITION, 0, 1, 0, NAN, NAN, NAN, NAN)
    setup.ack(client, lambda: client.command(178, 1, 1.0, -1))
    client.command(REPOSITION, 1.0, 1, 0, NAN, latitude, longitude, NAN)
    fastest = 0.0
    for _ in range(12):
        fly(setup, client, 0.5)
        fastest = max(fastest, math.hypot(*setup.flight.body.velocity[:2]))
    assert fastest == pytest.approx(1.0, abs=0.15)


def test_home_is_moved_and_told(station):
    setup, client = station
    latitude, longitude = SYDNEY.to_global(3.0, 4.0)
    setup.ack(client, lambda: client.command(179, 0, 0, 0, 0, latitude, longitude, 26.0))
    home = request(setup, client, 242, "HOME_POSITION")
    # A float32 parameter holds a latitude to 2e-6 degrees, 0.2 m; a longitude of 151 to 1 m.
    assert (home.x, home.y, home.z) == pytest.approx((3.0, 4.0, -1.0), abs=1.0)


def test_the_origin_is_the_one_that_was_configured(station):
    setup, client = station
    origin = request(setup, client, 49, "GPS_GLOBAL_ORIGIN")
    assert (origin.latitude, origin.longitude, origin.altitude) == (-338568000, 1512153000, 25000)
    gps = request(setup, client, 24, "GPS_RAW_INT")
    assert (1e-7 * gps.lat, 1e-7 * gps.lon, 1e-3 * gps.alt) == pytest.approx(
        (-33.8568, 151.2153, 25.0), abs=1e-5
    )


def test_versions_and_intervals(station):
    setup, client = station
    version = request(setup, client, 148, "AUTOPILOT_VERSION")
    wanted = (
        mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
        | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
        | mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
        | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
    )
    assert version.capabilities & wanted == wanted
    assert request(setup, client, 264, "FLIGHT_INFORMATION").arming_time_utc == 0
    for number, expected_us in ((0, 1_000_000), (30, 100_000), (9999, 0)):
        client.command(510, number)
        setup.run(0.01)
        interval = client.take("MESSAGE_INTERVAL")[-1]
        assert (interval.message_id, interval.interval_us) == (number, expected_us)


def test_before_an_upload_the_lists_are_empty(station):
    setup, client = station
    client.send(mavlink.MAVLink_mission_request_list_message(1, 1, 1))
    setup.run(0.01)
    count = client.take("MISSION_COUNT")[0]
    assert (count.count, count.mission_type, count.target_system) == (0, 1, 255)
    # Until the download is acknowledged, PX4 takes no upload.
    for message, results in (
        (mavlink.MAVLink_mission_count_message(1, 1, 0), [mavlink.MAV_MISSION_ERROR]),
        (mavlink.MAVLink_mission_ack_message(1, 1, 0, 1), []),
        (mavlink.MAVLink_mission_count_message(1, 1, 0), [mavlink.MAV_MISSION_ACCEPTED]),
        (mavlink.MAVLink_mission_clear_all_message(1, 1), [mavlink.MAV_MISSION_ACCEPTED]),
        (mavlink.MAVLink_mission_request_int_message(1, 1, 0), []),
    ):
        client.send(message)
        setup.run(0.01)
        assert [m.type for m in client.take("MISSION_ACK")] == results


def test_ping_is_answered(station):
    setup, client = station
    client.send(mavlink.MAVLink_ping_message(77, 5, 0, 0))
    setup.run(0.01)
    answer = client.take("PING")[0]
    assert (answer.time_usec, answer.seq, answer.target_system) == (77, 5, 255)


def test_an_answer_goes_to_who_has_asked(station):
    setup, client = station
    other = setup.client(on_ground_port=True, system=254)
    other.heartbeat(GCS)
    setup.run(0.1)
    other.take("")
    assert setup.ack(client, lambda: client.command(ARM, 1)) == [(ARM, ACCEPTED)]
    setup.run(0.1)
    heard = list(other.inbox)
    assert not [m for m in heard if m.get_type() == "COMMAND_ACK"]
    assert [m.text for m in heard if m.get_type() == "STATUSTEXT"] == ["Armed by external command"]


def test_a_change_of_state_is_told_at_once(station):
    """Besides each second's heartbeat: base mode 157 is an armed automatic mode, 145 an armed OFFBOARD."""
    setup, client = station
    setup.run(1.05)
    client.take("")
    setup.ack(client, lambda: client.command(ARM, 1))
    setup.run(0.12)
    beats = [m for m in client.inbox if m.get_type() == "HEARTBEAT"] or client.take("HEARTBEAT")
    assert [(m.base_mode, m.custom_mode, m.system_status) for m in beats] == [(157, 0x03040000, 4)]
    client.velocity()
    setup.run(0.02)
    setup.ack(client, lambda: client.command(SET_MODE, 1, 6))
    setup.run(0.12)
    beat = client.take("HEARTBEAT")[-1]
    assert (beat.base_mode, beat.custom_mode, beat.system_status) == (145, 0x00060000, 4)
    client.take("")
    setup.run(1.2)  # without another setpoint
    beat = client.take("HEARTBEAT")[-1]
    assert (beat.base_mode, beat.custom_mode, beat.system_status) == (157, 0x06040000, 5)
