"""How uncertain the newest pose is, by closed forms along a straight way."""

import math

import numpy as np
import pytest
from room_paths import path_along

from gridslam.loop_closure.edges import Match
from gridslam.loop_closure.path.pose_spread import pose_spread

ALONG_M, ACROSS_M, TURN_RAD = 0.03, 0.02, 0.01
STEPS, STEP_M = 12, 0.5


@pytest.fixture
def straight():
    """A path of 12 steps of 0.5 m towards y, and the covariances of its steps."""
    poses = np.column_stack(
        [np.zeros(STEPS + 1), STEP_M * np.arange(STEPS + 1), np.full(STEPS + 1, np.pi / 2)]
    )
    return path_along(poses), np.tile(np.diag([ALONG_M, ACROSS_M, TURN_RAD]) ** 2, (STEPS, 1, 1))


def along_across(steps):
    """Variances along and across after so many steps: each turn's error moves what comes after it."""
    levers_m = STEP_M * np.arange(steps)
    return steps * ALONG_M**2, steps * ACROSS_M**2 + TURN_RAD**2 * float(levers_m @ levers_m)


def test_without_closures_the_errors_of_all_steps_add_up(straight):
    path, steps = straight
    spread = pose_spread(path, steps, [], recognised=0)
    along, across = along_across(STEPS)
    assert np.diag(spread.in_map) == pytest.approx((across, along, STEPS * TURN_RAD**2))  # y is along
    assert spread.since_recognised_m == pytest.approx(math.sqrt(max(along, across)))
    assert spread.in_map_m == spread.since_recognised_m


def test_only_the_way_since_the_place_that_was_recognised_counts(straight):
    path, steps = straight
    spread = pose_spread(path, steps, [], recognised=STEPS - 4)
    assert spread.since_recognised_m == pytest.approx(math.sqrt(max(along_across(4))))
    assert spread.in_map_m == pose_spread(path, steps, [], recognised=0).in_map_m
    assert pose_spread(path, steps, [], recognised=STEPS).since_recognised_m == 0.0


def test_a_closure_is_a_short_way_to_the_beginning(straight):
    path, steps = straight
    place = np.diag([0.02, 0.02, 0.003]) ** 2
    closure = Match(0, STEPS, np.array((STEPS * STEP_M, 0.0, 0.0)), place, 0.9)
    spread = pose_spread(path, steps, [closure], recognised=0)
    assert spread.in_map == pytest.approx(place)


def test_a_wrong_step_without_a_scan_counts_wholly(straight):
    path, steps = straight
    steps[3] = np.diag([10.0, 10.0, 0.3]) ** 2
    assert pose_spread(path, steps, [], recognised=0).since_recognised_m > 10.0
    assert pose_spread(path, steps, [], recognised=5).since_recognised_m < 0.3
