"""Estimator, controllers, filters and mixer: closed forms and slow references."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy import linalg

from simulation_tools.autopilot import Px4Error, VehicleState
from simulation_tools.geometry import Pose, quaternion_from_rpy, quaternion_multiply, rotation_matrix
from simulation_tools.ned_frames import (
    attitude_to_enu,
    attitude_to_ned,
    enu_to_ned,
    flu_to_frd,
    yaw_to_ned,
)
from simulation_tools.px4.control.attitude_control import AttitudeControl, RateControl, low_pass
from simulation_tools.px4.control.hover_thrust import HoverThrustEstimator
from simulation_tools.px4.control.mixer import QUAD_WIDE, Mixer, mixing_matrix
from simulation_tools.px4.control.position_control import GRAVITY_M_S2, SETPOINT_DTYPE, PositionControl
from simulation_tools.px4.control.takeoff import Takeoff, TakeoffState
from simulation_tools.px4.estimator import (
    ESTIMATE_DTYPE,
    GAINS,
    SAMPLE_PERIOD_S,
    Estimator,
    EstimatorNoise,
)
from simulation_tools.px4.parameters import Px4Parameters

NAN = math.nan
DT = 0.008
angles = st.floats(-3.1, 3.1)
TO_NED = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
TO_FRD = np.diag([1, -1, -1])


def matrix(q_wxyz):
    w, x, y, z = q_wxyz
    return rotation_matrix((x, y, z, w))


# Frames


@given(angles, st.floats(-1.5, 1.5), angles)
def test_attitudes_turn_between_the_frames_as_matrices_do(roll, pitch, yaw):
    enu = quaternion_from_rpy(roll, pitch, yaw)
    ned = attitude_to_ned(enu)
    assert np.allclose(matrix(ned), TO_NED @ rotation_matrix(enu) @ TO_FRD, atol=1e-9)
    assert attitude_to_enu(ned) == pytest.approx(enu, abs=1e-12)


def test_east_is_a_heading_of_ninety_degrees():
    assert yaw_to_ned(0.0) == pytest.approx(math.pi / 2)
    assert yaw_to_ned(math.pi / 2) == pytest.approx(0.0)
    assert yaw_to_ned(-math.pi / 2) == pytest.approx(math.pi)
    assert enu_to_ned((1, 2, 3)) == (2, 1, -3)
    assert flu_to_frd((1, 2, 3)) == (1, -2, -3)


# Estimator


def a_state(yaw=0.3):
    return VehicleState(
        time_us=0,
        pose=Pose((1.0, 2.0, 3.0), quaternion_from_rpy(0.0, 0.0, yaw)),
        velocity_world_m_s=(0.1, 0.2, 0.3),
        angular_velocity_body_rad_s=(0.4, 0.5, 0.6),
        specific_force_body_m_s2=(0.0, 0.0, 9.80665),
    )


def test_a_perfect_estimate_is_the_truth_in_ned_from_where_the_vehicle_stood():
    estimator = Estimator(EstimatorNoise.none(), np.random.default_rng(0))
    estimator.update(a_state(), 0.004)
    assert estimator.estimate[0]["position"].tolist() == [0.0, 0.0, 0.0]
    assert estimator.origin_m == (1.0, 2.0, 3.0)
    moved = replace(a_state(), pose=Pose((1.5, 4.0, 3.3), a_state().pose.orientation_xyzw))
    estimator.update(moved, 0.004)
    e = estimator.estimate[0]
    assert e["position"] == pytest.approx([2.0, 0.5, -0.3])
    assert e["velocity"] == pytest.approx([0.2, 0.1, -0.3])
    assert e["rates"] == pytest.approx([0.4, -0.5, -0.6])
    assert e["acceleration"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    assert e["yaw"] == pytest.approx(math.pi / 2 - 0.3)
    estimator.reset()
    estimator.update(moved, 0.004)
    assert estimator.origin_m == (1.5, 4.0, 3.3)


# EKF2's defaults: what it believes of the inertial sensors and of GPS at 20 Hz, as continuous noise.
EKF2_ACCELERATION = 0.35**2 * 0.01
EKF2_GPS = np.diag([0.5**2, 0.3**2]) * SAMPLE_PERIOD_S
DOUBLE_INTEGRATOR = np.array([[0.0, 1.0], [0.0, 0.0]])


def test_the_filters_gains_solve_the_riccati_equation_of_ekf2():
    process = np.diag([0.0, EKF2_ACCELERATION])
    covariance = linalg.solve_continuous_are(DOUBLE_INTEGRATOR.T, np.eye(2), process, EKF2_GPS)
    gains = covariance @ np.linalg.inv(EKF2_GPS)
    assert np.reshape(GAINS, (2, 2)) == pytest.approx(gains, abs=0.001)


def test_the_estimates_errors_have_the_promised_spread():
    """The covariance of a linear system driven by white noise: the Lyapunov equation."""
    noise = EstimatorNoise()
    gains = np.reshape(GAINS, (2, 2))
    errors = []
    for seed in range(4):
        estimator = Estimator(noise, np.random.default_rng(seed))
        for step in range(20000):
            estimator.update(a_state(), 0.02)
            if step > 1000:
                e = estimator.estimate[0]
                errors.append([*e["position"], *(e["velocity"] - [0.2, 0.1, -0.3])])
    spread = np.std(errors, axis=0)
    said = np.array([noise.estimated_position_m, noise.estimated_velocity_m_s])
    for axis, sigma in ((0, noise.position_xy_m), (1, noise.position_xy_m), (2, noise.position_z_m)):
        drive = np.outer(gains[:, 0], gains[:, 0]) * sigma**2 * SAMPLE_PERIOD_S
        covariance = linalg.solve_continuous_lyapunov(DOUBLE_INTEGRATOR - gains, -drive)
        # 1500 s of errors that are correlated over some 3 s: three standard errors are 10 %.
        assert spread[[axis, 3 + axis]] == pytest.approx(np.sqrt(np.diag(covariance)), rel=0.1)
        assert said[:, axis] == pytest.approx(np.sqrt(np.diag(covariance)), rel=0.01)


def test_reset_repeats_the_same_noise():
    estimator = Estimator(EstimatorNoise(), np.random.default_rng(7))
    first = []
    for _ in range(2):
        estimator.reset()
        for _ in range(10):
            estimator.update(a_state(), 0.004)
        first.append(estimator.estimate.copy())
    assert first[0] == first[1]


# Position control


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


@settings(max_examples=200, deadline=None)
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


# Attitude and rate control


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


@settings(max_examples=30, deadline=None)
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
    assert rate._state["integral"][0, 0] == pytest.approx(0.3)


def test_a_saturated_axis_does_not_wind_up_further():
    rate = RateControl(Px4Parameters())
    saturated = np.array([[False, True], [True, False], [False, False]])
    for _ in range(100):
        rate.update(np.zeros(3), np.array([1.0, -1.0, 1.0]), saturated, True, 0.004)
    assert rate._state["integral"][0].tolist()[:2] == [0.0, 0.0]
    assert rate._state["integral"][0, 2] > 0.0
    rate.reset_integral()
    rate.update(np.zeros(3), np.ones(3), np.zeros((3, 2), dtype=bool), False, 0.004)
    assert not rate._state["integral"].any()


# Mixer


def test_the_mixer_makes_pure_torques_on_the_geometry_it_was_made_for():
    columns = mixing_matrix(QUAD_WIDE)
    effect = np.array([(-y, x, 0.05 * turn, 1.0) for x, y, turn in QUAD_WIDE]).T
    produced = effect @ columns
    assert produced == pytest.approx(np.diag(np.diag(produced)), abs=1e-12)
    assert np.linalg.norm(columns[:, :2], axis=0).max() == pytest.approx(math.sqrt(2.0))
    assert np.abs(columns[:, 2]).max() == pytest.approx(1.0)
    assert columns[:, 3] == pytest.approx(np.ones(4))


def test_what_fits_is_mixed_exactly():
    mixer = Mixer()
    out = mixer.mix(np.array([0.1, -0.05, 0.02]), 0.5)
    assert out == pytest.approx(mixing_matrix(QUAD_WIDE) @ [0.1, -0.05, 0.02, 0.5])
    assert not mixer.saturation.any()


@settings(max_examples=300, deadline=None)
@given(st.tuples(*[st.floats(-1, 1)] * 3), st.floats(0, 1))
def test_commands_stay_within_bounds_and_thrust_is_never_raised(torques, thrust):
    out = Mixer().mix(np.array(torques), thrust)
    assert ((out >= 0.0) & (out <= 1.0)).all()
    # Clipping at zero adds what desaturation could not take away; the mean bounds it.
    unclipped = np.clip(mixing_matrix(QUAD_WIDE) @ [*torques, thrust], 0.0, 1.0)
    assert out.mean() <= max(thrust, unclipped.mean()) + 1e-9


def test_at_full_thrust_thrust_gives_way_to_roll():
    out = Mixer().mix(np.array([0.2, 0.0, 0.0]), 1.0)
    columns = mixing_matrix(QUAD_WIDE)
    assert out - out.mean() == pytest.approx(0.2 * (columns[:, 0] - columns[:, 0].mean()), abs=1e-9)
    assert out.max() == pytest.approx(1.0)


def test_idle_rotors_report_which_way_they_cannot_go():
    mixer = Mixer()
    mixer.mix(np.array([0.0, 0.0, 0.0]), 0.0)
    assert mixer.saturation.all()


# Hover thrust


def test_hover_thrust_is_found_and_only_then_valid():
    hover = HoverThrustEstimator(Px4Parameters())
    truth = 0.62
    for step in range(1500):
        thrust = truth + 0.02 * math.sin(0.05 * step)
        hover.update(9.80665 * (thrust / truth - 1.0), thrust, DT)
        if step * DT < 1.9:
            assert not hover.valid
    assert hover.valid
    assert hover.hover_thrust == pytest.approx(truth, abs=0.005)


def test_hover_thrust_shrugs_off_an_outlier():
    hover = HoverThrustEstimator(Px4Parameters())
    for _ in range(500):
        hover.update(0.0, 0.5, DT)
    hover.update(500.0, 0.5, DT)
    assert hover.hover_thrust == pytest.approx(0.5, abs=1e-3)


# Take-off


def test_take_off_spools_up_for_a_second_and_ramps_for_three():
    takeoff = Takeoff(Px4Parameters())
    start = -9.80665 / 4.0
    seen = {}
    limits = []
    for step in range(round(5.0 / DT)):
        takeoff.update(True, step * DT < 2.0, True, False, DT)
        seen.setdefault(takeoff.state, step * DT)
        limits.append(takeoff.speed_limit(3.0, DT))
    assert seen[TakeoffState.RAMPUP] == pytest.approx(1.0, abs=2 * DT)
    assert seen[TakeoffState.FLIGHT] == pytest.approx(4.0, abs=3 * DT)
    assert limits[0] == pytest.approx(start)
    halfway = round(2.5 / DT)
    assert limits[halfway] == pytest.approx(start + 0.5 * (3.0 - start), abs=0.03)
    assert limits[-1] == 3.0
    takeoff.update(False, True, True, False, DT)
    assert takeoff.state is TakeoffState.DISARMED


# Parameters


def test_parameters_are_typed_checked_and_noticed():
    parameters = Px4Parameters()
    before = parameters.revision
    parameters.set("MPC_XY_P", 1.5)
    assert (parameters["MPC_XY_P"], parameters.revision) == (1.5, before + 1)
    assert parameters.spec("COM_OBL_ACT").is_integer
    assert not parameters.spec("MPC_XY_P").is_integer
    for name, value, complaint in (
        ("MPC_XY_P", 99.0, "between"),
        ("MPC_XY_P", NAN, "between"),
        ("COM_OBL_ACT", 0.5, "integer"),
        ("NO_SUCH", 1.0, "no parameter"),
    ):
        with pytest.raises(Px4Error, match=complaint):
            parameters.set(name, value)
    assert parameters["MPC_XY_P"] == 1.5


def test_every_default_lies_in_its_range():
    parameters = Px4Parameters()
    for name in parameters:
        spec = parameters.spec(name)
        assert spec.minimum <= spec.default <= spec.maximum, name
        assert len(name) <= 16, name
