"""Drift: none when asked, continuous always, and with the statistics that the parameters state.

The tolerances of the statistical tests are those of the estimators: with N = 400 seeds the standard error of
a mean is sigma / 20, that of a standard deviation sigma / 28; five of each are allowed.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulation_tools.geometry import (
    Pose,
    quaternion_from_rpy,
    quaternion_multiply,
    rotate_inverse,
    wrap_angle,
)
from simulation_tools.sensors.odometry import (
    DriftingOdometry,
    OdometryParameters,
    OdometrySample,
)
from simulation_tools.world.world import BodyState

SEEDS = 400
DT = 0.01


def truth(state):
    q = state.pose.orientation_xyzw
    velocities = state.linear_velocity_m_s, state.angular_velocity_rad_s
    return OdometrySample(state.pose, *(rotate_inverse(q, velocity) for velocity in velocities))


def straight(length, speed=20.0):
    """States along the x axis, from just after the start to the end."""
    steps = round(length / speed / DT)
    return [
        BodyState(Pose.from_xyz_rpy(length * (k + 1) / steps, 0, 1.0), (speed, 0, 0), (0, 0, 0))
        for k in range(steps)
    ]


def last(parameters, states, seed=0, start=None):
    odometry = DriftingOdometry(parameters, start or Pose(), np.random.default_rng(seed))
    for state in states:
        sample = odometry.update(truth(state), DT)
    return sample.pose


def ends(parameters, states):
    """x, y and yaw at the end, (SEEDS, 3)."""
    poses = [last(parameters, states, seed) for seed in range(SEEDS)]
    return np.array([(*pose.position_m[:2], pose.yaw_rad) for pose in poses])


def wandering(count=3000, seed=5):
    """A flight that climbs, leans and turns."""
    rng = np.random.default_rng(seed)
    pose, states = Pose.from_xyz_rpy(1, 2, 3, 0, 0, 0.5), []
    for k in range(count):
        x, y, z = pose.position_m
        yaw = pose.yaw_rad + 0.01 * math.sin(0.01 * k)
        roll, pitch = 0.3 * math.sin(0.05 * k), 0.2 * math.cos(0.07 * k)
        speed = 0.02
        pose = Pose.from_xyz_rpy(
            x + speed * math.cos(yaw), y + speed * math.sin(yaw), z + 0.01 * rng.normal(), roll, pitch, yaw
        )
        states.append(
            BodyState(pose, (speed / DT * math.cos(yaw), speed / DT * math.sin(yaw), 0.0), (0, 0, 1.0))
        )
    return states


def test_without_drift_odometry_is_the_truth_exactly():
    odometry = DriftingOdometry(
        OdometryParameters.none(), Pose.from_xyz_rpy(1, 2, 3, 0, 0, 0.5), np.random.default_rng(0)
    )
    for state in wandering():
        sample = odometry.update(truth(state), DT)
        assert sample == truth(state)


def test_it_starts_at_the_spawn_pose_and_does_not_drift_while_hovering():
    start = Pose.from_xyz_rpy(3, -4, 0.1, 0, 0, 2.0)
    odometry = DriftingOdometry(OdometryParameters(), start, np.random.default_rng(0))
    for _ in range(1000):
        sample = odometry.update(truth(BodyState(start)), DT)
    np.testing.assert_allclose(sample.pose.position_m, start.position_m, atol=1e-12)
    assert sample.pose.yaw_rad == pytest.approx(2.0, abs=1e-12)


def test_height_roll_and_pitch_are_exact():
    odometry = DriftingOdometry(
        OdometryParameters(), Pose.from_xyz_rpy(1, 2, 3, 0, 0, 0.5), np.random.default_rng(0)
    )
    for state in wandering():
        sample = odometry.update(truth(state), DT)
        assert sample.pose.position_m[2] == state.pose.position_m[2]
        np.testing.assert_allclose(sample.pose.rpy_rad[:2], state.pose.rpy_rad[:2], atol=1e-9)
    assert abs(wrap_angle(sample.pose.yaw_rad - state.pose.yaw_rad)) > 0.01


def test_the_scale_error_alone_stretches_the_way_by_one_percent():
    scale_only = OdometryParameters(0.01, 0.0, 0.0, 0.0, 0.0)
    pose = last(scale_only, straight(50.0))
    np.testing.assert_allclose(pose.position_m, (50.5, 0.0, 1.0), atol=1e-9)
    odometry = DriftingOdometry(scale_only, Pose(), np.random.default_rng(0))
    assert odometry.update(truth(straight(1.0, speed=2.0)[0]), DT).linear_velocity_m_s[0] == pytest.approx(
        2.02
    )


def test_the_heading_bias_alone_bends_a_straight_way_into_an_arc():
    bias = 0.002
    pose = last(OdometryParameters(0.0, bias, 0.0, 0.0, 0.0), straight(100.0, speed=2.0))
    # An arc of curvature b and length s ends at (sin(b s), 1 - cos(b s)) / b, heading b s. The heading of a
    # step of 2 cm is taken at its start, which is b x 1 cm too little.
    assert pose.yaw_rad == pytest.approx(bias * 100.0, abs=1e-9)
    expected = (math.sin(0.2) / bias, (1 - math.cos(0.2)) / bias)
    np.testing.assert_allclose(pose.position_m[:2], expected, atol=bias * 0.01 * 100 + 1e-6)


def test_the_statistics_do_not_depend_on_the_rate():
    fine = straight(16.0, speed=4.0)
    xs, ys, yaws = ends(OdometryParameters(0.0, 0.0, 0.02, 0.01, 0.02), fine).T
    assert xs.std() == pytest.approx(0.08, abs=5 * 0.08 / 28)
    assert yaws.std() == pytest.approx(0.04, abs=5 * 0.04 / 28)
    # Sideways the random heading adds its integral: s^3 / 3 x (0.01)^2.
    sigma_y = math.sqrt(0.08**2 + 16.0**3 / 3 * 0.01**2)
    assert ys.std() == pytest.approx(sigma_y, abs=5 * sigma_y / 28)


def test_it_drifts_but_never_jumps():
    odometry = DriftingOdometry(
        OdometryParameters(), Pose.from_xyz_rpy(1, 2, 3, 0, 0, 0.5), np.random.default_rng(2)
    )
    before, true_before = None, None
    for state in wandering():
        here, true = (
            np.array(odometry.update(truth(state), DT).pose.position_m),
            np.array(state.pose.position_m),
        )
        if before is not None:
            step, true_step = np.linalg.norm(here - before), np.linalg.norm(true - true_before)
            # 2 cm of way have a noise of 0.02 sqrt(0.02) = 2.8 mm a step: six sigma and the scale.
            assert abs(step - true_step) < 0.02
        before, true_before = here, true
    assert np.linalg.norm(here[:2] - true[:2]) > 0.05


def test_being_put_elsewhere_by_hand_is_not_travelling():
    odometry = DriftingOdometry(OdometryParameters(), Pose(), np.random.default_rng(0))
    before = odometry.update(truth(BodyState(Pose.from_xyz_rpy(0.01, 0, 0))), DT).pose
    after = odometry.update(truth(BodyState(Pose.from_xyz_rpy(50, 7, 0))), DT).pose
    assert after.position_m == before.position_m
    onward = odometry.update(truth(BodyState(Pose.from_xyz_rpy(50.01, 7, 0))), DT).pose
    assert onward.position_m[0] - before.position_m[0] == pytest.approx(0.0101, abs=0.012)


def test_the_same_seed_drifts_the_same_and_a_reset_starts_anew():
    states = wandering(300)
    start = Pose.from_xyz_rpy(1, 2, 3, 0, 0, 0.5)
    assert last(OdometryParameters(), states, 4, start) == last(OdometryParameters(), states, 4, start)
    assert last(OdometryParameters(), states, 4, start) != last(OdometryParameters(), states, 5, start)
    odometry = DriftingOdometry(OdometryParameters(), start, np.random.default_rng(0))
    for state in states:
        odometry.update(truth(state), DT)
    odometry.reset()
    assert odometry.update(truth(BodyState(start)), DT).pose.position_m == start.position_m


class Reference:
    """The same integration step by step, with the functions of `geometry`."""

    def __init__(self, parameters, start, rng):
        self.p, self.rng = parameters, rng
        self.true_xy = self.xy = start.position_m[:2]
        self.true_yaw = self.yaw = start.yaw_rad

    def update(self, pose):
        p, (x, y, z) = self.p, pose.position_m
        dx, dy = x - self.true_xy[0], y - self.true_xy[1]
        turned, error = wrap_angle(pose.yaw_rad - self.true_yaw), self.yaw - self.true_yaw
        self.true_xy, self.true_yaw = (x, y), pose.yaw_rad
        way = math.hypot(dx, dy)
        along, across, heading = self.rng.standard_normal(3)
        c, s, scale = math.cos(error), math.sin(error), 1.0 + p.scale_error
        noise = p.position_noise_m_per_sqrt_m * math.sqrt(way)
        self.xy = (
            self.xy[0] + scale * (c * dx - s * dy) + noise * along,
            self.xy[1] + scale * (s * dx + c * dy) + noise * across,
        )
        variance = p.heading_noise_rad_per_sqrt_m**2 * way + p.heading_noise_rad_per_sqrt_rad**2 * abs(turned)
        self.yaw += turned + p.heading_bias_rad_per_m * way + math.sqrt(variance) * heading
        drift = quaternion_from_rpy(0.0, 0.0, self.yaw - self.true_yaw)
        return Pose((*self.xy, z), quaternion_multiply(drift, pose.orientation_xyzw))


@pytest.mark.table("turn_per_step_rad", [0.1, -0.1, 3.0])
def test_each_step_is_that_of_the_reference(turn_per_step_rad):
    parameters = OdometryParameters(0.02, 0.01, 0.03, 0.02, 0.04)
    start = Pose.from_xyz_rpy(1, 2, 3, 0, 0, 3.0)
    odometry = DriftingOdometry(parameters, start, np.random.default_rng(6))
    reference = Reference(parameters, start, np.random.default_rng(6))
    for k in range(300):
        pose = Pose.from_xyz_rpy(
            1 + 0.01 * k, 2 - 0.02 * k, 3, 0.1, -0.2, wrap_angle(3.0 + k * turn_per_step_rad)
        )
        assert odometry.update(truth(BodyState(pose)), DT).pose == reference.update(pose)
