"""Whether odometry and IMU agree, for motions whose IMU readings are known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cepa import MotionError
from cepa.motion import DOUBTED, Doubt
from cepa.steering.inertial_check import DOUBTED_S, SILENT_NS, InertialCheck
from cepa.steering.inertial_path import InertialPath, InertialReading
from cepa.steering.own_motion import OwnState

GRAVITY_M_S2 = 9.80665
CONFIRMED = Doubt(False, False)
MS = 1_000_000
RADIUS_M, SPIN_RAD_S = 1.5, 1.2
"""A circle that the UAV flies, its nose ahead."""


def circle(t_s):
    """Return place, yaw and IMU reading of a UAV that flies a circle, its nose along the way."""
    yaw = SPIN_RAD_S * t_s
    place = RADIUS_M * math.sin(yaw), -RADIUS_M * math.cos(yaw), 2.0
    inwards = RADIUS_M * SPIN_RAD_S**2
    return place, yaw, InertialReading((0.0, 0.0, SPIN_RAD_S), (0.0, inwards, GRAVITY_M_S2))


def hover(t_s):
    return (1.0, 2.0, 2.0), 0.5, InertialReading((0.0, 0.0, 0.0), (0.0, 0.0, GRAVITY_M_S2))


def leap(t_s):
    """It speeds up along x at 3 m/s2 from 2 s to 2.5 s: 1.5 m/s, as its IMU feels."""
    sped_s, flown_s = min(max(t_s - 2.0, 0.0), 0.5), max(t_s - 2.5, 0.0)
    force = 3.0 if 2.0 <= t_s < 2.5 else 0.0
    reading = InertialReading((0.0, 0.0, 0.0), (force, 0.0, GRAVITY_M_S2))
    return (1.5 * sped_s**2 + 1.5 * flown_s, 0.0, 2.0), 0.0, reading


class Bench:
    """Tells a check what IMU and odometry measure every 20 and 25 ms, and asks it at each odometry."""

    def __init__(self, motion=hover, drift=lambda t: (0.0, 0.0), noise_m=0.0, has_imu=lambda t: True):
        self.said, self._motion, self._drift, self._has_imu = [], motion, drift, has_imu
        self._noise_m, self._rng = noise_m, np.random.default_rng(1)
        self.check = InertialCheck(self.said.append)

    def doubts(self, until_ms, from_ms=0):
        """Return the doubts by their times in ms."""
        doubts = {}
        for at_ms in range(from_ms, until_ms, 5):
            (x, y, z), yaw, reading = self._motion(1e-3 * at_ms)
            if at_ms % 20 == 0 and self._has_imu(1e-3 * at_ms):
                self.check.on_reading(at_ms * MS, reading)
            if at_ms % 25 == 0:
                shift_m, turn = self._drift(1e-3 * at_ms)
                dx, dy, dz = self._rng.normal(0.0, self._noise_m, 3)
                half = 0.5 * (yaw + turn)
                state = OwnState(
                    (0.0, 0.0, 0.0),
                    (x + shift_m + dx, y + dy, z + dz),
                    (0.0, 0.0, math.sin(half), math.cos(half)),
                )
                self.check.on_odometry(at_ms * MS, state)
                doubts[at_ms] = self.check.doubt_at(at_ms * MS)
        return doubts


@pytest.mark.table("motion", [hover, circle, leap])
@pytest.mark.table("noise_m", [0.0, 0.02])
def test_odometry_is_confirmed_from_a_second_on(motion, noise_m):
    doubts = Bench(motion, noise_m=noise_m).doubts(4000)
    assert all(doubt == DOUBTED for at_ms, doubt in doubts.items() if at_ms < 1000)
    assert all(doubt == CONFIRMED for at_ms, doubt in doubts.items() if at_ms > 1150)


def test_a_heading_that_drifts_is_doubted_and_the_place_is_not():
    doubts = Bench(circle, drift=lambda t: (0.0, 0.05 * max(0.0, t - 2.0))).doubts(4000)
    assert all(doubt == CONFIRMED for at_ms, doubt in doubts.items() if 1150 < at_ms < 2100)
    assert all(doubt == Doubt(True, False) for at_ms, doubt in doubts.items() if at_ms > 2800)


def test_a_place_that_slips_is_doubted_until_it_has_been_steady_for_long():
    # It slips at a steady speed from 2 s to 2.5 s: no accelerometer feels that, but both changes
    bench = Bench(drift=lambda t: (0.5 * min(max(0.0, t - 2.0), 0.5), 0.0))
    doubts = bench.doubts(10_500)
    assert all(doubt == CONFIRMED for at_ms, doubt in doubts.items() if 1150 < at_ms < 2100)
    doubted = [at_ms for at_ms, doubt in doubts.items() if at_ms > 2100 and doubt.shift]
    assert doubted[0] < 2650
    assert 2500 + 1000 * DOUBTED_S < doubted[-1] < 2500 + 1000 * (DOUBTED_S + 1.2)
    assert doubted == list(range(doubted[0], doubted[-1] + 25, 25))
    assert not any(doubt.turn for at_ms, doubt in doubts.items() if at_ms > 1150)


def test_an_odometry_that_does_not_follow_a_leap_is_doubted():
    stays = Bench(leap, drift=lambda t: (-leap(t)[0][0], 0.0)).doubts(4000)
    assert stays[1500] == CONFIRMED
    assert all(doubt == Doubt(False, True) for at_ms, doubt in stays.items() if at_ms > 2700)


def test_without_a_specific_force_the_heading_alone_is_confirmed():
    def blind(t_s):
        place, yaw, reading = circle(t_s)
        return place, yaw, InertialReading(reading.rates_rad_s)

    doubts = Bench(blind).doubts(2000)
    assert all(doubt == Doubt(False, True) for at_ms, doubt in doubts.items() if at_ms > 1150)


def test_while_the_imu_is_silent_all_is_doubted_and_it_is_said_once():
    bench = Bench(circle, has_imu=lambda t: not 2.0 < t < 4.0)
    doubts = bench.doubts(6000)
    assert doubts[2000] == CONFIRMED
    assert all(doubt == DOUBTED for at_ms, doubt in doubts.items() if 2500 < at_ms < 5000)
    assert all(doubt == CONFIRMED for at_ms, doubt in doubts.items() if at_ms > 5200)
    (sentence,) = bench.said
    assert "No reading of the IMU" in sentence


def test_an_imu_that_never_comes_is_told_once():
    bench = Bench(has_imu=lambda t: False)
    for _ in range(2):  # the clock goes back after each
        assert set(bench.doubts(3 * SILENT_NS // MS).values()) == {DOUBTED}
        bench.check.restart()
    assert len(bench.said) == 1


def test_readings_of_an_earlier_instant_are_left_out_and_a_clock_that_goes_back_begins_anew():
    bench = Bench(circle)
    assert bench.doubts(2000)[1975] == CONFIRMED
    spun = InertialReading((0.0, 0.0, 9.0), (0.0, 0.0, 0.0))
    for at_ms in (1900, 1980):
        bench.check.on_reading(at_ms * MS, spun)  # neither is newer than the last
    assert bench.doubts(2200, from_ms=2000)[2175] == CONFIRMED
    bench.check.on_reading(1000 * MS, spun)
    (sentence,) = bench.said
    assert "went back" in sentence
    assert bench.check.doubt_at(2200 * MS) == DOUBTED


def test_a_rate_that_is_not_finite_is_refused():
    with pytest.raises(MotionError, match="not finite"):
        InertialReading((0.0, math.nan, 0.0))


def test_the_path_of_a_circle_is_its_closed_form():
    path = InertialPath(0, circle(0.0)[2])
    for at_ms in range(2, 1002, 2):
        path.take(at_ms * MS, circle(1e-3 * at_ms)[2])
    gained, way = path.next_leg()
    # From rest: without the speed along x at the beginning, and with gravity upwards
    start_m_s = RADIUS_M * SPIN_RAD_S
    turned = np.array([math.cos(SPIN_RAD_S) - 1.0, math.sin(SPIN_RAD_S), 0.0])
    gravity = np.array([0.0, 0.0, GRAVITY_M_S2])
    assert gained == pytest.approx(start_m_s * turned + gravity, abs=1e-4)
    place = np.array(circle(1.0)[0]) - circle(0.0)[0] - (start_m_s, 0.0, 0.0)
    assert way == pytest.approx(place + 0.5 * gravity, abs=1e-4)
    assert path.axes()[:, 0] == pytest.approx((math.cos(SPIN_RAD_S), math.sin(SPIN_RAD_S), 0.0), abs=1e-6)
