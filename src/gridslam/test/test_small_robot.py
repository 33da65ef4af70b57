"""A small robot in rooms of a few metres, with fast turns and gaps: SLAM knows where it is."""

import dataclasses

import numpy as np
from planar_world import URG
from sessions_in_the_hold import base_in_map, error_m
from small_robot import small_robot

from gridslam import SlamParameters
from gridslam.session import SlamSession


def test_scans_that_turns_have_skewed_are_straightened_by_odometry():
    # given a driver that tells time_increment, and wheels that err by 2 m at the end
    log, _ = small_robot(2, dataclasses.replace(URG, beams=121))
    truth = log.truth.poses_in_map
    assert np.hypot(*(log.odometry - truth)[-1, :2]) > 1.5
    start = tuple(truth[0].tolist())
    session = SlamSession(SlamParameters(particles=10, threads=1), starting_pose=start)
    # when it drives there and back, with the default parameters but fewer particles
    states, errors_m = [], []
    for scan, base, true in zip(log.scans, log.odometry, truth):
        session.process(scan, base)
        states.append(session.tracking.state)
        errors_m.append(error_m(base_in_map(session, base), true))
    # then it is never lost, and right to 0.3 m all the time
    assert "lost" not in states
    assert max(errors_m) < 0.3
