"""What the streamed messages say, beside real PX4's: recorded from its offboard link in this simulator.

At rest and in flight, master of July 2021, MAVLink 2 (see the figures in each test).
"""

from __future__ import annotations

import dataclasses
import math

import pytest
from flight import NO_NOISE, Flight
from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.px4.estimation.steady_estimator import EstimatorNoise
from simulation_tools.px4.mavlink import telemetry
from simulation_tools.px4.mavlink.link import MavlinkLink
from simulation_tools.px4.modes import Mode
from simulation_tools.px4.setpoint import AttitudeSetpoint, Setpoint

NAN = math.nan


@pytest.fixture(scope="module")
def at_rest():
    """A flight controller that has found its position."""
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.run(2.0)
    return flight


@pytest.fixture(scope="module")
def in_flight():
    """One that hovers in OFFBOARD, 2 m up."""
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.take_off(2.0, yaw=0.5)
    return flight


def message(flight, name):
    return telemetry.build(name, flight.px4, flight.px4.status)


def test_gps_raw_int_has_the_accuracies_of_px4s_receiver(at_rest):
    """PX4: eph 0, epv 0, h_acc 299, v_acc 399, vel_acc 250, hdg_acc 2864788, alt_ellipsoid = alt."""
    gps = message(at_rest, "GPS_RAW_INT")
    assert (gps.eph, gps.epv, gps.h_acc, gps.v_acc) == (0, 0, 299, 399)
    assert (gps.vel_acc, gps.hdg_acc, gps.satellites_visible) == (250, 2864788, 10)
    assert gps.alt_ellipsoid == gps.alt


def test_odometry_has_the_estimates_variances_and_a_velocity_in_the_body(in_flight):
    """PX4 gives the variances of position and velocity, and zeros elsewhere."""
    told, known = message(in_flight, "ODOMETRY"), in_flight.px4.estimator_status
    assert [told.pose_covariance[i] for i in (0, 6, 11)] == list(known.position_variance_m2)
    assert [told.velocity_covariance[i] for i in (0, 6, 11)] == list(known.velocity_variance_m2_s2)
    assert sum(value != 0.0 for value in (*told.pose_covariance, *told.velocity_covariance)) <= 6
    local = message(in_flight, "LOCAL_POSITION_NED")
    assert math.hypot(told.vx, told.vy, told.vz) == pytest.approx(math.hypot(local.vx, local.vy, local.vz))


def test_altitude_tells_the_terrain_below_a_range_finder(in_flight, monkeypatch):
    seen = dataclasses.replace(in_flight.px4.estimator_status, height_over_ground_m=1.5)
    monkeypatch.setattr(type(in_flight.px4), "estimator_status", seen)
    altitude = message(in_flight, "ALTITUDE")
    assert altitude.bottom_clearance == 1.5
    assert altitude.altitude_terrain == pytest.approx(altitude.altitude_local - 1.5)


def test_highres_imu_says_pascal(at_rest):
    """PX4 at 488.2 m: 95597.1, although MAVLink's unit is hPa."""
    assert message(at_rest, "HIGHRES_IMU").abs_pressure == pytest.approx(95597.1, abs=10.0)


def test_the_battery_draws_px4s_ampere(at_rest):
    assert message(at_rest, "SYS_STATUS").current_battery == -100
    assert message(at_rest, "BATTERY_STATUS").current_battery == -100


def test_the_date_is_set_and_passes_with_simulated_time(at_rest):
    """PX4 tells the machine's; here it is a date of its own, so that flights repeat."""
    time = message(at_rest, "SYSTEM_TIME")
    assert time.time_unix_usec > 1234567890 * 10**6  # what MAVROS asks for
    assert time.time_unix_usec % 86_400_000_000 == pytest.approx(1000 * time.time_boot_ms, abs=1000)


def test_altitude_knows_the_terrain_on_the_ground_alone(at_rest, in_flight):
    """PX4: on the ground clearance 0.1 and terrain 0.1 below; in the air NaN for both."""
    ground = message(at_rest, "ALTITUDE")
    assert ground.bottom_clearance == pytest.approx(0.1)
    assert ground.altitude_terrain == pytest.approx(ground.altitude_local - 0.1)
    air = message(in_flight, "ALTITUDE")
    assert math.isnan(air.bottom_clearance)
    assert math.isnan(air.altitude_terrain)
    assert air.altitude_amsl == pytest.approx(488.0 + 2.0, abs=0.05)
    home_up = -float(in_flight.px4.home[2])
    assert air.altitude_relative == pytest.approx(2.0 - home_up, abs=0.05)


def test_hud_without_an_airspeed_sensor(in_flight):
    hud = message(in_flight, "VFR_HUD")
    assert hud.airspeed == 0.0
    assert 40 < hud.throttle < 90


def test_on_the_ground_the_position_target_is_masked(at_rest):
    """PX4 at rest: type_mask 63, x to vz NaN, af (0, 0, 100), its own yaw, yaw_rate 0."""
    target = message(at_rest, "POSITION_TARGET_LOCAL_NED")
    assert target.type_mask == 63
    assert all(math.isnan(v) for v in (target.x, target.y, target.z, target.vx, target.vy, target.vz))
    assert (target.afx, target.afy, target.afz, target.yaw_rate) == (0.0, 0.0, 100.0, 0.0)
    assert target.yaw == pytest.approx(float(at_rest.px4.estimate["yaw"][0]), abs=1e-3)


def test_in_flight_it_is_what_the_client_asked_for(in_flight):
    """PX4 for a position: mask 0; for a velocity 7, and the position NaN."""
    target = message(in_flight, "POSITION_TARGET_LOCAL_NED")
    assert (target.type_mask, target.x, target.y, target.z) == (0, 0.0, 0.0, -2.0)
    assert target.yaw == pytest.approx(math.pi / 2 - 0.5)
    assert message(in_flight, "POSITION_TARGET_GLOBAL_INT") is None  # PX4: in automatic modes alone


def test_a_velocity_masks_the_position_and_an_attitude_stops_it():
    flight = Flight.of_iris(noise=NO_NOISE)
    flight.take_off()
    flight.stream = Setpoint(velocity=(0.0, 0.0, -0.5), yaw=0.0)
    flight.run(0.5)
    target = message(flight, "POSITION_TARGET_LOCAL_NED")
    assert (target.type_mask, target.vz) == (7, -0.5)
    flight.stream = AttitudeSetpoint((1.0, 0.0, 0.0, 0.0), thrust=0.6)
    flight.run(0.1)
    assert message(flight, "POSITION_TARGET_LOCAL_NED") is None
    target = message(flight, "ATTITUDE_TARGET")
    assert target.thrust == pytest.approx(0.6)
    flight.px4.request_mode(Mode.AUTO_LOITER)
    flight.run(0.5)
    place = message(flight, "POSITION_TARGET_GLOBAL_INT")
    assert place.coordinate_frame == mavlink.MAV_FRAME_GLOBAL_INT
    assert place.alt == pytest.approx(488.0 - float(flight.px4.active_setpoint["position"][0, 2]), abs=1e-3)


def test_covariances_are_those_of_the_estimators_noise():
    flight = Flight.of_iris()
    flight.run(2.0)
    noise, m = EstimatorNoise(), message(flight, "LOCAL_POSITION_NED_COV")
    diagonal = [m.covariance[i] for i in (0, 9, 17, 24, 30, 35, 39, 42, 44)]
    assert diagonal[:3] == pytest.approx([v**2 for v in noise.estimated_position_m])
    assert diagonal[3:6] == pytest.approx([v**2 for v in noise.estimated_velocity_m_s])
    assert diagonal[6:] == pytest.approx([noise.acceleration_m_s2**2] * 3)
    assert sum(map(abs, m.covariance)) == pytest.approx(sum(diagonal))
    assert "LOCAL_POSITION_NED_COV" not in telemetry.OFFBOARD_RATES_HZ  # PX4 does not have it


def test_a_remote_control_is_refused_in_one_sentence(at_rest):
    link, warnings = MavlinkLink(at_rest.px4, 0, 0), []
    link.on_warning = warnings.append
    try:
        override = mavlink.MAVLink_rc_channels_override_message(1, 1, *[1500] * 8)
        for _ in range(2):
            link._handlers["RC_CHANNELS_OVERRIDE"](link.offboard, override, ("127.0.0.1", 1))
    finally:
        link.close()
    assert len(warnings) == 1
    assert "no remote control" in warnings[0]
