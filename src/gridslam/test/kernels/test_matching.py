"""Scores, likelihoods, hill climbing and Gauss-Newton, against the reference on plain tables of cells."""

from __future__ import annotations

import functools
import math

import numpy as np
import plain_filter as reference
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_maps import SIZE, WINDOW, plain_of

from gridslam.kernels import least_squares, matching, nearest
from gridslam.kernels.nearest import NearestPoints, ParticleMap
from gridslam.maps.beams import Beams
from gridslam.maps.tile_map import TileMaps
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan

DELTA = 0.05
HOME = np.array([SIZE / 2, SIZE / 2, 0.3])
"""Where the room below was mapped from, in cells."""
SIGMA = 20.0

pose_near = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-0.1, 0.1)).map(np.array)


def room_scan(count: int = 36) -> PlanarScan:
    """What a lidar sees that stands off centre in a room of 2.4 x 1.8 m with one slanted wall."""
    angles = np.linspace(-math.pi, math.pi, count, endpoint=False)
    walls = [(0.0, 1.3), (math.pi / 2, 0.8), (math.pi, 1.1), (-math.pi / 2, 1.0), (0.8, 1.2)]
    with np.errstate(divide="ignore"):
        distances = np.array([distance / np.cos(angles - normal) for normal, distance in walls])
    ranges = np.where(distances > 0.0, distances, np.inf).min(axis=0)
    return PlanarScan(0.0, angles, ranges, (0.05, 0.02, 0.1), 10.0)


BEAMS = Beams.from_scan(room_scan(), SlamParameters(delta=DELTA)).matching


SEARCH = matching.Search(
    1, SIGMA, SIGMA, SIGMA, missed=-1.0, step=1.0, turn=0.05, halvings=3, looks=8, least_score=0.0
)


class Fixed(reference.PlainMap):
    """A map that does not change, so that what is occupied need not be found out again and again."""

    def __init__(self, plain):
        super().__init__(plain.hits, plain.visits, plain.means)

    occupied = functools.cached_property(lambda self: reference.PlainMap.occupied.fget(self))


@pytest.fixture(scope="module")
def room():
    """The room as mapped from three poses near HOME: tiles, and the same in plain tables."""
    maps = TileMaps(1, DELTA)
    maps.tables = np.zeros((1, WINDOW, WINDOW), np.int32)
    beams = Beams.from_scan(room_scan(240), SlamParameters(delta=DELTA))
    for shift in ((0.0, 0.0, 0.0), (0.4, -0.3, 0.002), (-0.2, 0.1, -0.001)):
        pose = HOME + shift
        lidar, *ends = reference.turned(pose[2], np.vstack((beams.lidar, beams.ends))) + pose[:2]
        maps.insert_at(np.zeros((1, 3)), np.vstack((lidar, ends)), beams.hits)
    return ParticleMap(maps.tables[0], *maps.pool.surfaces), Fixed(plain_of(maps, 0))


ALL, HALF = np.ones(len(BEAMS), bool), np.arange(len(BEAMS)) % 2 == 0
"""Beams that count."""


def points_near(grid, pose, kernel: int = 1) -> tuple[NearestPoints, int]:
    """The map's points nearest to the beams' ends, and how many they are."""
    nearby = NearestPoints(np.empty((len(BEAMS), 2)), np.empty(len(BEAMS), int))
    return nearby, nearest.find_points(*pose, BEAMS, grid, kernel, nearby)


@given(pose_near, st.integers(1, 3))
def test_score_and_likelihood_equal_the_reference(room, shift, kernel):
    grid, plain = room
    pose = HOME + shift
    ours = nearest.score(*pose, BEAMS, 1, grid, kernel, SIGMA, -1.0)
    assert ours == pytest.approx(reference.score(plain, pose, BEAMS, kernel, SIGMA), rel=1e-6)
    again, likelihood = nearest.measure(
        *pose, BEAMS, *points_near(grid, pose, kernel), HALF, SIGMA, 2.0 * SIGMA, -7.0
    )
    assert again == pytest.approx(ours)
    expected = reference.log_likelihood(plain, pose, BEAMS, kernel, 2.0 * SIGMA, -7.0, HALF)
    assert likelihood == pytest.approx(expected, rel=1e-6)


@settings(max_examples=15)
@given(st.floats(-100.0, 200.0), st.floats(-100.0, 200.0), st.floats(-4.0, 4.0))
def test_beams_that_leave_the_map_count_for_nothing(room, x, y, yaw):
    grid, plain = room
    ours = nearest.score(x, y, yaw, BEAMS, 1, grid, 1, SIGMA, -1.0)
    assert ours == pytest.approx(reference.score(plain, (x, y, yaw), BEAMS, 1, SIGMA), rel=1e-6)


def test_a_score_that_cannot_be_beaten_is_not_completed(room):
    grid, _ = room
    whole = nearest.score(*HOME, BEAMS, 1, grid, 1, SIGMA, -1.0)
    assert nearest.score(*HOME, BEAMS, 1, grid, 1, SIGMA, 0.99 * whole) == whole
    assert nearest.score(*HOME, BEAMS, 1, grid, 1, SIGMA, len(BEAMS) - 1e-9) < whole


@settings(max_examples=15)
@given(pose_near)
def test_normal_equations_equal_the_reference(room, shift):
    grid, plain = room
    information, gradient = np.zeros((3, 3)), np.zeros(3)
    pose = HOME + shift
    least_squares.linearise(*pose, BEAMS, *points_near(grid, pose), SIGMA, information, gradient)
    expected, slope = reference.linearise(plain, HOME + shift, BEAMS, 1, SIGMA)
    np.testing.assert_allclose(np.tril(information), np.tril(expected), rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(gradient, slope, rtol=1e-5, atol=1e-5)


def test_the_gradient_is_that_of_the_squared_offsets(room):
    # with the nearest points and weights held, a small step changes the sum of weighted squares by -2 g dx
    _, plain = room
    pose, small = HOME + np.array((0.3, -0.2, 0.004)), 1e-6
    found = [each for each in reference.offsets(plain, pose, BEAMS, 1) if each is not None]
    targets = [reference.turned(pose[2], BEAMS[i, :2]) + pose[:2] - vector for vector, _, i in found]
    weights = [math.exp(-reference.squared(v, n, BEAMS[i, 6]) / SIGMA) for v, n, i in found]

    def cost(at):
        total = 0.0
        for (_, normal, i), target, weight in zip(found, targets, weights):
            vector = reference.turned(at[2], BEAMS[i, :2]) + at[:2] - target
            total += weight * reference.squared(vector, normal, BEAMS[i, 6])
        return total

    _, gradient = reference.linearise(plain, pose, BEAMS, 1, SIGMA)
    slope = [(cost(pose + step) - cost(pose - step)) / (2.0 * small) for step in small * np.eye(3)]
    np.testing.assert_allclose(-2.0 * gradient, slope, rtol=1e-5)


@pytest.mark.table("shift", [(0.4, -0.6, 0.01), (1.0, 0.5, -0.02)])
def test_gauss_newton_equals_the_reference_and_finds_the_pose(room, shift):
    grid, plain = room
    start, prior, factor = HOME + shift, np.diag((0.1, 0.1, 10.0)), np.zeros((3, 3))
    pose = start.copy()
    nearby, _ = points_near(grid, pose)
    found = matching.refine(pose, start, prior, BEAMS, grid, SEARCH, 8, nearby, factor)
    value, _ = nearest.measure(*pose, BEAMS, nearby, found, ALL, SIGMA, SIGMA, -1.0)
    expected = reference.refine(plain, start, start, prior, BEAMS, 1, SIGMA, 8)
    np.testing.assert_allclose(pose, expected, atol=0.06)  # it may stop within this
    assert value == pytest.approx(reference.score(plain, pose, BEAMS, 1, SIGMA), rel=0.01)
    # the map's points are where a wall was hit, from poses that were up to half a cell apart
    np.testing.assert_allclose(pose[:2], HOME[:2], atol=0.35)
    assert pose[2] == pytest.approx(HOME[2], abs=0.02)
    information, _ = reference.linearise(plain, pose, BEAMS, 1, SIGMA)
    np.testing.assert_allclose(
        factor @ factor.T, information + prior, rtol=0.05, atol=0.05 * information[0, 0]
    )


def test_the_prior_holds_what_the_scan_leaves_open():
    # given an empty map, nothing but the prior says where the pose is
    maps = TileMaps(1, DELTA)
    maps.cover((-3.0, -3.0), (3.0, 3.0))
    start = maps.to_cells(np.zeros(3))
    pose, prior = start + np.array((1.0, -2.0, 0.1)), np.diag((4.0, 4.0, 100.0))
    grid = ParticleMap(maps.tables[0], *maps.pool.surfaces)
    nearby, _ = points_near(grid, pose)
    assert matching.refine(pose, start, prior, BEAMS, grid, SEARCH, 8, nearby, np.zeros((3, 3))) == 0
    np.testing.assert_allclose(pose, start, atol=1e-9)


@pytest.mark.table("shift", [(2.0, -1.5, 0.08), (-1.0, 2.0, -0.05)])
def test_climbing_equals_the_reference_and_improves(room, shift):
    grid, plain = room
    start = HOME + shift
    *pose, value = matching.climb(start, BEAMS, 1, grid, SEARCH, 3)
    expected, best = reference.climb(plain, start, BEAMS, 1, SIGMA, 1.0, 0.05, 3)
    np.testing.assert_allclose(pose, expected, atol=1e-9)
    assert value == pytest.approx(best, rel=1e-6)
    assert value > 1.2 * reference.score(plain, start, BEAMS, 1, SIGMA)


def test_a_wall_is_not_matched_from_behind():
    # given a map of one wall, seen from the left
    maps = TileMaps(1, DELTA)
    maps.tables = np.zeros((1, WINDOW, WINDOW), np.int32)
    for thickness in (0.0, 1.0):  # two cells thick
        ends = np.array([(60.5 + thickness, 20.5 + row) for row in range(50)])
        for end in ends:
            lidar = np.array([10.5, end[1]])
            maps.insert_at(np.zeros((1, 3)), np.vstack((lidar, end)), np.ones(1, bool))
    beam = np.array([[20.0, 0.0, math.sqrt(2.0), 0.0, 1.0, 0.0, 0.1]])
    grid = ParticleMap(maps.tables[0], *maps.pool.surfaces)
    # then a beam from the left finds it, and one from the right, that ends on its left face, does not
    assert nearest.score(40.5, 40.5, 0.0, beam, 1, grid, 1, SIGMA, -1.0) == pytest.approx(1.0)
    assert nearest.score(80.5, 40.5, math.pi, beam, 1, grid, 0, SIGMA, -1.0) == 0.0


def test_scattered_poses_have_the_covariance_of_the_information():
    rng = np.random.default_rng(0)
    information = np.array([[4.0, 1.0, 3.0], [1.0, 9.0, -2.0], [3.0, -2.0, 25.0]])
    count = 20_000
    poses = np.zeros((count, 3))
    factors = np.tile(np.linalg.cholesky(information), (count, 1, 1))
    least_squares.scatter(factors, rng.standard_normal((count, 3)), poses)
    # sampling error of a covariance from n samples is about sqrt(2 / n), 1 %; five times that is allowed
    covariance = np.linalg.inv(information)
    scale = np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
    np.testing.assert_allclose(np.cov(poses.T) / scale, covariance / scale, atol=0.05)


@given(st.integers(0, 1000))
def test_the_inverse_of_a_covariance_is_numpys(seed):
    deviations = np.diag(10.0 ** np.random.default_rng(seed).uniform(-3.0, 1.0, 3))
    covariance = deviations @ np.array([[1.0, 0.5, -0.2], [0.5, 1.0, 0.3], [-0.2, 0.3, 1.0]]) @ deviations
    expected = np.linalg.inv(covariance)
    np.testing.assert_allclose(least_squares.inverse(np.tril(covariance)), expected, rtol=1e-9)


def test_what_beams_tell_along_a_bare_corridor_is_ignored():
    # given walls at 0.7 rad, of which 3 in 1000 normals point along them, or 3 in 100, as with doors
    axes = np.array([(math.cos(0.7), -math.sin(0.7)), (math.sin(0.7), math.cos(0.7))])
    for share, kept in ((0.003, 0.0), (0.03, 1.0)):
        whole = np.zeros((3, 3))
        whole[:2, :2] = axes @ np.diag((200.0, 200.0 * share)) @ axes.T
        whole[2, :2] = whole[:2, 2] = (30.0, -12.0)
        whole[2, 2] = 900.0
        # when what they tell along it is left out, then across and the turn stay as they are
        project = np.eye(3)
        project[:2, :2] = axes @ np.diag((1.0, kept)) @ axes.T
        information, gradient = np.tril(whole), np.array((3.0, -1.0, 5.0))
        expected = project @ gradient
        least_squares.ignore_unobserved(information, gradient)
        np.testing.assert_allclose(information, np.tril(project @ whole @ project), atol=1e-9)
        np.testing.assert_allclose(gradient, expected, atol=1e-9)
