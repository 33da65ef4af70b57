"""The attitude and rate loops: closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from simulation_tools.geometry import quaternion_from_rpy, quaternion_multiply, rotation_matrix
from simulation_tools.px4.control.attitude_control import AttitudeControl, RateControl, low_pass
from simulation_tools.px4.control.flight_control import FlightControl
from simulation_tools.px4.control.mixer import Mixer
from simulation_tools.px4.parameters import Px4Parameters

angles = st.floats(-3.1, 3.1)


def matrix(q_wxyz):
    w, x, y, z = q_wxyz
    return rotation_matrix((x, y, z, w))


def ned_attitude(roll, pitch, yaw):
    x, y, z, w = quaternion_from_rpy(roll, pitch, yaw)
    return np.array([w, x, y, z])


def test_small_attitude_errors_become_rates_by_their_gains():
    attitude = AttitudeControl(Px4Parameters())
    level = ned_attitude(0, 0, 0)
    # 2 sin(e / 2) is e to 1e-6 here; yaw: P 2.8 / weight 0.4 on 0.4 of the error.
    for axis, gain in enumerate((6.5, 6.5, 2.8)):
        error = np.zeros(3)
        error[axis] = 0.002
        assert attitude.update(level, ned_attitude(*error), 0.0) == pytest.approx(gain * error, abs=1e-8)


def test_large_errors_are_limited_and_take_the_short_way():
    attitude = AttitudeControl(Px4Parameters())
    rates = attitude.update(ned_attitude(0, 0, 0), ned_attitude(1.2, 0, 0), 0.0)
    assert rates[0] == pytest.approx(math.radians(220.0))
    rates = attitude.update(ned_attitude(0, 0, 3.0), ned_attitude(0, 0, -3.0), 0.0)
    assert rates[2] > 0.0


def test_the_same_attitude_asks_for_nothing_but_the_yaw_rate():
    q = ned_attitude(0.3, -0.2, 1.0)
    rates = AttitudeControl(Px4Parameters()).update(q, -q, 0.5)
    down_in_body = matrix(q).T @ [0, 0, 1]
    assert rates == pytest.approx(0.5 * down_in_body, abs=1e-9)


@given(angles, st.floats(-1.4, 1.4), angles, st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), angles)
def test_following_the_rates_brings_any_attitude_to_the_wanted_one(roll, pitch, yaw, r, p, y):
    control = AttitudeControl(Px4Parameters())
    wanted, q = ned_attitude(r, p, y), ned_attitude(roll, pitch, yaw)
    # Opposite thrust and heading are the measure-zero cases in which any way is as good.
    assume(matrix(q)[:, 2] @ matrix(wanted)[:, 2] > -0.95)
    for _ in range(3000):
        rates = control.update(q, wanted, 0.0)
        w, x, yy, z = q
        dx, dy, dz = 0.5 * 0.004 * rates
        x, yy, z, w = quaternion_multiply((x, yy, z, w), (dx, dy, dz, 1.0))
        q = np.array([w, x, yy, z]) / math.sqrt(w * w + x * x + yy * yy + z * z)
    assert abs(float(q @ wanted)) > 1.0 - 1e-4


def test_low_pass_lets_constants_through_and_halves_the_power_at_its_cutoff():
    b0, b1, b2, a1, a2 = low_pass(40.0, 250.0)
    assert (b0 + b1 + b2) / (1 + a1 + a2) == pytest.approx(1.0)
    z = np.exp(-2j * math.pi * 40.0 / 250.0)
    gain = abs((b0 + b1 * z + b2 * z * z) / (1 + a1 * z + a2 * z * z))
    assert gain == pytest.approx(math.sqrt(0.5), rel=1e-6)
    assert low_pass(0.0, 250.0) == (1.0, 0.0, 0.0, 0.0, 0.0)


def test_rate_control_is_a_pid_with_limits():
    parameters = Px4Parameters({"IMU_GYRO_CUTOFF": 0.0, "IMU_DGYRO_CUTOFF": 0.0})
    rate = RateControl(parameters)
    none = np.zeros((3, 2), dtype=bool)
    zero = np.zeros(3)
    torques = rate.update(zero, np.array([1.0, 0.0, 0.0]), none, True, 0.004)
    assert torques == pytest.approx([0.15, 0.0, 0.0])
    # Next: P on the same error, I of one step (weakened by (1 rad/s / 400 deg/s)^2), D of the rise to 0.1.
    factor = 1.0 - (1.0 / math.radians(400.0)) ** 2
    torques = rate.update(np.array([0.1, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]), none, True, 0.004)
    assert torques[0] == pytest.approx(0.15 * 0.9 + 0.2 * factor * 0.004 - 0.003 * 0.1 / 0.004)
    for _ in range(5000):
        rate.update(zero, np.array([2.0, 0.0, 0.0]), none, True, 0.004)
    assert rate.state["integral"][0, 0] == pytest.approx(0.3)


def test_a_saturated_axis_does_not_wind_up_further():
    rate = RateControl(Px4Parameters())
    saturated = np.array([[False, True], [True, False], [False, False]])
    for _ in range(100):
        rate.update(np.zeros(3), np.array([1.0, -1.0, 1.0]), saturated, True, 0.004)
    assert rate.state["integral"][0].tolist()[:2] == [0.0, 0.0]
    assert rate.state["integral"][0, 2] > 0.0
    rate.reset_integral()
    rate.update(np.zeros(3), np.ones(3), np.zeros((3, 2), dtype=bool), False, 0.004)
    assert not rate.state["integral"].any()


def test_the_inner_loop_does_what_its_three_parts_do_one_after_the_other():
    parameters, rng = Px4Parameters({"THR_MDL_FAC": 0.3}), np.random.default_rng(8)
    loop, rate, outer, mixer = (
        FlightControl(parameters),
        RateControl(parameters),
        AttitudeControl(parameters),
        Mixer(),
    )
    loop.land_detector.reset()  # on the ground no integral grows
    for _ in range(50):
        rates, attitude = rng.normal(0.0, 1.0, 3), ned_attitude(*rng.normal(0.0, 0.3, 3))
        wanted = loop.position.output[0]
        wanted["attitude"], wanted["yaw_rate"] = ned_attitude(*rng.normal(0.0, 0.3, 3)), rng.normal()
        torques = rate.update(rates, outer.rates_setpoint, mixer.saturation, False, 0.004)
        expected = mixer.mix(torques, 0.0, 0.3)
        outer.update(attitude, wanted["attitude"], wanted["yaw_rate"])
        np.testing.assert_array_equal(loop.update_inner_loop(True, rates, attitude, 0.004), expected)
        np.testing.assert_array_equal(loop.attitude.rates_setpoint, outer.rates_setpoint)
    assert not loop.update_inner_loop(False, rates, attitude, 0.004).any()
