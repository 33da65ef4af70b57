"""The position and velocity loops: closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.geometry import rotation_matrix
from simulation_tools.px4.control.position_control import GRAVITY_M_S2, PositionControl
from simulation_tools.px4.control.records import SETPOINT_DTYPE
from simulation_tools.px4.estimation.interface import ESTIMATE_DTYPE
from simulation_tools.px4.parameters import Px4Parameters

NAN = math.nan
DT = 0.008
angles = st.floats(-3.1, 3.1)


def matrix(q_wxyz):
    w, x, y, z = q_wxyz
    return rotation_matrix((x, y, z, w))


def estimate(position=(0, 0, 0), velocity=(0, 0, 0), yaw=0.0):
    record = np.zeros(1, ESTIMATE_DTYPE)
    record["position"], record["velocity"], record["yaw"] = position, velocity, yaw
    record["attitude"] = (math.cos(yaw / 2), 0, 0, math.sin(yaw / 2))
    return record


def setpoint(position=(NAN,) * 3, velocity=(NAN,) * 3, acceleration=(NAN,) * 3, yaw=NAN, yaw_rate=NAN):
    record = np.zeros(1, SETPOINT_DTYPE)
    record["position"], record["velocity"], record["acceleration"] = position, velocity, acceleration
    record["yaw"], record["yaw_rate"] = yaw, yaw_rate
    return record


@pytest.fixture
def control():
    control = PositionControl(Px4Parameters())
    limits = control.limits
    limits["tilt"], limits["speed_up"], limits["speed_down"] = math.radians(45), 3.0, 1.0
    limits["thrust_min"] = 0.12
    return control


def test_hover_asks_for_hover_thrust_straight_up(control):
    out = control.update(setpoint(position=(0, 0, 0), yaw=0.4), estimate(), DT)[0]
    assert out["thrust"] == pytest.approx(0.5)
    assert matrix(out["attitude"]) @ [0, 0, 1] == pytest.approx([0, 0, 1])
    assert out["yaw"] == 0.4


def test_position_error_becomes_velocity_by_its_gain_and_limits(control):
    out = control.update(setpoint(position=(1, 2, -1)), estimate(), DT)[0]
    assert out["velocity"] == pytest.approx([0.95, 1.9, -1.0])
    out = control.update(setpoint(position=(300, 400, 50)), estimate(), DT)[0]
    assert out["velocity"] == pytest.approx([12 * 0.6, 12 * 0.8, 1.0])
    out = control.update(setpoint(position=(0, 0, -50)), estimate(), DT)[0]
    assert out["velocity"][2] == pytest.approx(-3.0)


def test_the_direction_of_the_position_goes_before_feed_forward(control):
    control._parameters.set("MPC_XY_VEL_MAX", 5.0)
    control.load_parameters()
    # 0.95 * 4 = 3.8 north is kept; east gets what is left of 5.
    out = control.update(setpoint(position=(4, 0, 0), velocity=(0, 20, 0)), estimate(), DT)[0]
    assert out["velocity"][:2] == pytest.approx([3.8, math.sqrt(25 - 3.8**2)])


def test_the_velocity_law_is_the_references(control):
    """a = 1.8 e + 0.4 integral(e) - 0.2 dv/dt, and the thrust vector that gives it."""
    first = control.update(setpoint(velocity=(1, 0, 0)), estimate(), DT)[0]
    assert first["acceleration"] == pytest.approx([1.8, 0, 0])
    thrust = first["thrust_vector"]
    assert -thrust[0] / thrust[2] == pytest.approx(1.8 / GRAVITY_M_S2)
    assert thrust[2] == pytest.approx(-0.5)
    # The vehicle has gained 0.01 m/s: the derivative passes a 5 Hz low pass, b / (1 + b) of it at once.
    second = control.update(setpoint(velocity=(1, 0, 0)), estimate(velocity=(0.01, 0, 0)), DT)[0]
    b = 2 * math.pi * 5.0 * DT
    expected = 1.8 * 0.99 + 0.4 * DT - 0.2 * (0.01 / DT) * b / (1 + b)
    assert second["acceleration"][0] == pytest.approx(expected)


def test_tilt_is_limited_and_the_integrator_then_follows(control):
    for _ in range(400):
        out = control.update(setpoint(velocity=(12, 0, 0)), estimate(), DT)[0]
    body_z = matrix(out["attitude"])[:, 2]
    assert math.degrees(math.acos(body_z[2])) == pytest.approx(45.0)
    # Without anti-windup it would be at 0.4 * 12 * 3.2 = 15 m/s2 and have to unwind for seconds.
    assert abs(control._state["integral"][0, 0]) < 12.5


def test_vertical_thrust_goes_before_horizontal(control):
    control.set_hover_thrust(0.9)
    out = control.update(setpoint(velocity=(10, 0, -3)), estimate(velocity=(0, 0, 1)), DT)[0]
    thrust = out["thrust_vector"]
    assert thrust[2] == pytest.approx(-1.0)
    assert thrust[0] == pytest.approx(0.0)
    assert out["thrust"] == pytest.approx(1.0)


def test_the_thrust_never_falls_below_its_minimum(control):
    out = control.update(setpoint(velocity=(0, 0, 1)), estimate(velocity=(0, 0, -5)), DT)[0]
    assert out["thrust"] == pytest.approx(0.12)


def test_a_new_hover_thrust_does_not_jerk_the_vehicle(control):
    before = control.update(setpoint(velocity=(0, 0, -1)), estimate(), DT)[0]["thrust"].copy()
    control.update_hover_thrust(0.6)
    after = control.update(setpoint(velocity=(0, 0, -1)), estimate(), DT)[0]["thrust"]
    assert after == pytest.approx(before, abs=0.002)


@given(st.tuples(*[st.floats(-8, 8)] * 3), angles)
def test_the_attitude_points_along_the_thrust_with_the_wanted_heading(acceleration, yaw):
    control = PositionControl(Px4Parameters())
    control.limits["tilt"], control.limits["thrust_min"] = math.radians(45), 0.12
    out = control.update(setpoint(acceleration=acceleration, yaw=yaw), estimate(), DT)[0]
    r = matrix(out["attitude"])
    thrust = out["thrust_vector"]
    assert -r[:, 2] * out["thrust"] == pytest.approx(thrust, abs=1e-6)
    # The body's x axis lies in the vertical plane of the heading.
    assert -math.sin(yaw) * r[0, 0] + math.cos(yaw) * r[1, 0] == pytest.approx(0.0, abs=1e-6)
    assert math.cos(yaw) * r[0, 0] + math.sin(yaw) * r[1, 0] > 0.0
