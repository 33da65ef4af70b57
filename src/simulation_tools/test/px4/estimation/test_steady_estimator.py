"""The estimate and its errors: closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import linalg

from simulation_tools.autopilot import VehicleState
from simulation_tools.geometry import Pose, quaternion_from_rpy
from simulation_tools.px4.estimation.steady_estimator import (
    GAINS,
    SAMPLE_PERIOD_S,
    EstimatorNoise,
    SteadyEstimator,
)
from simulation_tools.px4.parameters import Px4Parameters


def a_state(yaw=0.3):
    return VehicleState(
        time_us=0,
        pose=Pose((1.0, 2.0, 3.0), quaternion_from_rpy(0.0, 0.0, yaw)),
        velocity_world_m_s=(0.1, 0.2, 0.3),
        angular_velocity_body_rad_s=(0.4, 0.5, 0.6),
        specific_force_body_m_s2=(0.0, 0.0, 9.80665),
    )


def test_a_perfect_estimate_is_the_truth_in_ned_from_the_start():
    estimator = SteadyEstimator(EstimatorNoise.none(), np.random.default_rng(0), Px4Parameters())
    estimator.update(a_state(), 0.004)
    assert estimator.estimate[0]["position"].tolist() == [0.0, 0.0, 0.0]
    assert estimator.origin_m == (1.0, 2.0, 3.0)
    moved = a_state()._replace(pose=Pose((1.5, 4.0, 3.3), a_state().pose.orientation_xyzw))
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
        estimator = SteadyEstimator(noise, np.random.default_rng(seed), Px4Parameters())
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
    estimator = SteadyEstimator(EstimatorNoise(), np.random.default_rng(7), Px4Parameters())
    first = []
    for _ in range(2):
        estimator.reset()
        for _ in range(10):
            estimator.update(a_state(), 0.004)
        first.append(estimator.estimate.copy())
    assert first[0] == first[1]
