"""A step of the filter that its own link and odometry contradict: loop closure mends it."""

import math

import numpy as np
import pytest
from planar_world import Lidar, along, drive, rectangle_route, scattered_boxes
from room_paths import snapshot_of

from gridslam import se2
from gridslam.loop_closure import LoopClosureParameters
from gridslam.loop_closure.path.step_uncertainty import DoubtfulNodes
from gridslam.loop_closure.stages import Stages
from gridslam.tracking.wrong_steps import are_wrong

FIRST, EVERY = 120, 4
"""Before this node no place was seen twice; from it on, places are searched for every so many nodes."""


@pytest.mark.table("turned_deg", [-48.0, 30.0])
def test_a_wrong_turn_of_the_filter_is_mended_once_a_loop_closes(turned_deg):
    # given a round trip, on which the filter turns wrongly at a single node; odometry and scans say otherwise
    truth, node = along(rectangle_route(12.0, 7.0, 0.5, laps=1.4), 0.5), 60
    log = drive(scattered_boxes(1, truth), truth, Lidar(math.radians(270.0), 136, 8.0, 0.01, 10.0), seed=1)
    after = se2.compose(
        np.array((0.0, 0.0, math.radians(turned_deg))), se2.between(truth[node], truth[node:])
    )
    poses = np.vstack([truth[:node], se2.compose(truth[node], after)])
    assert np.hypot(*(poses - truth)[:, :2].T).max() > 10.0
    # when places are searched for on the way, and at the end
    stages = Stages(LoopClosureParameters())
    for count in range(FIRST, len(truth), EVERY):
        correction = stages.on_the_way(snapshot_of(log, poses[:count]), DoubtfulNodes())
        if correction is not None:
            rest = se2.between(poses[count - 1], poses[count:])
            poses = np.vstack([correction.poses, se2.compose(correction.poses[-1], rest)])
    correction = stages.at_the_end(snapshot_of(log, poses), DoubtfulNodes(), is_searched=False)
    # then the loop is closed, and the path is that of odometry and scans
    assert correction is not None
    assert np.hypot(*(correction.poses - truth)[:, :2].T).max() < 0.1


def test_one_step_of_many_is_wrong():
    # given steps that turn by 23 degrees by odometry and by links that err by 0.01 m and 0.35 degrees
    odometry = np.tile((0.8, 0.1, math.radians(23.0)), (5, 1))
    covariances = np.tile(np.diag((0.01, 0.01, math.radians(0.35))) ** 2, (5, 1, 1))
    steps, links = odometry.copy(), odometry.copy()
    # when the filter turns by -25 degrees, a link does, both do, and the filter errs by little
    steps[0, 2] = links[1, 2] = steps[2, 2] = links[2, 2] = math.radians(-25.0)
    steps[3] += (0.2, 0.2, 0.09)
    # then the filter's is wrong where it stands alone
    assert are_wrong(steps, odometry, links, covariances).tolist() == [True, False, False, False, False]
