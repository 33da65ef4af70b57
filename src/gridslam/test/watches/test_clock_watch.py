"""Odometry with stamps of other times than those of the scans is told once; turns alone tell it."""

from dataclasses import replace

import numpy as np
import planar_world
import pytest

from gridslam.watches.clock_watch import PAIRS_MAX, ClockWatch, offset_of

LIDAR = planar_world.Lidar(4.7, 180, 10.0, 0.01, 10.0)
ROUTE = np.array([(-8.0, -5.0), (8.0, -5.0)])
PERIOD_S = 0.25
STAMPS_S = PERIOD_S * np.arange(80)


def yaw(stamps_s):
    """Turns of up to 0.9 rad/s that do not repeat."""
    return 0.8 * np.sin(0.7 * stamps_s) + 0.6 * np.sin(0.55 * stamps_s + 1.0)


@pytest.fixture(scope="module")
def scans():
    walls, rng = planar_world.scattered_boxes(1, ROUTE), np.random.default_rng(2)
    poses = np.column_stack([-4.0 + 0.1 * STAMPS_S, np.full(len(STAMPS_S), -5.0), yaw(STAMPS_S)])
    return [planar_world.scan_at(walls, pose, LIDAR, rng, stamp) for pose, stamp in zip(poses, STAMPS_S)]


def said_of(scans, late_s):
    """All that is said if odometry has at each stamp the yaw of so much earlier."""
    watch = ClockWatch()
    told = [watch.check(scan, (0.0, 0.0, float(yaw(scan.stamp_s - late_s)))) for scan in scans]
    return [sentence for sentence in told if sentence]


@pytest.mark.table(("late_s", "words"), [(-0.7, "0.7 s too early"), (1.2, "1.2 s too late")])
def test_other_clocks_are_told_once(scans, late_s, words):
    (said,) = said_of(scans, late_s)
    assert words in said


@pytest.mark.table("late_s", [0.0, -0.15, 0.15])
def test_nothing_is_said_of_clocks_that_agree(scans, late_s):
    assert said_of(scans, late_s) == []


def test_a_vehicle_that_hardly_turns_tells_nothing(scans):
    assert said_of(scans[:12] * 3, 0.7) == []


@pytest.mark.table("late_s", [0.5, -1.5, 1.95])
def test_the_offset_is_that_of_exact_turns(late_s):
    times_s = np.arange(0.0, 30.0, 0.1)
    begin_s = np.arange(0.0, 29.0, 0.5)
    turns = np.column_stack([begin_s, begin_s + 0.5, yaw(begin_s + 0.5) - yaw(begin_s)])
    odometry = np.column_stack([times_s, np.angle(np.exp(1j * yaw(times_s - late_s)))])
    assert offset_of(turns, odometry) == pytest.approx(late_s)


def test_a_wheel_that_slips_is_no_matter_of_clocks():
    # Given odometry that tells only a fifth of each turn
    times_s, begin_s = np.arange(0.0, 30.0, 0.1), np.arange(0.0, 29.0, 0.5)
    turns = np.column_stack([begin_s, begin_s + 0.5, yaw(begin_s + 0.5) - yaw(begin_s)])
    assert offset_of(turns, np.column_stack([times_s, 0.2 * yaw(times_s)])) == 0.0


def test_scans_that_are_too_far_apart_do_not_keep_it_waiting(scans):
    """It would hold the yaw of each scan for ever."""
    watch = ClockWatch()
    for number in range(2 * PAIRS_MAX):
        assert watch.check(replace(scans[0], stamp_s=2.0 * number), (0.0, 0.0, 0.0)) == ""
    assert len(watch._told) <= PAIRS_MAX
