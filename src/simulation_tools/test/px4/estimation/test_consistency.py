"""Is the filter as good as it says? NEES and NIS over 100 seeded flights against chi-square bounds.

Y. Bar-Shalom, X. R. Li and T. Kirubarajan, "Estimation with applications to tracking and navigation", 2001,
section 5.4. The noise is what the filter believes; measurements are late, as in flight.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy
from scipy.spatial.transform import Rotation

from simulation_tools.px4.estimation.error_state_filter import ErrorStateFilter
from simulation_tools.px4.estimation.kernels.states import ERROR_SIZE
from simulation_tools.px4.estimation.settings import FilterSettings
from simulation_tools.px4.parameters import Px4Parameters

FLIGHTS, STEPS, DT_US = 100, 750, 8_000  # 6 s each
DT_S = 1e-6 * DT_US
PX4_DT_S = 0.010  # of the sample that PX4's noise parameters are meant for
NOISIER = np.sqrt(PX4_DT_S / DT_S)  # a shorter sample averages less
DELAY_STEPS = 6
VISION_EVERY = 4
PARAMETERS = {"EKF2_AID_MASK": 24, "EKF2_EV_DELAY": 1e-3 * DELAY_STEPS * DT_US, "EKF2_EVA_NOISE": 0.05}
INITIAL = np.repeat([0.5, 0.5, 0.03, 0.1, 0.02], 3)  # deviations of the error state at the start
WIDE = 100.0  # a gate that rejects nothing


def trajectory():
    """Return what a perfect IMU measures, and the truth after each sample: turning, speeding, weaving."""
    t = DT_S * (np.arange(STEPS) + 1.0)
    rates = np.column_stack((0.3 * np.sin(2.0 * t), 0.2 * np.cos(3.0 * t), 0.5 * np.sin(0.7 * t)))
    pushed = np.column_stack((2.0 * np.sin(1.3 * t), 1.5 * np.cos(t), np.sin(2.5 * t)))  # m/s2, NED
    attitude, velocity, position = Rotation.identity(), np.zeros(3), np.zeros(3)
    force, truth = np.empty((STEPS, 3)), []
    for k in range(STEPS):
        attitude = attitude * Rotation.from_rotvec(rates[k] * DT_S)
        force[k] = attitude.inv().apply(pushed[k] - [0.0, 0.0, 9.80665])
        position = position + (velocity + 0.5 * pushed[k] * DT_S) * DT_S
        velocity = velocity + pushed[k] * DT_S
        truth.append((position, velocity, attitude))
    return rates, force, truth


def fly(seed, rates, force, truth):
    """Return the NEES at the end, and the NIS of every measured position component and heading."""
    rng = np.random.default_rng(seed)
    settings = FilterSettings.of(Px4Parameters(PARAMETERS))
    s = settings
    deviations = NOISIER * np.array([s.rate_noise_rad_s, s.acceleration_noise_m_s2])
    drifts = NOISIER * DT_S * np.array([s.rate_bias_noise_rad_s2, s.acceleration_bias_noise_m_s3])
    ekf = ErrorStateFilter(settings)
    ekf.start(np.array([0.0, 0.0, -9.80665]))
    error = INITIAL * rng.standard_normal(ERROR_SIZE)
    ekf.covariance[:] = np.diag(INITIAL**2)
    ekf.state[:6] = -error[:6]
    x, y, z, w = Rotation.from_rotvec(-error[6:9]).as_quat()
    ekf.state[6:10] = (w, x, y, z)
    biases = np.vstack((error[12:], error[9:12]))  # gyroscope, accelerometer; the filter takes them for zero
    past, nis = [], []
    for k in range(STEPS):
        biases = biases + drifts[:, None] * rng.standard_normal((2, 3))
        past.append(biases)
        noise = deviations[:, None] * rng.standard_normal((2, 3)) + biases
        due = ekf.advance((k + 1) * DT_US, DT_S, rates[k] + noise[0], force[k] + noise[1])
        at = ekf.horizon_us // DT_US - 1
        if due and k % VISION_EVERY == 0:
            position, _, attitude = truth[at]
            for i in range(3):
                variance = np.array([s.vision_position.variance])
                measured = position[i : i + 1] + s.vision_position.noise * rng.standard_normal(1)
                nis.append(WIDE**2 * ekf.fuse_position(i, measured, variance, WIDE))
            yaw = attitude.as_euler("ZYX")[0] + s.vision_yaw.noise * rng.standard_normal()
            nis.append(WIDE**2 * ekf.fuse_yaw(yaw, s.vision_yaw.variance, WIDE, False))
    position, velocity, attitude = truth[at]
    w, x, y, z = ekf.state[6:10]
    turn = (attitude * Rotation.from_quat((x, y, z, w)).inv()).as_rotvec()
    found = [position - ekf.state[:3], velocity - ekf.state[3:6], turn]
    found += [past[at][1] - ekf.state[10:13], past[at][0] - ekf.state[13:16]]
    error = np.concatenate(found)
    return error @ np.linalg.solve(ekf.covariance, error), nis


@pytest.fixture(scope="module")
def flights():
    flown = trajectory()
    return [fly(seed, *flown) for seed in range(FLIGHTS)]


def test_the_errors_are_as_great_as_the_covariance_says(flights):
    mean = np.mean([nees for nees, _ in flights])
    low, high = scipy.stats.chi2.ppf((0.005, 0.995), FLIGHTS * ERROR_SIZE) / FLIGHTS
    assert low < mean < high


def test_the_innovations_are_as_great_as_the_filter_expects(flights):
    values = np.concatenate([nis for _, nis in flights])
    low, high = scipy.stats.chi2.ppf((0.005, 0.995), len(values)) / len(values)
    assert low < np.mean(values) < high
