"""Commands, setpoints and parameters over MAVLink, and the answers that PX4 gives to each."""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.mavlink import parameter_from_wire
from simulation_tools.px4.modes import Mode
from simulation_tools.running.lockstep import Barrier, Lockstep
from simulation_tools.running.pacing import WallClock

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
    assert setup.ack(client, lambda: client.command(17)) == [(17, 3)]
    assert setup.ack(client, lambda: client.command(400, 1, component=0)) == [(400, 0)]
    assert setup.flight.px4.status.armed


def test_commands_to_every_system_are_not_answered(ready):
    """PX4 carries out none of them, but says what it is."""
    setup, client = ready
    assert setup.ack(client, lambda: client.command(400, 1)) == [(400, 0)]
    assert setup.ack(client, lambda: client.command(400, 0, system=0, component=0)) == []
    assert setup.ack(client, lambda: client.command(400, 0, system=0)) == []
    message = mavlink.MAVLink_command_int_message(0, 0, 0, 400, 0, 0, 0, 0, 0, 0, 0, 0, 0)
    assert setup.ack(client, lambda: client.send(message)) == []
    mode = mavlink.MAVLink_set_mode_message(0, 1, 3 << 16)
    assert setup.ack(client, lambda: client.send(mode)) == []
    assert setup.flight.px4.status.armed
    assert setup.flight.px4.status.wanted_mode is Mode.AUTO_LOITER
    assert setup.ack(client, lambda: client.command(520, 1, system=0, component=0)) == [(520, 0)]


def test_offboard_is_accepted_within_27_ms_of_the_first_setpoint(ready):
    setup, client = ready
    client.velocity()
    setup.run(0.024)
    assert setup.ack(client, lambda: client.command(176, 1, 6)) == [(176, 0)]


@pytest.mark.parametrize("is_slow", [False, True])
def test_in_lockstep_an_order_takes_effect_at_its_scan_whether_the_setpoint_comes_before_or_after(
    ready, is_slow
):
    """is_slow: the machine brings the setpoint to MAVROS after the participant's order."""
    setup, client = ready
    stamp_ms = setup.flight.body.time_us // 1000

    class Ordering(Barrier):
        def wait_for_participants(self, timeout_s):
            if not is_slow:
                order()
            client.velocity(vx=1.0, stamp=stamp_ms + 25)  # of the next scan
            self.acknowledge("driver", stamp_ms)
            return super().wait_for_participants(timeout_s)

    def order():
        client.send(mavlink.MAVLink_set_mode_message(1, 1, 4 << 16 | 6 << 24))

    barrier = Ordering(frozenset({"driver"}))
    setup.link.on_setpoint = lambda stamp: (setup.stamps.append(stamp), barrier.on_setpoint(stamp))
    if is_slow:
        order()
    client.velocity(stamp=stamp_ms)
    lockstep = Lockstep(barrier, setup.link, WallClock(), lambda: False, lambda: False)
    assert lockstep.wait(1000 * stamp_ms, timeout_s=10.0)
    assert setup.flight.px4.status.wanted_mode is Mode.AUTO_LAND
    assert setup.stamps == [stamp_ms]
    assert setup.link.wait(0.0)
    setup.link.poll(1000 * stamp_ms)
    assert setup.stamps == [stamp_ms, stamp_ms + 25]


@pytest.mark.parametrize(
    "fields",
    [
        {"mask": 0xFFF},
        {"vx": math.nan},
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


def test_attitude_targets_are_taken(ready):
    setup, client = ready
    target = mavlink.MAVLink_set_attitude_target_message
    client.send(target(5, 1, 1, 0b111, [1.0, 0.0, 0.0, 0.0], 0, 0, 0, 0.5))
    client.send(target(6, 1, 1, 0b1000_0000, [0.0] * 4, 0, 0, 0.1, 0.5))
    client.send(target(7, 1, 1, 0b111, [0.0] * 4, 0, 0, 0, 0.5))  # no rotation
    client.send(target(8, 1, 1, 0b111, [math.nan] * 4, 0, 0, 0, 0.5))
    setup.run(0.02)
    assert setup.stamps == [5, 6]


# Setpoints of every frame


def in_offboard(setup, client, send, seconds):
    """Stream a setpoint at 25 Hz, arm in OFFBOARD and fly."""

    def stream():
        if setup.flight.body.time_us % 40_000 == 0:
            send()

    setup.run(0.1, stream)
    client.command(176, 1, 6)
    client.command(400, 1)
    setup.run(seconds, stream)
    assert setup.flight.px4.status.mode is Mode.OFFBOARD


def global_target(client, origin, north, east, alt, frame, mask=0b0000_1001_1111_1000):
    latitude, longitude = origin.to_global(north, east)
    client.send(
        mavlink.MAVLink_set_position_target_global_int_message(
            0, 1, 1, frame, mask, round(1e7 * latitude), round(1e7 * longitude), alt, *(0.0,) * 8
        )
    )


@pytest.mark.parametrize(("frame", "altitude"), [(5, 488.0 + 3.0), (6, 3.0)])
def test_global_positions_over_the_sea_and_over_home(ready, frame, altitude):
    setup, client = ready
    origin = setup.flight.px4.origin

    def send():
        high = setup.flight.body.position[2] > 2.0  # the ground of these tests lets nobody tilt
        global_target(client, origin, 4.0 if high else 0.0, 2.0 if high else 0.0, altitude, frame)

    in_offboard(setup, client, send, 20.0)
    assert setup.flight.body.position == pytest.approx((2.0, 4.0, 3.0), abs=0.15)


@pytest.mark.parametrize("frame", [0, 1, 3, 8, 11])
def test_global_positions_in_other_frames_are_no_setpoints(ready, frame):
    setup, client = ready
    ground = setup.client(on_ground_port=True)
    ground.heartbeat(6)
    setup.run(0.02)
    global_target(client, setup.flight.px4.origin, 0.0, 0.0, 3.0, frame)
    setup.run(0.02)
    assert setup.link.statistics.setpoints == 0
    text = "".join(m.text for m in ground.take("STATUSTEXT"))
    assert text == f"SET_POSITION_TARGET_GLOBAL_INT invalid coordinate frame {frame}"


def test_a_global_velocity_needs_no_position(ready):
    setup, client = ready
    message = mavlink.MAVLink_set_position_target_global_int_message
    client.send(message(9, 1, 1, 5, 0b0000_1101_1100_0111, 0, 0, 0.0, 1.0, 0.0, 0.0, *(0.0,) * 5))
    client.send(message(10, 1, 1, 5, 0xFFF, 0, 0, 0.0, *(0.0,) * 8))
    client.send(message(11, 1, 1, 5, 0b0000_1001_1111_1000, 2**31 - 1, 0, 3.0, *(0.0,) * 8))  # latitude 214
    setup.run(0.02)
    assert setup.stamps == [9]


def test_what_is_masked_may_be_anything(ready):
    setup, client = ready
    client.velocity(frame=1, x=math.nan, afz=math.inf, yaw=math.nan, stamp=3)
    setup.run(0.02)
    assert setup.stamps == [3]


@pytest.mark.parametrize(("mask", "field"), [(0b1001_1100_0111, "yaw"), (0b0101_1100_0111, "yaw_rate")])
def test_nan_as_heading_asks_for_none(ready, mask, field):
    """As flown on PX4: it keeps OFFBOARD, flies the velocity and holds its heading."""
    setup, client = ready
    setup.flight.take_off(3.0, seconds=8.0)
    setup.flight.stream = None
    yaw = float(setup.flight.px4.estimate["yaw"][0])
    setup.run(3.0, lambda: client.velocity(frame=1, mask=mask, vx=1.0, **{field: math.nan}))
    assert setup.flight.px4.status.mode is Mode.OFFBOARD
    assert setup.flight.body.velocity[1] == pytest.approx(1.0, abs=0.15)  # north
    assert float(setup.flight.px4.estimate["yaw"][0]) == pytest.approx(yaw, abs=0.05)


def test_a_force_is_refused_as_by_px4(ready):
    setup, client = ready
    client.velocity(frame=1, mask=0b0000_1110_0011_1111, afx=1.0)
    setup.run(0.02)
    assert (setup.stamps, setup.link.statistics.refused_setpoints) == ([], 1)


def test_position_with_velocity_leads(ready):
    """Position and velocity together: the velocity is fed forward, the position is still reached."""
    setup, client = ready
    in_offboard(setup, client, lambda: client.velocity(frame=1, mask=0b0000_1001_1100_0000, z=-3.0), 12.0)
    assert setup.flight.body.position == pytest.approx((0.0, 0.0, 3.0), abs=0.1)


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


def test_an_unknown_parameter_is_named(ready):
    setup, client = ready
    ground = setup.client(on_ground_port=True)
    ground.heartbeat(6)
    setup.run(0.02)
    client.send(mavlink.MAVLink_param_set_message(1, 1, b"NOT_THERE", 1.0, mavlink.MAV_PARAM_TYPE_REAL32))
    setup.run(0.02)
    assert client.take("PARAM_VALUE") == []
    (text,) = ground.take("STATUSTEXT")
    assert (text.text, text.severity) == ("[pm] unknown param: NOT_THERE", 6)


@pytest.mark.parametrize(("number", "result"), [(65, 0), (69, 0), (241, 4), (147, 0), (22, 4)])
def test_intervals_of_messages_that_have_nothing_to_send(ready, number, result):
    """RC_CHANNELS and MANUAL_CONTROL: taken, as by PX4, and silent. VIBRATION and PARAM_VALUE: refused."""
    setup, client = ready
    assert setup.ack(client, lambda: client.command(511, number, 100_000)) == [(511, result)]
    setup.run(0.3)
    assert client.take("RC_CHANNELS") + client.take("MANUAL_CONTROL") == []


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
