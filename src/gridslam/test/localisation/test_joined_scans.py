"""Scans are joined by what they see, and by odometry where they see too little."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from planar_world import UST, Drift, along, drive, rectangle_route
from rooms import WALLS

from gridslam import se2
from gridslam.evaluation import Walls
from gridslam.localisation.joined_scans import JoinedScans

LIDAR = dataclasses.replace(UST, beams=181)
POOR = Drift(scale=0.03, heading_rad_per_sqrt_m=0.08, heading_rad_per_sqrt_rad=0.08)
CORRIDOR = Walls(np.array([(-50.0, 1.2, 50.0, 1.2), (-50.0, -1.2, 50.0, -1.2)]))
NOTHING = Walls(np.array([(90.0, 90.0, 91.0, 90.0)]))


def joined(walls, route, seed=3):
    """Errors (k, 3) of the joined scans' poses, and of odometry's, both from the newest scan's true pose."""
    log = drive(walls, along(np.asarray(route, float), 0.5), LIDAR, seed, POOR)
    scans = JoinedScans(16)
    for scan, base in zip(log.scans, log.odometry):
        scans.add(scan, base)
    truth = log.truth.poses_in_map[-len(scans.scans) :]
    true = se2.between(truth[-1], truth)
    found = [
        se2.between(poses[-1], poses) - true
        for poses in (np.array([getattr(s, of) for s in scans.scans]) for of in ("base", "base_in_odom"))
    ]
    for errors in found:
        errors[:, 2] = se2.wrap(errors[:, 2])
    return found


@pytest.mark.table("seed", range(3))
def test_in_a_room_the_scans_fit_each_other_whatever_odometry_says(seed):
    by_scans, by_odometry = joined(WALLS, rectangle_route(2.0, 1.5, 0.5)[:4], seed)
    assert len(by_scans) == 16
    assert np.hypot(*by_odometry[:, :2].T).max() > 0.15  # or the test would say nothing
    assert np.hypot(*by_scans[:, :2].T).max() < 0.1
    assert abs(by_scans[:, 2]).max() < 0.03


def test_along_a_bare_corridor_odometry_tells_the_way_and_the_walls_the_heading():
    by_scans, by_odometry = joined(CORRIDOR, [(-4.0, 0.0), (3.0, 0.0)])
    assert abs(by_scans[:, 2]).max() < 0.02 < abs(by_odometry[:, 2]).max()
    assert abs(by_scans[:, 1]).max() < 0.05
    way_m, scaled_m = 7.0, 7.0 * POOR.scale
    assert by_scans[0, 0] == pytest.approx(by_odometry[0, 0], abs=0.5 * scaled_m + 0.02 * way_m)


def test_where_nothing_is_seen_odometry_counts():
    by_scans, by_odometry = joined(NOTHING, [(0.0, 0.0), (3.0, 0.0)])
    np.testing.assert_allclose(by_scans, by_odometry, atol=1e-9)
