"""Velocity and places in closed form: what does not fit is found, and what flies well is believed."""

import math

import numpy as np
import pytest

from input_checks.velocity import VelocityCheck

PERIOD_S = 0.02
YAW_RAD = 1.2


class Flight:
    """A UAV with a heading, and a check that hears of it."""

    def __init__(self, yaw_rad=YAW_RAD):
        self.said, self.time_s, self.place_m = [], 100.0, np.zeros(3)
        self.check = VelocityCheck(self.said.append)
        self.yaw_rad = yaw_rad

    def axes(self):
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def fly(
        self, velocity, seconds, told=lambda flown, axes: axes.T @ flown, turn_rad_s=0.0, off=None, **given
    ):
        """Fly at a velocity(s) along the odometry's axes; return true and found velocity of the body, (n, 3).

        told(flown, axes): what odometry tells. off(s): errors of its places.
        """
        found = []
        for k in range(round(seconds / PERIOD_S)):
            flown = np.array(velocity(k * PERIOD_S), float)
            self.time_s += PERIOD_S
            self.place_m = self.place_m + PERIOD_S * flown
            self.yaw_rad += PERIOD_S * turn_rad_s
            axes, half = self.axes(), 0.5 * self.yaw_rad
            place = self.place_m if off is None else self.place_m + off(k * PERIOD_S)
            level = (0.0, 0.0, math.sin(half), math.cos(half))
            args = round(1e9 * self.time_s), tuple(told(flown, axes)), tuple(place), level
            found.append((axes.T @ flown, self.check.velocity(*args, **given)))
        return tuple(np.array(found).swapaxes(0, 1))


def speeding_up(most_m_s, to=(1.0, 0.0, 0.0)):
    """From rest, by 3 m/s2."""
    return lambda at_s: min(most_m_s, 3.0 * at_s) * np.array(to)


def world(flown, axes):
    return flown


def frd(flown, axes):
    return axes.T @ flown * (1.0, -1.0, -1.0)


@pytest.mark.table(
    ("told", "word"),
    [
        (world, "header.frame_id"),
        (frd, "FRD"),
        (lambda flown, axes: np.zeros(3), "empty"),
        (lambda flown, axes: 3.6 * axes.T @ flown, "unit"),
        (lambda flown, axes: 100.0 * axes.T @ flown, "unit"),
    ],
)
def test_a_velocity_that_does_not_fit_is_told_and_the_places_count(told, word):
    flight = Flight()
    true, found = flight.fly(speeding_up(3.0), 4.0, told)
    assert len(flight.said) == 1
    assert "velocity (twist)" in flight.said[0]
    assert word in flight.said[0]
    np.testing.assert_allclose(found[-100:], true[-100:], atol=1e-9)
    # The speed at which it is noticed is below what is reached within the window of 0.8 s and one second
    wrong = np.linalg.norm(found - true, axis=1) > 0.5
    assert PERIOD_S * np.flatnonzero(wrong)[-1] < 1.3


def test_a_velocity_in_the_frame_that_child_frame_id_names_is_turned_into_the_bodys_axes():
    flight = Flight()
    true, found = flight.fly(speeding_up(3.0), 4.0, world, turn_rad_s=0.5, is_of_odometry=True)
    np.testing.assert_allclose(found, true, atol=1e-12)
    assert not flight.said


def test_child_frame_id_may_be_wrong_in_either_way():
    flight = Flight()
    true, found = flight.fly(speeding_up(3.0), 4.0, is_of_odometry=True)
    assert len(flight.said) == 1
    assert "set child_frame_id to the frame of the body" in flight.said[0]
    np.testing.assert_allclose(found[-100:], true[-100:], atol=1e-9)


def noisy(rng, place_m=0.02, drift_m_s=0.1):
    return lambda at_s: rng.normal(0.0, place_m, 3) + drift_m_s * at_s * np.array([0.6, 0.8, 0.0])


def test_noise_drift_lag_and_a_jump_are_no_contradiction():
    rng = np.random.default_rng(1)

    def manoeuvres(at_s):  # up to 4 m/s, and 6 m/s2
        return np.array([4.0 * math.sin(1.5 * at_s), 2.0 * math.cos(1.1 * at_s), 0.3 * math.sin(at_s)])

    def told(at_s):
        return manoeuvres(max(0.0, at_s - 0.15)) + rng.normal(0.0, 0.1, 3)

    flight = Flight()
    for k in range(3000):
        at_s = k * PERIOD_S
        flight.yaw_rad += PERIOD_S * math.sin(0.3 * at_s)
        axes, half = flight.axes(), 0.5 * flight.yaw_rad
        flight.place_m = flight.place_m + PERIOD_S * manoeuvres(at_s)
        jump_m = 0.6 * (at_s > 20.0)  # as when a map corrects the places
        place = flight.place_m * 1.05 + rng.normal(0.0, 0.02, 3) + (0.1 * at_s + jump_m, 0.0, 0.0)
        level = (0.0, 0.0, math.sin(half), math.cos(half))
        given = tuple(axes.T @ told(at_s))
        assert flight.check.velocity(round(1e9 * at_s), given, tuple(place), level) == given
    assert not flight.said
    assert flight.check.is_confirmed


def test_a_slow_uav_and_one_that_hovers_are_believed():
    rng = np.random.default_rng(2)
    for velocity, told in (
        (lambda at_s: (0.2 * math.sin(at_s), 0.2, 0.0), world),
        (lambda at_s: np.zeros(3), frd),
    ):
        flight = Flight()
        flight.fly(velocity, 30.0, told, off=noisy(rng))
        assert not flight.said
        assert not flight.check.is_confirmed


def test_a_twist_that_comes_back_is_believed_again_only_after_a_while_in_motion():
    flight = Flight()
    flight.fly(speeding_up(2.0), 3.0, lambda flown, axes: np.zeros(3))
    flight.fly(lambda at_s: np.zeros(3), 10.0)
    noisy_told = lambda flown, axes: axes.T @ flown + (0.0, 0.0, 0.125)  # noqa: E731
    _, found = flight.fly(speeding_up(2.0), 3.0, noisy_told)
    assert not (found[:, 2] == 0.125).any()  # the difference of the places counts
    _, found = flight.fly(lambda at_s: (2.0, 0.0, 0.0), 5.0, noisy_told)
    assert found[-1, 2] == 0.125


def test_after_a_restart_and_a_gap_nothing_of_before_counts():
    flight = Flight()
    flight.fly(speeding_up(3.0), 0.6, world)
    flight.time_s += 1.0
    flight.place_m = flight.place_m + 50.0
    flight.fly(speeding_up(3.0), 0.6)
    assert not flight.said
    flight.fly(speeding_up(3.0), 3.0, world)
    flight.check.restart()
    true, found = flight.fly(speeding_up(3.0), 3.0)
    np.testing.assert_allclose(found, true, atol=1e-12)
