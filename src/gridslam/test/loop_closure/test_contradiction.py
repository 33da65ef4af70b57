"""A closure that the corrected path contradicts leaves the pose open, until a later one fits."""

import math

import numpy as np
import pytest
from room_paths import snapshot_along

from gridslam import se2
from gridslam.loop_closure import LoopClosureParameters
from gridslam.loop_closure.edges import Match
from gridslam.loop_closure.path.contradiction import contradicted_m
from gridslam.loop_closure.path.step_uncertainty import DoubtfulNodes
from gridslam.loop_closure.stages import Stages

AROUND = np.radians(np.arange(0.0, 406.0, 9.0))
POSES = np.column_stack([6.0 * np.sin(AROUND), 6.0 * (1.0 - np.cos(AROUND)), AROUND])
"""Once round a circle of 38 m, and a little more: node 40 is at node 0."""


def closure(older, newer, off_m=0.0):
    """Both nodes were recognised at each other's places, so far from where the path has them."""
    seen = se2.between(POSES[older], POSES[newer])
    moved = seen + np.array((0.6 * off_m, -0.8 * off_m, 0.0))
    return Match(older, newer, moved, np.diag([4e-4, 4e-4, 1e-5]), 0.9)


@pytest.mark.table(
    ("closures", "off_m"),
    [
        ([], 0.0),
        ([closure(0, 40)], 0.0),
        ([closure(0, 40, 2.0)], 2.0),
        ([closure(0, 40), closure(1, 41, 2.0)], 2.0),
        ([closure(1, 41, 2.0), closure(0, 40)], 2.0),  # in any order
        ([closure(0, 40, 2.0), closure(1, 41)], 0.0),
        ([closure(0, 41), closure(1, 41, 2.0)], 2.0),  # one of two passes only fits
    ],
)
def test_the_closures_at_the_newest_node_are_asked(closures, off_m):
    assert contradicted_m(POSES, closures) == pytest.approx(off_m, abs=1e-9)


@pytest.mark.table(("off_m", "later"), [(2.0, False), (0.0, False), (2.0, True)])
def test_the_stages_leave_the_pose_open_so_far(off_m, later):
    stages = Stages(LoopClosureParameters())
    stages.on_the_way(snapshot_along(POSES), DoubtfulNodes())
    found = [closure(0, 42, off_m), closure(3, 43)][: 1 + later]
    for match in found:
        stages._remember([match], DoubtfulNodes())
    first = len(stages._matches.matches) - len(found)
    stages._counted = tuple(range(first, first + len(found)))
    assert stages._open_m(DoubtfulNodes()) == pytest.approx(0.0 if later else off_m, abs=1e-6)
    assert math.isclose(stages._path.poses[-1, 0], POSES[-1, 0])
