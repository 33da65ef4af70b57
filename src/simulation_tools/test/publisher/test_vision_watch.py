"""The time without an external pose after which the UAV stops."""

from __future__ import annotations

import pytest

from simulation_tools.publisher import PublisherParameters
from simulation_tools.publisher.vision_watch import VisionWatch

MS = 1_000_000
FLYING = PublisherParameters(needs_vision=True)


def limit_ms(gaps_ms):
    """Return the time after which the UAV is blind, with these gaps before."""
    watch, now_ms = VisionWatch(), 5000
    watch.expect_pose(now_ms * MS, FLYING)
    for gap_ms in (0, *gaps_ms):
        now_ms += gap_ms
        watch.on_pose(now_ms * MS)
    return next(ms for ms in range(1000) if watch.blindness((now_ms + ms) * MS, FLYING).is_too_long)


@pytest.mark.parametrize(
    ("gaps_ms", "expected_ms"),
    [
        (20 * [25], 80),  # never before vision_timeout_least_s
        (20 * [40], 110),  # two gaps and 30 ms
        ([*(50 * [25]), 55, *(20 * [25])], 140),  # a busy machine: the longest gap counts
        (20 * [120], 250),  # never after vision_timeout_s
        (5 * [25], 250),  # too few to know
        ([55, *(399 * [25])], 140),
        ([55, *(400 * [25])], 80),  # a gap is forgotten
    ],
)
def test_the_limit_follows_the_longest_gap(gaps_ms, expected_ms):
    assert limit_ms(gaps_ms) == pytest.approx(expected_ms, abs=1)


def test_without_need_for_poses_or_before_one_can_come_nobody_is_blind():
    watch = VisionWatch()
    assert not watch.blindness(1000 * MS, FLYING).is_too_long
    watch.expect_pose(1000 * MS, FLYING)
    assert watch.blindness(1000 * MS, FLYING).is_too_long
    assert watch.blindness(9000 * MS, PublisherParameters()) == (0.0, False)
