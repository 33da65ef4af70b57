"""A single pose that no UAV can have come to is left out; a jump that lasts is taken."""

import numpy as np
import pytest

from flight_basics.pose.jumps import PoseJumps

HERE_M, PERIOD_S = np.array((1.0, 2.0, 3.0)), 0.05


def wild_ones(places_m, stamps_s=None):
    """Return which poses are left out."""
    jumps = PoseJumps()
    stamps_s = PERIOD_S * np.arange(len(places_m)) if stamps_s is None else stamps_s
    return [jumps.is_wild(stamp_s, np.array(place_m)) for stamp_s, place_m in zip(stamps_s, places_m)]


def test_a_single_pose_a_kilometre_off_is_left_out():
    assert wild_ones([HERE_M, np.add(HERE_M, (1000.0, 0.0, 0.0)), HERE_M]) == [False, True, False]


def test_poses_that_are_wild_in_different_places_are_left_out_for_as_long_as_they_come():
    rng = np.random.default_rng(1)
    wild = list(rng.uniform(-1e4, 1e4, (20, 3)))
    assert wild_ones([HERE_M, *wild, HERE_M]) == [False, *[True] * 20, False]


@pytest.mark.table("metres", [0.5, 1.9])
def test_the_correction_of_a_loop_closure_is_taken_at_once(metres):
    there_m = np.add(HERE_M, (0.0, metres, 0.0))
    assert not any(wild_ones([HERE_M, there_m, there_m]))


@pytest.mark.table("metres", [6.0, 300.0])
def test_a_greater_jump_that_lasts_is_taken_with_its_third_pose(metres):
    there_m = np.add(HERE_M, (0.0, metres, 0.0))
    assert wild_ones([HERE_M, *[there_m] * 5]) == [False, True, True, False, False, False]


def test_a_uav_may_be_far_away_after_a_gap():
    assert wild_ones([HERE_M, np.add(HERE_M, (60.0, 0.0, 0.0))], (0.0, 5.0)) == [False, False]


def test_a_clock_that_jumps_back_leaves_nothing_out():
    assert wild_ones([HERE_M, np.add(HERE_M, (0.1, 0.0, 0.0))], (100.0, 0.0)) == [False, False]
