"""PX4's parameters: names, types and defaults as read from it, and what changing them in flight does."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from flight import hovering
from mavlink_client import Setup
from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.autopilot import Px4Error
from simulation_tools.mavlink import parameter_from_wire, parameter_to_wire
from simulation_tools.px4.modes import Mode
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.setpoint import Setpoint

MEASURED = json.loads((Path(__file__).parent / "data/px4_parameters.json").read_text())
INT32, REAL32 = mavlink.MAV_PARAM_TYPE_INT32, mavlink.MAV_PARAM_TYPE_REAL32


@pytest.mark.table("name", [name for name, value in MEASURED.items() if value is not None])
def test_names_types_and_defaults_are_those_of_px4(name):
    parameters = Px4Parameters()
    assert parameters[name] == pytest.approx(MEASURED[name], rel=1e-6)
    assert parameters.spec(name).is_integer is isinstance(MEASURED[name], int)


def test_parameters_that_px4_did_not_have_are_not_there():
    parameters = Px4Parameters()
    assert [name for name, value in MEASURED.items() if value is None and name in parameters] == []


@pytest.mark.table(("value", "complaint"), [(99.0, "between"), (math.nan, "between"), (0.5, "integer")])
def test_bad_values_are_refused_in_a_sentence(value, complaint):
    parameters = Px4Parameters()
    with pytest.raises(Px4Error, match=complaint) as caught:
        parameters.set("COM_OBL_ACT", value)
    assert "\n" not in str(caught.value)
    assert parameters["COM_OBL_ACT"] == 0


# Over MAVLink


@pytest.fixture
def in_flight():
    """(setup, client) at 3 m in OFFBOARD; the client's stream is `setup.flight.stream`."""
    setup = Setup(hovering(3.0, seconds=12.0))
    client = setup.client()
    client.heartbeat()
    yield setup, client
    setup.close()


def put(setup, client, name, value):
    """Set a parameter over MAVLink; returns the value in the answer."""
    kind = INT32 if isinstance(value, int) else REAL32
    wire = parameter_to_wire(value, kind == INT32)
    client.send(mavlink.MAVLink_param_set_message(1, 1, name.encode(), wire, kind))
    setup.run(0.01)
    answer = client.take("PARAM_VALUE")[0]
    assert (answer.param_id, answer.param_type) == (name, kind)
    return parameter_from_wire(answer.param_value, answer.param_type)


def fastest(setup, seconds):
    speeds = []
    setup.run(seconds, each=lambda: speeds.append(math.hypot(*setup.flight.body.velocity[:2])))
    return max(speeds)


def test_the_speed_limit_takes_effect(in_flight):
    setup, client = in_flight
    assert put(setup, client, "MPC_XY_VEL_MAX", 1.5) == 1.5
    setup.flight.stream = Setpoint(position=(0.0, 40.0, -3.0))
    assert fastest(setup, 8.0) == pytest.approx(1.5, abs=0.15)


@pytest.mark.parametrize("limit_deg", [45.0, 25.0])
def test_the_tilt_limit_takes_effect(in_flight, limit_deg):
    setup, client = in_flight
    assert put(setup, client, "MPC_TILTMAX_AIR", limit_deg) == limit_deg
    setup.flight.stream = Setpoint(velocity=(0.0, 10.0, 0.0))
    tilts = []

    def note():
        x, y = setup.flight.px4.attitude_setpoint["attitude"][0, 1:3]
        tilts.append(math.degrees(math.acos(1.0 - 2.0 * (x * x + y * y))))

    setup.run(1.5, each=note)
    assert max(tilts) == pytest.approx(limit_deg, abs=0.1)


def test_the_time_out_of_the_stream_takes_effect(in_flight):
    setup, client = in_flight
    assert put(setup, client, "COM_OF_LOSS_T", 2.0) == 2.0
    setup.flight.stream = None
    lost_s = setup.flight.time_s
    while setup.flight.px4.status.mode is Mode.OFFBOARD and setup.flight.time_s < lost_s + 5.0:
        setup.run(0.01)
    assert setup.flight.time_s - lost_s == pytest.approx(2.0, abs=0.05)


def test_gains_take_effect(in_flight):
    """A tenfold position gain would ask for ten times the speed: 0.95 to 2 doubles it."""
    setup, client = in_flight
    setup.flight.stream = Setpoint(position=(0.0, 1.0, -3.0))
    before = fastest(setup, 4.0)
    put(setup, client, "MPC_XY_P", 2.0)
    setup.flight.stream = Setpoint(position=(0.0, 0.0, -3.0))
    assert fastest(setup, 4.0) > 1.3 * before


def test_a_value_of_the_wrong_type_is_not_taken(in_flight):
    setup, client = in_flight
    client.send(mavlink.MAVLink_param_set_message(1, 1, b"COM_OBL_ACT", 1.0, REAL32))
    client.send(mavlink.MAVLink_param_set_message(1, 1, b"MPC_XY_P", parameter_to_wire(1, True), INT32))
    setup.run(0.01)
    kinds = [(m.param_id, m.param_type) for m in client.take("PARAM_VALUE")]
    assert kinds == [("COM_OBL_ACT", INT32), ("MPC_XY_P", REAL32)]
    parameters = setup.flight.px4.parameters
    assert (parameters["COM_OBL_ACT"], parameters["MPC_XY_P"]) == (0, 0.95)


def test_the_hash_follows_the_values(in_flight):
    setup, client = in_flight
    hashes = []
    for value in (0.95, 1.0, 0.95):
        put(setup, client, "MPC_XY_P", value)
        client.send(mavlink.MAVLink_param_request_read_message(1, 1, b"_HASH_CHECK", -1))
        setup.run(0.01)
        answer = client.take("PARAM_VALUE")[0]
        hashes.append(np.float32(answer.param_value).tobytes())
    assert hashes[0] == hashes[2] != hashes[1]


def test_automatic_modes_heed_their_speed_and_turn():
    flight = hovering(3.0, seconds=12.0)
    for name, value in (("RTL_RETURN_ALT", 4.0), ("MPC_XY_CRUISE", 3.0), ("MPC_ACC_HOR", 2.0)):
        flight.px4.parameters.set(name, value)
    flight.stream = Setpoint.hold((30.0, 0.0, 3.0))
    flight.run(14.0)
    flight.px4.request_mode(Mode.AUTO_RTL)
    rows = flight.record(14.0)
    speed = np.hypot(rows[:, 4], rows[:, 5])
    assert speed.max() == pytest.approx(3.0, abs=0.25)
    # Accelerating from 10 to 90 % of 3 m/s at 2 m/s2 and 4 m/s3 takes about 1.4 s.
    rise_s = rows[np.argmax(speed > 2.7), 0] - rows[np.argmax(speed > 0.3), 0]
    assert rise_s == pytest.approx(1.5, abs=0.4)


def test_every_default_lies_in_its_range():
    parameters = Px4Parameters()
    for name in parameters:
        spec = parameters.spec(name)
        assert spec.minimum <= spec.default <= spec.maximum, name
        assert len(name) <= 16, name
