"""A step that odometry and the last scan contradict is found out, and taken as these two have it."""

from __future__ import annotations

import math

import numpy as np
import pytest
import rooms
from planar_world import UST, along, drive, rectangle_route, scan_at

from gridslam import GridSlam, se2
from gridslam.files import state_file
from gridslam.filter.motion_model import Motion
from gridslam.filter.scan_matcher import ScanMatcher
from gridslam.filter.step_check import StepCheck

TRUE = np.array((0.8, 0.1, math.radians(23.0)))
WRONG = np.array((0.8, 0.1, math.radians(-25.0)))


def checked(step, odometry, before=(-2.0, -1.5, 0.2)):
    """The link that a check of a step returns; both scans are of the room, a true step apart."""
    rng, check = np.random.default_rng(0), StepCheck()
    check.remember(scan_at(rooms.WALLS, np.array(before), UST, rng))
    motion = Motion(np.zeros(3), 0.0)
    motion.now = np.asarray(odometry)
    return check.wrong(scan_at(rooms.WALLS, se2.compose(before, TRUE), UST, rng), np.asarray(step), motion)


def test_a_step_that_link_and_odometry_contradict_is_wrong():
    link = checked(WRONG, np.add(TRUE, (0.05, -0.03, 0.03)))
    assert link.pose == pytest.approx(TRUE, abs=0.02)


@pytest.mark.table(
    ("step", "odometry"),
    [
        (TRUE, TRUE),
        (TRUE, WRONG),  # as after a wheel has slipped
        (np.add(TRUE, (0.1, 0.05, 0.05)), TRUE),  # less than an error of matching
        (WRONG, np.add(WRONG, (0.0, 0.0, 0.05))),  # two against one
    ],
)
def test_a_step_that_link_or_odometry_supports_is_not(step, odometry):
    assert checked(step, odometry) is None


def test_without_a_scan_before_no_step_is_judged():
    check = StepCheck()
    motion = Motion(np.zeros(3), 0.0)
    assert (
        check.wrong(scan_at(rooms.WALLS, np.zeros(3), UST, np.random.default_rng(0)), WRONG, motion) is None
    )


def test_wrong_matches_turn_neither_path_nor_map(monkeypatch):
    # Given a drive round a room, at two scans of which the matcher turns all particles by 48 degrees.
    # Scans are so far apart that those which contradict the map count, too
    log = drive(rooms.WALLS, along(rectangle_route(2.0, 1.5, 0.5), 0.1), UST, 1)
    slam, match, turned = rooms.begin(log, linearUpdate=0.7), ScanMatcher.match, []

    def wrong(self, maps, *rest):
        matches, node = match(self, maps, *rest), len(slam.trajectory().stamps_s)
        if 10 <= node < 12:
            turned.append(node)
            matches.poses[:, 2] -= math.radians(48.0)
        return matches

    monkeypatch.setattr(ScanMatcher, "match", wrong)
    rooms.run(slam, log)
    # Then the path is right to the end, and each of the two was matched once more
    assert rooms.errors(slam, log).max() < 0.1
    assert turned == [10, 10, 11, 11]


def test_a_saved_state_knows_its_next_step_a_relocated_vehicle_does_not(tmp_path):
    log = rooms.log()
    slam = rooms.begin(log)
    rooms.run(slam, log, last=30)
    state_file.write(slam.state(), tmp_path / "state")
    before, again = (
        slam.state().before,
        state_file.read(tmp_path / "state", GridSlam.from_state).state().before,
    )
    assert again.stamp_s == before.stamp_s == slam.trajectory().stamps_s[-1]
    np.testing.assert_array_equal(again.ranges_m, before.ranges_m)
    slam.relocate(se2.compose(slam.base_in_map, (0.4, 0.0, 0.4)), 1e-6 * np.eye(3), 0.0)
    assert slam.state().before is None
