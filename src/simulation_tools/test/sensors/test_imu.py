"""What an IMU feels: at rest, falling, off-centre in a turn, turned on its mount; and its noise."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simulation_tools.geometry import Pose, quaternion_from_rpy
from simulation_tools.sdf.elements import ImuSensor, Noise
from simulation_tools.sensors.imu import Imu, specific_force

G = 9.8
GRAVITY = (0.0, 0.0, -G)
LEVEL = (0.0, 0.0, 0.0, 1.0)
REST = (0.0, 0.0, G)
STILL = (0.0, 0.0, 0.0)


def imu(pose=None, seed=1, gyroscope=(0.0, 0.0, 0.0), accelerometer=(0.0, 0.0, 0.0)):
    sensor = ImuSensor(
        "imu",
        Pose(),
        100.0,
        tuple(Noise(0.0, sigma) for sigma in gyroscope),
        tuple(Noise(0.1, sigma) for sigma in accelerometer) if any(accelerometer) else (Noise(),) * 3,
    )
    return Imu(sensor, pose or Pose(), np.random.default_rng(seed))


def test_at_rest_it_feels_the_ground_pushing_up():
    assert specific_force(STILL, STILL, 0.004, GRAVITY, LEVEL) == pytest.approx(REST)


def test_in_free_fall_it_feels_nothing():
    force = specific_force((1, 0, 0), (1, 0, -G * 0.004), 0.004, GRAVITY, quaternion_from_rpy(0.3, 0.2, 1.0))
    assert force == pytest.approx(STILL, abs=1e-9)


def test_leaning_it_feels_the_ground_aside():
    # Rolled to the right by 30 degrees: half of g points to the body's left.
    force = specific_force(STILL, STILL, 0.004, GRAVITY, quaternion_from_rpy(math.radians(30), 0, 0))
    assert force == pytest.approx((0.0, 0.5 * G, math.sqrt(0.75) * G))


def test_off_centre_it_feels_the_turn():
    # At 0.2 m ahead of the origin, at 3 rad/s and 5 rad/s2: w^2 r inwards, a r sideways.
    sample = imu(Pose((0.2, 0.0, 0.0))).sample(LEVEL, REST, (0.0, 0.0, 3.0), (0.0, 0.0, 5.0))
    assert sample.linear_acceleration_m_s2 == pytest.approx((-9.0 * 0.2, 5.0 * 0.2, G))
    assert sample.angular_velocity_rad_s == pytest.approx((0.0, 0.0, 3.0))


def test_it_measures_in_its_own_axes():
    # Mounted with a quarter turn to the left, the body's x axis is its -y axis.
    mount = Pose.from_xyz_rpy(0, 0, 0, 0, 0, math.pi / 2)
    sample = imu(mount).sample(LEVEL, (1.0, 0.0, G), (2.0, 0.0, 0.0))
    assert sample.linear_acceleration_m_s2 == pytest.approx((0.0, -1.0, G), abs=1e-12)
    assert sample.angular_velocity_rad_s == pytest.approx((0.0, -2.0, 0.0), abs=1e-12)
    assert sample.orientation_xyzw == pytest.approx(quaternion_from_rpy(0, 0, math.pi / 2))


def test_noise_of_each_axis_is_as_stated_and_seeded():
    sigmas = (0.01, 0.02, 0.03, 0.1, 0.2, 0.3)
    device = imu(gyroscope=sigmas[:3], accelerometer=sigmas[3:])
    samples = [device.sample(LEVEL, REST, STILL) for _ in range(4000)]
    values = np.array([(*s.angular_velocity_rad_s, *s.linear_acceleration_m_s2) for s in samples])
    # The deviation of 4000 samples is known to 1.1 %; the mean to sigma / 63. Five of each.
    np.testing.assert_allclose(values.std(axis=0), sigmas, rtol=0.06)
    expected = np.array((0.0, 0.0, 0.0, 0.1, 0.1, G + 0.1))
    assert (abs(values.mean(axis=0) - expected) < 0.08 * np.array(sigmas)).all()
    again = imu(gyroscope=sigmas[:3], accelerometer=sigmas[3:])
    assert again.sample(LEVEL, REST, STILL) == samples[0]


def test_the_period_is_that_of_the_rate():
    assert imu().period_us == 10_000
