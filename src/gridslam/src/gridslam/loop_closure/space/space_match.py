"""Stage 3 with clouds: a candidate at which the planes that both stretches of path saw agree.

A level scan at another height is another slice of the world. Its walls are the same, so clouds find a place
again from any height. They also measure the climb, where floor, deck or stringers were seen both times.
"""

from __future__ import annotations

import math
from typing import Iterator, NamedTuple

import numpy as np

from gridslam import se2
from gridslam.cloud_odometry.matching import LEAST_INFORMATION, CloudMatch, PoseInSpace, match
from gridslam.cloud_odometry.plane_map import PlaneMap
from gridslam.loop_closure.candidates import Candidate
from gridslam.loop_closure.edges import Match
from gridslam.loop_closure.matches import agrees_with_path
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.space.path_clouds import MATCHING, PathClouds, Query, about_z

START_SIGMAS = np.array([0.3, 0.3, 0.5, 0.01, 0.01, 0.03])
"""Standard deviations of the pose that a match begins with: x, y, z in m, roll, pitch, yaw in rad."""
PLANE = np.ix_((0, 1, 5), (0, 1, 5))
RISE_M, REACH_M = 0.3, 0.6
"""m: distance of the heights from which a match begins, and how far they reach at least above and below."""
HEIGHT_RIVAL_SHARE = 0.4
"""Two heights fit if level planes tell the second one more than this share of what they tell the first."""
CLIMB_SIGMA_MAX_M = 0.1
"""m: a climb that is told worse is not measured: few points lie on level planes."""
LEAN_SIGMA_RAD = 0.005
"""Of the IMU's roll and pitch, which level the clouds: x and y err by it times the climb, and the climb by it
times the way beside.
"""
HEIGHT_SIGMAS = 3.0
"""The climb by odometry may be off by so many standard deviations."""


class Placed(NamedTuple):
    """A query on the planes of an earlier stretch."""

    match: CloudMatch

    @property
    def score(self) -> float:
        """Share of the points that lie on a plane."""
        return self.match.near / max(self.match.points, 1)

    @property
    def level_support(self) -> float:
        """What the points on level planes tell of the height, 1/m2. Walls fit at any height."""
        return float(self.match.information[2, 2])

    @property
    def level_planes_beside_m(self) -> float:
        """How far beside the base the middle of the points on level planes is, m."""
        return float(np.hypot(*self.match.information[2, 3:5])) / max(self.level_support, 1e-9)

    @property
    def pose(self) -> np.ndarray:
        """(3,) x, y and yaw."""
        x, y, _ = self.match.pose.place.tolist()
        rotation = self.match.pose.rotation
        return np.array((x, y, math.atan2(rotation[1, 0], rotation[0, 0])))


def match_in_space(
    candidate: Candidate,
    planar: Match | None,
    path: MeasuredPath,
    clouds: PathClouds,
    sigmas_m: np.ndarray,
    parameters: LoopClosureParameters,
) -> Match | None:
    """Place the clouds around the newer node on the planes around the older one.

    Return None unless the match passes every test. They are those of `matches`.

    Args:
        candidate: both nodes have clouds.
        planar: the match of level scans, which passed them, too; None: there is none.
        path: the nodes are of this path.
        clouds: of the path.
        sigmas_m: (k,) standard deviations of the newer node's height by the path, relative to every other.
        parameters: the limits of the tests.
    """
    p, older, newer = parameters, candidate.older, candidate.newer
    planes, query = clouds.around(path, older), clouds.query(path, newer)
    climb_m = float(path.heights_m[newer] - path.heights_m[older])
    starts = _window(candidate, p) if planar is None else [planar.newer_in_older]
    found = [_place(planes, query, start, climb_m) for start in starts]
    best = max(found, key=lambda each: each.score)
    if best.match.agreement < p.score_min or best.match.known < p.overlap_min:  # test 1: they agree
        return None
    covariance = _covariance(best, p)
    if covariance is None:  # test 2: the planes hold the pose in every direction
        return None
    if not agrees_with_path(best.pose, covariance, candidate, path, p):  # test 3
        return None
    if any(_is_rival(each, best, p) for each in found):  # test 4
        return None
    climb = _climb(planes, query, best, climb_m, float(sigmas_m[older]), p)
    return Match(older, newer, best.pose, covariance, best.match.agreement, *climb)


def _window(candidate: Candidate, parameters: LoopClosureParameters) -> Iterator[np.ndarray]:
    """Yield poses (3,) in the candidate's window, as far apart as rivals are, its middle first."""
    window, apart_m = candidate.window, parameters.rival_distance_m
    count = math.floor(window.reach_m / apart_m)
    yield window.predicted
    for i in range(-count, count + 1):
        for j in range(-count, count + 1):
            error = np.array((apart_m * i, apart_m * j, 0.0))
            if (i or j) and error @ window.information @ error <= 1.0:
                yield se2.compose(window.predicted, error)


def _place(planes: PlaneMap, query: Query, start: np.ndarray, climb_m: float) -> Placed:
    x, y, yaw = start.tolist()
    pose = PoseInSpace(np.array((x, y, climb_m)), about_z(yaw))
    prior = np.diag(START_SIGMAS**-2)
    weight = 1.0 / (MATCHING.points_per_reading * MATCHING.point_noise_m**2)
    weights = np.full(len(query.points_m), weight)
    return Placed(match(planes, query.points_m, weights, query.lidar_m, pose, prior, MATCHING))


def _covariance(placed: Placed, parameters: LoopClosureParameters) -> np.ndarray | None:
    """Return the covariance (3, 3) of x, y and yaw in the query's frame; None: a direction stays open."""
    p = parameters
    covariance = np.linalg.inv(placed.match.information + LEAST_INFORMATION * np.eye(6))[PLANE]
    if math.sqrt(float(np.linalg.eigvalsh(covariance[:2, :2])[-1])) > p.weakest_sigma_max_m:
        return None
    turn, by_lean_m = about_z(placed.pose[2]), LEAN_SIGMA_RAD * float(placed.match.pose.place[2])
    least_m2 = p.closure_sigma_m**2 + by_lean_m**2
    return turn.T @ covariance @ turn + np.diag([least_m2, least_m2, p.closure_sigma_rad**2])


def _is_rival(placed: Placed, best: Placed, parameters: LoopClosureParameters) -> bool:
    p = parameters
    apart_m = math.dist(placed.pose[:2], best.pose[:2])
    return apart_m >= p.rival_distance_m and placed.score > p.rival_share_max * best.score


def _climb(
    planes: PlaneMap, query: Query, best: Placed, by_path_m: float, sigma_m: float, p: LoopClosureParameters
) -> tuple[float, float]:
    """Return the climb and its standard deviation, m; NaN: nothing level tells it, or two heights fit."""
    steps = math.ceil(max(HEIGHT_SIGMAS * sigma_m, REACH_M) / RISE_M)
    rises_m = [RISE_M * step for step in range(-steps, steps + 1) if step]
    found = [best, *(_place(planes, query, best.pose, by_path_m + rise_m) for rise_m in rises_m)]
    best = max(found, key=lambda each: each.level_support)
    climb_m, variance_m2 = best.match.height_alone()
    beside_m = math.hypot(best.level_planes_beside_m, *best.pose[:2])
    climb_sigma = math.sqrt(variance_m2 + p.closure_sigma_m**2 + (LEAN_SIGMA_RAD * beside_m) ** 2)
    is_far = abs(climb_m - by_path_m) > HEIGHT_SIGMAS * math.hypot(sigma_m, climb_sigma)
    if is_far or climb_sigma > CLIMB_SIGMA_MAX_M or any(_is_other_height(each, best) for each in found):
        return math.nan, math.nan
    return climb_m, climb_sigma


def _is_other_height(placed: Placed, best: Placed) -> bool:
    apart_m = abs(float(placed.match.pose.place[2] - best.match.pose.place[2]))
    return apart_m > RISE_M / 2 and placed.level_support > HEIGHT_RIVAL_SHARE * best.level_support
