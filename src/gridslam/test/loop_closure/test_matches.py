"""The criterion of a closure: each test of a match refuses what it is for."""

import dataclasses
import math

import numpy as np
import pytest
from planar_world import Lidar, scan_at

from gridslam import se2
from gridslam.evaluation import Walls
from gridslam.loop_closure import LoopClosureParameters
from gridslam.loop_closure.candidates import Candidate
from gridslam.loop_closure.local_maps.correlation import Window
from gridslam.loop_closure.local_maps.stretches import LocalMaps
from gridslam.loop_closure.matches import match
from gridslam.loop_closure.path.measured_path import MeasuredPath

P = LoopClosureParameters(stretch_m=0.5, separation_m=2.0, search_agreed_m=2.0)
LIDAR = Lidar(2.0 * math.pi * 359 / 360, 360, 10.0, 0.01, 10.0)
BOX = np.array([(1.0, 0.5), (1.6, 0.5), (1.6, 1.2), (1.0, 1.2)])


def polygon(*corners):
    return np.array(corners, float)


ROOM = Walls.from_polygons([polygon((-3, -2), (3, -2), (3, 2), (-3, 2)), BOX])
CORRIDOR = Walls.from_polygons([polygon((-50, -1.2), (50, -1.2), (50, 1.2), (-50, 1.2))])
ROW = Walls.from_polygons(
    [polygon((-9, -2), (9, -2), (9, 2), (-9, 2))]
    + [
        polygon((x, y), (x + 0.4, y), (x + 0.4, y + 0.4), (x, y + 0.4))
        for x in range(-8, 8)
        for y in (-1.6, 1.2)
    ]
)
"""A hall with equal pillars, a metre apart, whose ends are out of sight."""


def tried(walls, off=(0.0, 0.0, 0.0), reach_m=1.0, uncertainty=0.5, lidar=LIDAR, **changes):
    """Match two scans of a place, the second after a long way. By the path its pose is off by so much."""
    parameters = LoopClosureParameters(**{**vars(P), **changes})
    truth = np.array([(0.1, -0.2, 0.3), (0.5, 0.1, -0.2)])
    poses = np.array([truth[0], se2.compose(truth[1], off)])
    scans = [scan_at(walls, pose, lidar, np.random.default_rng(seed)) for seed, pose in enumerate(truth)]
    steps = se2.between(poses[:-1], poses[1:])
    path = MeasuredPath(
        np.array([0.0, 100.0]),
        poses,
        steps,
        np.zeros((1, 3, 3)),
        poses,
        np.array([0.0, 40.0]),
        np.zeros(2),
        np.zeros(1),
    )
    maps = LocalMaps(parameters)
    maps.extend(scans)
    window = Window(se2.between(poses[0], poses[1]), reach_m, 0.1)
    candidate = Candidate(0, 1, window, uncertainty**2 * np.eye(3))
    found = match(candidate, path, maps.around(path, 1), maps, parameters)
    return found, se2.between(truth[0], truth[1])


def test_a_place_seen_again_matches_at_its_true_pose():
    found, truth = tried(ROOM, off=(0.3, -0.2, 0.04))
    assert (found.older, found.newer) == (0, 1)
    assert found.score > P.score_min
    np.testing.assert_allclose(found.newer_in_older, truth, atol=0.02)


@pytest.mark.table(
    ("test", "given"),
    [
        ("the maps agree", {"score_min": 0.9999}),
        ("their surfaces hold the pose", {"walls": CORRIDOR, "reach_m": 0.25}),
        ("the path allows it", {"off": (0.8, 0.0, 0.0), "uncertainty": 0.1}),
        (
            "no other pose fits",
            {"walls": ROW, "lidar": dataclasses.replace(LIDAR, range_m=4.0), "reach_m": 2.5},
        ),
    ],
)
def test_each_test_refuses_what_it_is_for(test, given):
    given = {"walls": ROOM, **given}
    assert tried(**given)[0] is None, test
