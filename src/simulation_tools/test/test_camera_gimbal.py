"""The gimbal's tilt against the horizon, and blur in closed form."""

import math

import numpy as np
import pytest

from simulation_tools.camera.errors import PhotographError
from simulation_tools.camera.gimbal import (
    BodyState,
    CameraState,
    TiltGimbal,
    TiltParameters,
    blur_px,
    marks_px,
    motion_of,
    smeared,
)
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.geometry import Pose, quaternion_from_rpy

OPTICS = CameraOptics(1000, 800, 60.0, exposure_s=0.01)
FAR = np.full(5, 4.0)
STILL = (0.0, 0.0, 0.0)


def body(stamp_s=0.0, roll=0.0, pitch=0.0, yaw=0.0, velocity=STILL, rates=STILL):
    turn = quaternion_from_rpy(roll, pitch, yaw)
    return BodyState(stamp_s, Pose((1.0, 2.0, 3.0), turn), velocity, rates)


def camera(velocity=STILL, rates=STILL):
    return CameraState(0.0, Pose(), Pose(), np.array(velocity), np.array(rates))


@pytest.mark.table("tilt", [-1.2, 0.0, 0.7, math.pi / 2])
@pytest.mark.table("pitch", [-0.3, 0.0, 0.2])
@pytest.mark.table("roll", [-0.4, 0.0, 0.1])
def test_the_camera_keeps_its_tilt_and_stays_level_while_the_uav_leans(tilt, pitch, roll):
    gimbal = TiltGimbal()
    gimbal.command(tilt)
    pose = gimbal.follow(body(roll=roll, pitch=pitch, yaw=0.4)).pose
    right, down, ahead = pose.rotation.T
    level = math.cos(tilt)
    np.testing.assert_allclose(
        ahead, (level * math.cos(0.4), level * math.sin(0.4), math.sin(tilt)), atol=1e-9
    )
    np.testing.assert_allclose(right, (math.sin(0.4), -math.cos(0.4), 0.0), atol=1e-9)
    np.testing.assert_allclose(np.cross(right, down), ahead, atol=1e-9)


def test_it_carries_the_camera_where_it_is_mounted():
    state = TiltGimbal(TiltParameters((0.1, 0.0, -0.05))).follow(body(roll=0.2, yaw=math.pi / 2))
    np.testing.assert_allclose(state.in_body.position_m, (0.1, 0.0, -0.05))
    np.testing.assert_allclose(
        state.pose.position_m, (1.0 + 0.05 * -math.sin(0.2), 2.1, 3.0 - 0.05 * math.cos(0.2)), atol=1e-9
    )
    np.testing.assert_allclose(state.pose.rotation[:, 0], (1.0, 0.0, 0.0), atol=1e-9)


def test_beyond_its_range_the_camera_rolls_with_the_uav():
    state = TiltGimbal().follow(body(roll=math.radians(60.0)))
    np.testing.assert_allclose(state.pose.rotation[2, 0], -math.sin(math.radians(15.0)), atol=1e-9)


def test_it_turns_no_faster_than_its_rate_and_no_farther_than_its_range():
    gimbal = TiltGimbal(TiltParameters(tilt_max=45.0, rate=90.0))
    gimbal.follow(body(0.0))
    gimbal.command(math.radians(80.0))
    state = gimbal.follow(body(0.1))
    assert math.degrees(math.asin(state.pose.rotation[2, 2])) == pytest.approx(9.0)
    assert np.linalg.norm(state.rates_rad_s) == pytest.approx(math.radians(90.0))
    state = gimbal.follow(body(9.0))
    assert math.degrees(math.asin(state.pose.rotation[2, 2])) == pytest.approx(45.0)
    assert gimbal.follow(body(1.0)).stamp_s == 1.0  # a clock that jumped back


@pytest.mark.table("tilt", [0.0, -1.0])
def test_a_uav_that_leans_turns_the_camera_about_the_vertical_only(tilt):
    """Rates of the UAV by the derivatives of its roll, pitch and yaw (Euler's kinematic equations)."""
    roll, pitch, (roll_rate, pitch_rate, yaw_rate), step_s = 0.2, -0.1, (0.5, -0.3, 0.4), 1e-4
    rates = (
        roll_rate - yaw_rate * math.sin(pitch),
        pitch_rate * math.cos(roll) + yaw_rate * math.sin(roll) * math.cos(pitch),
        -pitch_rate * math.sin(roll) + yaw_rate * math.cos(roll) * math.cos(pitch),
    )
    gimbal = TiltGimbal()
    gimbal.command(tilt)
    gimbal.follow(body(0.0, roll - roll_rate * step_s, pitch - pitch_rate * step_s))
    state = gimbal.follow(body(step_s, roll, pitch, rates=rates))
    np.testing.assert_allclose(state.pose.rotation @ state.rates_rad_s, (0.0, 0.0, yaw_rate), atol=1e-3)


def test_blur_of_motion_and_of_turning_in_closed_form():
    # Sideways at 0.5 m/s past a wall at 4 m: f v t / Z in every pixel
    longest, mean = blur_px(camera(velocity=(0.5, 0.0, 0.0)), OPTICS, FAR)
    assert longest == pytest.approx(OPTICS.focal_px * 0.5 * 0.01 / 4.0)
    np.testing.assert_allclose(mean, (-longest, 0.0), atol=1e-9)
    # About the optical axis at 1 rad/s: the distance of the corner from the middle, times the angle
    longest, mean = blur_px(camera(rates=(0.0, 0.0, 1.0)), OPTICS, FAR)
    assert longest == pytest.approx(0.01 * math.hypot(499.5, 399.5))
    np.testing.assert_allclose(mean, 0.0, atol=1e-9)
    # To the side at 1 rad/s, with nothing in sight: f w t in the middle, more at the edges
    longest, _ = blur_px(camera(velocity=(9.0, 0.0, 0.0), rates=(0.0, 1.0, 0.0)), OPTICS, np.full(5, np.inf))
    corner = (marks_px(OPTICS)[1] - OPTICS.centre_px) / OPTICS.focal_px
    flow = OPTICS.focal_px * 0.01 * np.array((1.0 + corner[0] ** 2, corner[0] * corner[1]))
    assert longest == pytest.approx(np.linalg.norm(flow))


def test_what_the_camera_moves_and_turns_bounds_its_blur():
    moves = camera(velocity=(0.3, 0.0, 0.4), rates=(0.0, 0.2, 0.0))
    shift_m, turn_rad = motion_of(moves, OPTICS.exposure_s)
    assert (shift_m, turn_rad) == (pytest.approx(0.005), pytest.approx(0.002))
    longest, _ = blur_px(moves, OPTICS, FAR)
    corner = np.linalg.norm((*((marks_px(OPTICS)[1] - OPTICS.centre_px) / OPTICS.focal_px), 1.0))
    assert longest <= OPTICS.focal_px * (shift_m * corner / 4.0 + turn_rad * corner**2)


def test_a_picture_is_smeared_along_the_motion_only():
    picture = np.zeros((9, 21, 3), np.uint8)
    picture[4, 10] = 250
    drawn = smeared(picture, np.array((4.0, 0.0)))
    assert (drawn[4, 8:13] == 50).all()
    assert drawn.sum() == 5 * 3 * 50
    assert (smeared(picture, np.zeros(2)) == picture).all()


@pytest.mark.table("flow_px", [(0.4, -0.9), (-2.6, 1.2), (7.0, 0.3)])
def test_a_smeared_picture_is_the_mean_of_shifted_ones(flow_px):
    picture = np.random.default_rng(1).integers(0, 256, (12, 20, 3), np.uint8)
    steps = int(np.ceil(np.abs(flow_px).max()))
    padded = np.pad(picture.astype(int), ((9, 9), (9, 9), (0, 0)), mode="edge")
    total = 0
    for share in np.linspace(-0.5, 0.5, steps + 1):
        right, down = (int(np.round(share * each)) for each in flow_px)
        total = total + padded[9 - down : 21 - down, 9 - right : 29 - right]
    assert (smeared(picture, np.array(flow_px)) == total // (steps + 1)).all()


def test_a_tilt_that_is_no_number_is_refused():
    with pytest.raises(PhotographError, match="not finite"):
        TiltGimbal().command(math.nan)
