"""Scans are missing while the vehicle drives on into unseen space: odometry bridges the gap."""

import dataclasses

import numpy as np
import pytest
from planar_world import URG, along, drive, rectangle_route, scattered_boxes
from sessions_in_the_hold import base_in_map, error_m

from gridslam import SlamParameters
from gridslam.saved_sessions import load_session, save_session
from gridslam.session import SlamSession

TRUTH = along(rectangle_route(12.0, 7.0, laps=1.4), 0.5)
FIRST, LAST = 40, 54
"""The scans between these two are missing: 7 m of way in 7 s, with a lidar that sees 5.6 m."""


@pytest.fixture(scope="module")
def log():
    """A drive round a hall, at 1 m/s."""
    return drive(scattered_boxes(1, TRUTH), TRUTH, dataclasses.replace(URG, beams=121), seed=1)


def test_odometry_bridges_it(log, tmp_path):
    # when scans come again only where nothing has been seen yet
    session = SlamSession(SlamParameters(particles=10, threads=1), starting_pose=tuple(TRUTH[0]))
    states, kept = [], [*range(FIRST), *range(LAST, len(TRUTH))]
    for index in kept:
        session.process(log.scans[index], log.odometry[index])
        states.append(session.tracking.state)
        if index == LAST + 10:
            save_session(session, tmp_path / "state")
            assert session.loose_parts_s == [log.scans[LAST].stamp_s]  # it is known on the way
    session.finish()
    # then the pose is uncertain at first, never lost, and one map goes on, in which the loop is closed
    assert states[FIRST] == "uncertain"
    assert "lost" not in states
    assert states[-1] == "tracking"
    assert session.slam.earlier is None
    assert session.closures
    path = session.trajectory()
    truth = TRUTH[np.searchsorted(log.truth.stamps_s, path.stamps_s)]
    assert np.hypot(*(path.poses_in_map - truth)[:, :2].T).max() < 0.4
    assert error_m(base_in_map(session, log.odometry[-1]), TRUTH[-1]) < 0.2
    # and the loop joins both parts of the map, which only odometry did before
    assert session.loose_parts_s == []
    begun = load_session(tmp_path / "state")
    assert begun.loose_parts_s == [log.scans[LAST].stamp_s]
    begun.finish()
    assert begun.loose_parts_s == [log.scans[LAST].stamp_s]
