"""The time without an external pose after which the UAV stops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from simulation_tools.publisher import PublisherParameters
from simulation_tools.publisher.vision_watch import VisionWatch

MS = 1_000_000
FLYING = PublisherParameters(needs_vision=True)


def limit_ms(gaps_ms, p=FLYING):
    """Return the time after which the UAV is blind, with these gaps before."""
    watch, now_ms = VisionWatch(), 5000
    watch.expect_pose(now_ms * MS, p)
    for gap_ms in (0, *gaps_ms):
        now_ms += gap_ms
        watch.on_pose(now_ms * MS)
    return next(ms for ms in range(1000) if watch.blindness((now_ms + ms) * MS, p).is_too_long)


@pytest.mark.table(
    ("gaps_ms", "expected_ms"),
    [
        (20 * [25], 70),  # never before vision_timeout_least_s
        (20 * [100], 115),  # evenly: one gap and 15 ms
        ([*(50 * [25]), 55, *(20 * [25])], 70),  # once is no rule
        ([*(50 * [25]), 55, 75, *(20 * [25])], 85),  # a busy machine: 30 ms late, so it may be 45 ms late
        ([*(50 * [25]), 90, 90, *(20 * [25])], 110),  # never after vision_timeout_s,
        (20 * [200], 215),  # unless poses come more rarely
        ([300, 300, *(20 * [200])], 280),
        (20 * [120, 0, 0], 135),  # three poses at once, as of a slow lidar, are one
        (20 * [0], 70),
        (5 * [25], 110),  # too few to know
        ([65, 65, *(398 * [25])], 100),
        ([65, 65, *(399 * [25])], 70),  # a gap is forgotten
    ],
)
def test_the_limit_follows_the_longest_gap_but_one(gaps_ms, expected_ms):
    assert limit_ms(gaps_ms) == pytest.approx(expected_ms, abs=1)


@pytest.mark.table(("period_ms", "expected_ms"), [(25, 110), (50, 200), (100, 400)])
def test_in_lockstep_a_pose_may_be_heard_some_gaps_late(period_ms, expected_ms):
    assert limit_ms(20 * [period_ms], replace(FLYING, in_lockstep=True)) == pytest.approx(expected_ms, abs=1)


def test_without_need_for_poses_or_before_one_can_come_nobody_is_blind():
    watch = VisionWatch()
    assert not watch.blindness(1000 * MS, FLYING).is_too_long
    watch.expect_pose(1000 * MS, FLYING)
    assert watch.blindness(1000 * MS, FLYING).is_too_long
    assert watch.blindness(9000 * MS, PublisherParameters()) == (0.0, False)


@pytest.mark.table("period_ms", [25, 33, 50, 67, 100])  # of the six lidars
def test_a_late_pose_raises_no_alarm_if_two_were_two_thirds_as_late_before(period_ms):
    rng = np.random.default_rng(period_ms)
    for worst_ms in (5, 20, 40):
        lateness_ms = rng.uniform(0.0, worst_ms, 300)
        stamps_ms = 5000.0 + period_ms * np.arange(300) + lateness_ms
        gaps_ms = np.diff(stamps_ms)
        for n in range(20, 299):
            learned_ms = np.sort(gaps_ms[:n])[-2]
            if gaps_ms[n] - period_ms <= 1.5 * (learned_ms - period_ms):
                assert limit_ms(gaps_ms[:n]) >= min(gaps_ms[n], 110.0) - 1.0


def test_of_a_fast_lidar_one_scan_may_be_lost_and_of_a_slow_one_none():
    assert limit_ms(20 * [25]) > 2 * 25
    assert limit_ms(20 * [100]) < 2 * 100


def test_a_lost_scan_does_not_delay_the_next_stop():
    assert limit_ms([*(20 * [100]), 200, *(20 * [100])]) == limit_ms(20 * [100])
