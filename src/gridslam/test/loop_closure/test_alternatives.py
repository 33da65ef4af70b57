"""Steps that no link spans: scans around them, or closures, tell whether the filter's or odometry's holds."""

import dataclasses
import math

import numpy as np
import pytest
from planar_world import Lidar, along, drive, rectangle_route, scattered_boxes
from room_paths import path_along, snapshot_of

from gridslam import se2
from gridslam.loop_closure import LoopClosureParameters
from gridslam.loop_closure.correction import AT_THE_END, corrected_poses
from gridslam.loop_closure.edges import Edges, Match
from gridslam.loop_closure.path.alternatives import Alternatives
from gridslam.loop_closure.path.step_uncertainty import UNDECIDED, DoubtfulNodes, step_uncertainty
from gridslam.loop_closure.stages import Stages

P = LoopClosureParameters()


def turned_at(poses, node, by_deg):
    """Poses of which the step to a node, and so all that follows, turns by more than it did."""
    turn = np.array((0.0, 0.0, math.radians(by_deg)))
    after = se2.compose(turn, se2.between(poses[node], poses[node:]))
    return np.vstack([poses[:node], se2.compose(poses[node], after)])


class FirmSteps:
    """Links that measure all steps but some to 0.01 m and 0.2 degrees."""

    def __init__(self, steps, but):
        self.is_spanned = ~np.isin(np.arange(steps), but)

    def information(self):
        return self.is_spanned[:, None, None] * np.diag((1e4, 1e4, 1e5))

    def stacked(self):
        return Edges.of([])

    def link_passes(self, poses, way_m):
        return 0


@pytest.mark.table("wrong", ["filter", "odometry"])
def test_closures_tell_which_of_two_steps_holds(wrong):
    # given a square of 10 m, once round and a side more. Of one step either turns wrongly by 19 degrees
    truth = along(10.0 * np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0), (1, 0)], float), 1.0, 2.0)
    off = turned_at(truth, 23, -19.0)
    path = path_along(*((off, truth) if wrong == "filter" else (truth, off)))
    # when two places are found again, and scans have told nothing of the step
    closures = [
        Match(older, newer, se2.between(truth[older], truth[newer]), np.diag((4e-4, 4e-4, 1e-5)), 1.0)
        for older, newer in ((2, 46), (5, 49))
    ]
    links = FirmSteps(len(path.steps), 22)
    uncertainty = step_uncertainty(path, links.is_spanned, DoubtfulNodes(), P)
    found = Alternatives(np.array([22]), np.array([UNDECIDED]))
    poses = corrected_poses(path, uncertainty, found, links, closures, AT_THE_END, P)
    # then the right one of both is chosen
    turned = se2.between(poses[22], poses[23])[2] - se2.between(truth[22], truth[23])[2]
    assert math.degrees(abs(turned)) < 0.5
    assert np.hypot(*(poses - truth)[:, :2].T).max() < 0.1


@pytest.mark.table("by_deg", [-19.0, 12.0])
def test_a_slip_that_no_scan_spans_bends_no_other_corner(by_deg):
    # given a rectangle, once round and a side more, of which no link measures the corners. At the second one
    # wheels slip, and the filter follows odometry
    truth = along(np.array([(0, 0), (24, 0), (24, 14), (0, 14), (0, 0), (24, 0)], float), 1.0, 2.0)
    corners = np.flatnonzero(np.abs(se2.between(truth[:-1], truth[1:])[:, 2]) > 1.0)
    off = turned_at(truth, int(corners[1]) + 1, by_deg)
    path, links = path_along(off, off), FirmSteps(len(truth) - 1, corners)
    # when two places are found again
    closures = [
        Match(older, newer, se2.between(truth[older], truth[newer]), np.diag((4e-4, 4e-4, 1e-5)), 1.0)
        for older, newer in ((3, int(corners[3]) + 4), (20, int(corners[3]) + 21))
    ]
    uncertainty = step_uncertainty(path, links.is_spanned, DoubtfulNodes(), P)
    found = Alternatives(np.array([], int), np.array([], int))
    poses = corrected_poses(path, uncertainty, found, links, closures, AT_THE_END, P)
    # then the corner with the slip is mended, and no parallelogram is made of the rectangle
    assert np.hypot(*(poses - truth)[:, :2].T).max() < 0.3


TRUTH = along(rectangle_route(12.0, 7.0, 0.5, laps=1.4), 0.5, turn_rad=2.0)
CORNER = 102
"""From a node to this one the vehicle turns by 90 degrees."""


@pytest.mark.table(("who", "by_deg"), [("odometry", -12.0), ("filter", -19.0)])
def test_scans_before_and_after_a_step_that_no_link_spans_tell_how_it_was(who, by_deg):
    # given a lidar that sees 100 degrees, and a corner at which wheels slip, or the filter matches wrongly
    lidar = Lidar(math.radians(100.0), 91, 8.0, 0.01, 10.0)
    log, poses = drive(scattered_boxes(1, TRUTH), TRUTH, lidar, seed=1), TRUTH
    if who == "filter":
        poses = turned_at(TRUTH, CORNER, by_deg)
    else:
        log = dataclasses.replace(log, odometry=turned_at(log.odometry, CORNER, by_deg))
    # when it is mapped once round and further
    stages, open_m, spread_m = Stages(P), [], []
    for count in range(120, len(TRUTH), 8):
        correction = stages.on_the_way(snapshot_of(log, poses[:count]), DoubtfulNodes())
        open_m.append(stages.open_m)
        spread_m.append(stages.spread.since_recognised_m)
        if correction is not None:
            rest = se2.between(poses[count - 1], poses[count:])
            poses = np.vstack([correction.poses, se2.compose(correction.poses[-1], rest)])
    correction = stages.at_the_end(snapshot_of(log, poses), DoubtfulNodes(), is_searched=False)
    # then it is known before any loop is closed how far the pose is off, nearly: odometry errs by 3 degrees
    way_m = math.dist(TRUTH[119, :2], TRUTH[CORNER, :2])
    off_m = 2.0 * way_m * math.sin(math.radians(19.0) / 2.0) if who == "filter" else 0.0
    assert open_m[0] == pytest.approx(off_m, rel=0.3, abs=0.1)
    # and nobody would take the pose for certain until the loop is closed
    assert min(spread_m[:2]) > 0.5
    assert min(spread_m) < 0.1
    # and no link spans the corner, and the step is the true one, not the mean of both
    assert not stages._links.is_spanned()[CORNER - 1]
    assert correction is not None
    step, true = (se2.between(each[CORNER - 1], each[CORNER]) for each in (correction.poses, TRUTH))
    assert math.degrees(abs(se2.wrap(step[2] - true[2]))) < 1.0
    assert np.hypot(*(correction.poses - TRUTH)[:, :2].T).max() < 0.3
