"""MAVROS's conversions: what a setpoint in ROS's frames says in MAVLink's."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.geometry import quaternion_from_rpy
from simulation_tools.mavros.conversions import (
    IGNORE_ACCELERATION,
    IGNORE_POSITION,
    IGNORE_VELOCITY,
    IGNORE_YAW,
    IGNORE_YAW_RATE,
    Target,
    acceleration_target,
    attitude_target,
    global_pose_target,
    global_target,
    pose_target,
    position_target,
    velocity_target,
)

TARGET = Target(1, 1)
EVERYTHING = 0


def test_a_local_setpoint_turns_from_enu_to_ned():
    m = position_target(TARGET, 1234, 1, EVERYTHING, (1, 2, 3), (4, 5, 6), (7, 8, 9), 0.0, 0.5)
    assert (m.x, m.y, m.z) == (2, 1, -3)
    assert (m.vx, m.vy, m.vz) == (5, 4, -6)
    assert (m.afx, m.afy, m.afz) == (8, 7, -9)
    assert (m.yaw, m.yaw_rate) == (pytest.approx(math.pi / 2), -0.5)
    assert (m.time_boot_ms, m.coordinate_frame, m.target_system, m.target_component) == (1234, 1, 1, 1)


@pytest.mark.table("frame", [8, 9])
def test_a_body_setpoint_turns_from_flu_to_frd(frame):
    m = position_target(TARGET, 0, frame, EVERYTHING, (1, 2, 3), (4, 5, 6), (7, 8, 9), 0.25, 0.5)
    assert (m.x, m.y, m.z) == (1, -2, -3)
    assert (m.vx, m.vy, m.vz) == (4, -5, -6)
    assert (m.afx, m.afy, m.afz) == (7, -8, -9)
    assert (m.yaw, m.yaw_rate) == (-0.25, -0.5)


@pytest.mark.table("frame", [0, 2, 3, 6, 10, 255])
def test_other_frames_are_refused(frame):
    with pytest.raises(ValueError, match="coordinate frame"):
        position_target(TARGET, 0, frame, EVERYTHING)


@pytest.mark.table("bad", [math.nan, math.inf, -math.inf, 1e308, -3.5e38])
def test_what_is_not_finite_is_refused_unless_it_is_masked(bad):
    mask = IGNORE_POSITION | IGNORE_ACCELERATION | IGNORE_YAW
    with pytest.raises(ValueError, match="NaN"):
        position_target(TARGET, 0, 8, mask, velocity=(bad, 0, 0))
    with pytest.raises(ValueError, match="NaN"):
        velocity_target(TARGET, 0, 1, (0, 0, 0), bad)
    with pytest.raises(ValueError, match="NaN"):
        pose_target(TARGET, 0, (0, 0, bad), (0, 0, 0, 1))
    m = position_target(TARGET, 0, 8, mask, position=(bad,) * 3, velocity=(1, 0, 0), yaw=bad)
    assert (m.x, m.vx, m.yaw) == (0, 1, 0)


def test_the_masks_are_those_of_mavros():
    velocity = velocity_target(TARGET, 0, 1, (1, 0, 0), 0.1)
    assert velocity.type_mask == IGNORE_POSITION | IGNORE_ACCELERATION | IGNORE_YAW
    pose = pose_target(TARGET, 0, (1, 0, 0), (0, 0, 0, 1))
    assert pose.type_mask == IGNORE_VELOCITY | IGNORE_ACCELERATION | IGNORE_YAW_RATE
    assert pose.coordinate_frame == 1


@given(st.floats(-3.1, 3.1))
def test_a_poses_heading_survives(yaw):
    q = quaternion_from_rpy(0.0, 0.0, yaw)
    m = pose_target(TARGET, 0, (0, 0, 0), q)
    assert math.remainder(m.yaw - (math.pi / 2 - yaw), 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_a_quaternion_of_zeros_means_what_it_means_to_mavros():
    """Its pose becomes a rotation matrix, for which Eigen makes of zeros no rotation: east in ENU.

    On setpoint_position/global MAVROS takes the heading of the quaternion itself: atan2(0, 0), north.
    """
    assert pose_target(TARGET, 0, (0, 0, 2), (0, 0, 0, 0)).yaw == pytest.approx(math.pi / 2)
    assert global_pose_target(TARGET, 0, (47.0, 8.0, 500.0), (0, 0, 0, 0)).yaw == pytest.approx(0.0)


@pytest.mark.table("frame", [8, 9])
def test_a_pose_in_a_body_frame_is_flu(frame):
    m = pose_target(TARGET, 0, (1, 2, 3), quaternion_from_rpy(0.0, 0.0, 0.5), frame)
    assert (m.coordinate_frame, m.x, m.y, m.z) == (frame, 1, -2, -3)
    assert m.yaw == pytest.approx(-0.5)


def test_a_global_setpoint_keeps_its_place_and_turns_its_motion_to_ned():
    m = global_target(TARGET, 9, 6, EVERYTHING, (47.397742, 8.545594, 5.0), (4, 5, 6), (7, 8, 9), 0.0, 0.5)
    assert (m.lat_int, m.lon_int, m.alt) == (473977420, 85455940, 5.0)
    assert (m.vx, m.vy, m.vz) == (5, 4, -6)
    assert (m.afx, m.afy, m.afz) == (8, 7, -9)
    assert (m.yaw, m.yaw_rate) == (pytest.approx(math.pi / 2), -0.5)
    assert (m.time_boot_ms, m.coordinate_frame, m.type_mask) == (9, 6, 0)


def test_a_global_pose_asks_for_place_and_heading_as_mavros_does():
    """The yaw rate stays unmasked, and zero: so MAVROS's source has it."""
    m = global_pose_target(TARGET, 0, (-33.5, -70.25, 700.0), quaternion_from_rpy(0.0, 0.0, math.pi / 2))
    assert (m.lat_int, m.lon_int, m.alt, m.coordinate_frame) == (-335000000, -702500000, 700.0, 5)
    assert m.type_mask == IGNORE_VELOCITY | IGNORE_ACCELERATION
    assert m.yaw == pytest.approx(0.0)


@pytest.mark.table("place", [(91, 0, 0), (0, 181, 0), (math.nan, 0, 0), (0, math.inf, 0)])
def test_what_is_no_place_on_earth_is_refused(place):
    with pytest.raises(ValueError, match="not a place on earth"):
        global_target(TARGET, 0, 5, EVERYTHING, place)
    assert global_target(TARGET, 0, 5, IGNORE_POSITION, place).lat_int == 0


@pytest.mark.table("bad", [math.nan, math.inf, 1e308])
def test_a_global_setpoint_that_is_not_finite_is_refused(bad):
    with pytest.raises(ValueError, match="NaN"):
        global_target(TARGET, 0, 5, EVERYTHING, (0, 0, bad))
    with pytest.raises(ValueError, match="NaN"):
        global_target(TARGET, 0, 5, EVERYTHING, (0, 0, 0), velocity=(0, bad, 0))
    with pytest.raises(ValueError, match="NaN"):
        global_pose_target(TARGET, 0, (0, 0, 0), (bad, 0, 0, 1))


def test_an_acceleration_masks_all_else():
    m = acceleration_target(TARGET, 3, (1, 2, 3))
    assert (m.afx, m.afy, m.afz) == (2, 1, -3)
    assert m.type_mask == IGNORE_POSITION | IGNORE_VELOCITY | IGNORE_YAW | IGNORE_YAW_RATE
    assert acceleration_target(TARGET, 3, (1, 2, 3), is_force=True).type_mask == m.type_mask | 512
    with pytest.raises(ValueError, match="NaN"):
        acceleration_target(TARGET, 3, (math.nan, 0, 0))


def test_attitudes_turn_to_frd_in_ned():
    level_east = attitude_target(TARGET, 7, 0, (0.0, 0.0, 0.0, 1.0), (0.1, 0.2, 0.3), 1.5)
    assert level_east.q == pytest.approx((math.sqrt(0.5), 0, 0, math.sqrt(0.5)))
    assert level_east.body_roll_rate == 0.1
    assert (level_east.body_pitch_rate, level_east.body_yaw_rate) == (-0.2, -0.3)
    assert level_east.thrust == 1.0


def test_stamps_beyond_32_bits_wrap():
    assert velocity_target(TARGET, 2**32 + 5, 1, (0, 0, 0), 0.0).time_boot_ms == 5
