"""What MAVROS does differently for PX4 and for ArduPilot: modes and parameters.

Expected: ArduCopter's mode numbers (mode.h), MAVROS's names of them, and MAVLink's parameter protocol. There
ArduPilot casts an integer to the float (C cast), and PX4 copies its bits (byte-wise).
"""

from __future__ import annotations

import struct

import pytest
from pymavlink.dialects.v20 import common

from simulation_tools.mavros.stacks import CopterStack, Px4Stack, stack_of

PX4, COPTER = Px4Stack(), CopterStack()
INT32, REAL32, REAL64 = (
    common.MAV_PARAM_TYPE_INT32,
    common.MAV_PARAM_TYPE_REAL32,
    common.MAV_PARAM_TYPE_REAL64,
)


def test_the_heartbeat_tells_the_stack_and_before_it_is_px4():
    assert stack_of(common.MAV_AUTOPILOT_ARDUPILOTMEGA).name == "ArduPilot"
    assert stack_of(common.MAV_AUTOPILOT_PX4).name == "PX4"
    assert stack_of(None).name == "PX4"


@pytest.mark.table(
    ("name", "number"),
    [("STABILIZE", 0), ("GUIDED", 4), ("LOITER", 5), ("RTL", 6), ("LAND", 9), ("BRAKE", 17)],
)
def test_copters_modes_have_mavros_names(name, number):
    assert COPTER.custom_mode(name) == number
    assert COPTER.mode_name(number) == name


def test_a_mode_may_be_a_number_as_text_and_a_wrong_one_is_none():
    assert COPTER.custom_mode("27") == 27
    assert COPTER.mode_name(27) == "CMODE(27)"
    assert [COPTER.custom_mode(name) for name in ("OFFBOARD", "", "-4", "4.0", str(2**32))] == [None] * 5


def test_px4s_offboard_is_main_mode_6():
    assert PX4.custom_mode("OFFBOARD") == 6 << 16
    assert PX4.custom_mode("GUIDED") is None


def test_integers_go_as_values_to_ardupilot_and_as_bits_to_px4():
    assert COPTER.to_wire(7, is_integer=True) == 7.0
    assert struct.pack("<f", PX4.to_wire(7, True)) == struct.pack("<i", 7)
    assert COPTER.from_wire(7.0, INT32) == 7
    assert isinstance(COPTER.from_wire(7.0, INT32), int)
    assert COPTER.from_wire(0.5, REAL32) == 0.5


def test_what_ardupilots_parameters_cannot_hold_is_refused():
    assert COPTER.to_wire(2**24, True) == 2.0**24
    for value, is_integer in ((2**24 + 1, True), (1e39, False)):
        with pytest.raises(ValueError, match="ArduPilot's parameters"):
            COPTER.to_wire(value, is_integer)
    with pytest.raises(ValueError, match=f"type {REAL64}"):
        COPTER.from_wire(1.0, REAL64)
