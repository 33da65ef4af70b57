"""Correlative matching: kernels against their references, known transforms, and places that look alike."""

import math

import numpy as np
import plain_correlation as reference
import pytest
from planar_world import URG, hold, scan_at
from scipy import ndimage

from gridslam import se2
from gridslam.evaluation import Walls
from gridslam.kernels.correlation import FITS, mark_free
from gridslam.loop_closure.local_maps.correlation import Correlation, Window
from gridslam.loop_closure.local_maps.local_map import LocalMapSizes, build_local_map, surface_points
from gridslam.loop_closure.local_maps.refinement import refine

ROOM = Walls.from_polygons(
    [
        np.array([(-4.0, -3.0), (4.0, -3.0), (4.0, 3.5), (1.0, 3.5), (1.0, 2.5), (-4.0, 2.5)]),
        np.array([(-2.0, -1.0), (-1.2, -1.0), (-1.2, -0.4), (-2.0, -0.4)]),
    ]
)


def local_map(walls, poses, seed, resolution_m=0.05):
    """A local map from scans at true poses (k, 3), in the frame of the last."""
    rng = np.random.default_rng(seed)
    poses = np.array(poses, dtype=float)
    scans = [scan_at(walls, pose, URG, rng) for pose in poses]
    surfaces = [surface_points(scan, 15.0) for scan in scans]
    in_anchor = se2.between(poses[-1], poses)
    sizes = LocalMapSizes(resolution_m, 2.0 * resolution_m, 0.1, 15.0)
    return build_local_map(0, surfaces, scans, in_anchor, sizes)


@pytest.mark.table("seed", range(3))
def test_search_finds_what_trying_every_pose_finds(seed):
    # Given two small, coarse maps of one room from places nearby
    rng = np.random.default_rng(seed)
    here = np.array([0.5, 0.0, 0.3])
    there = se2.compose(here, rng.uniform(-0.4, 0.4, 3))
    first, second = local_map(ROOM, [here], seed, 0.2), local_map(ROOM, [there], seed + 10, 0.2)
    window = Window(np.zeros(3), 0.8, 0.3)
    search = Correlation(first, second, window)
    # When searched
    optimum = search.best(0.0, 0.3)
    # Then best and rival are those of exhaustive search
    angles = search.angles_rad
    best, pose = reference.best_score(first, second, window, angles, 0.3)
    assert optimum.score == pytest.approx(best, abs=1e-9)
    assert optimum.query_in_reference == pytest.approx(pose, abs=1e-9)
    rival, _ = reference.best_score(first, second, window, angles, 0.3, pose[:2], 0.5)
    assert search.has_rival(optimum, 0.5, rival - 1e-9, 0.3)
    assert not search.has_rival(optimum, 0.5, rival + 1e-9, 0.3)


def test_only_poses_that_the_prediction_allows_are_searched():
    # Given a prediction that is certain along its own x and uncertain along its y
    first = local_map(ROOM, [(0.5, 0.0, 0.3)], 1, 0.2)
    second = local_map(ROOM, [(0.7, 0.5, 0.5)], 2, 0.2)
    predicted, information = np.array([0.1, -0.1, 0.6]), np.diag([1.0, 6.0, 25.0])
    information[0, 1] = information[1, 0] = -1.0
    search = Correlation(first, second, Window(predicted, 1.6, 0.3, information))

    def is_allowed(pose):
        error = se2.between(predicted, pose)
        return error @ information @ error <= 1.0

    # When searched, then best and rival are those of all poses that it allows
    best, pose = reference.best_score(
        first, second, search_window(predicted), search.angles_rad, 0.3, is_allowed=is_allowed
    )
    optimum = search.best(0.0, 0.3)
    assert optimum.score == pytest.approx(best, abs=1e-9)
    rival, _ = reference.best_score(
        first, second, search_window(predicted), search.angles_rad, 0.3, pose[:2], 0.3, is_allowed
    )
    assert search.has_rival(optimum, 0.3, rival - 1e-9, 0.3)
    assert not search.has_rival(optimum, 0.3, rival + 1e-9, 0.3)
    # and without them there is a better one
    assert reference.best_score(first, second, search_window(predicted), search.angles_rad, 0.3)[0] > rival


def search_window(predicted):
    return Window(predicted, 1.6, 0.3)


def test_nothing_above_the_floor_is_nothing():
    first, second = local_map(ROOM, [(0.5, 0.0, 0.3)], 0, 0.2), local_map(ROOM, [(0.6, 0.0, 0.3)], 1, 0.2)
    window = Window(np.zeros(3), 0.5, 0.1)
    assert Correlation(first, second, window).best(1.0, 0.3) is None


def test_table_is_a_gaussian_of_the_distance_from_the_points():
    made = local_map(ROOM, [(0.5, 0.0, 0.3)], 0)
    occupied = made.table[:, :, FITS] == 255
    distance = ndimage.distance_transform_edt(~occupied) * made.resolution_m
    expected = np.rint(255.0 * np.exp(-0.5 * (distance / 0.1) ** 2))
    assert np.abs(made.table[:, :, FITS] - expected).max() == 0


def test_cells_that_beams_cross_are_free():
    rng = np.random.default_rng(0)
    lidar, ends = np.array([12.3, 9.7]), rng.uniform(-5.0, 30.0, (40, 2))
    hits = rng.random(40) < 0.5
    free = np.zeros((20, 25), dtype=np.bool_)
    mark_free(lidar, ends, hits, free)
    crossed = set().union(*(reference.crossed_cells(lidar, end, hit) for end, hit in zip(ends, hits)))
    expected = {(x, y) for x, y in crossed if 0 <= x < 25 and 0 <= y < 20}
    assert {(int(x), int(y)) for y, x in np.argwhere(free)} == expected


@pytest.mark.table("seed", range(5))
def test_known_transform_is_recovered(seed):
    """Matched and refined, the error was at most 4 mm and 0.9 mrad over 100 seeds."""
    rng = np.random.default_rng(seed)
    here = np.array([0.5, 0.2, rng.uniform(-3.0, 3.0)])
    there = se2.compose(here, np.append(rng.uniform(-0.7, 0.7, 2), rng.uniform(-0.3, 0.3)))
    first, second = local_map(ROOM, [here], seed), local_map(ROOM, [there], seed + 100)
    optimum = Correlation(first, second, Window(np.zeros(3), 1.5, 0.5)).best(0.5, 0.3)
    refined = refine(first.surface, second.surface, optimum.query_in_reference, 0.2)
    error = se2.between(se2.between(here, there), refined.query_in_reference)
    assert math.hypot(error[0], error[1]) < 0.01
    assert abs(error[2]) < 0.003


def along_the_side(x_from, x_to):
    return [(x, -7.0, 0.0) for x in np.arange(x_from, x_to, 0.5)]


@pytest.mark.table(("reach_m", "ambiguous"), [(2.0, False), (4.0, True)])
def test_repeated_beams_are_ambiguous_once_the_window_holds_two(reach_m, ambiguous):
    """The hold's beams stand 3 m apart: what odometry does not exclude is no closure."""
    first, second = local_map(hold(), along_the_side(-4, 4), 0), local_map(hold(), along_the_side(-4, 2), 1)
    wrong_by = np.array([0.3, 0.1, 0.02])
    window = Window(se2.between((3.5, -7.0, 0.0), (1.5, -7.0, 0.0)) + wrong_by, reach_m, 0.1)
    search = Correlation(first, second, window)
    optimum = search.best(0.7, 0.2)
    assert search.has_rival(optimum, 0.6, 0.95 * optimum.score, 0.2) == ambiguous


def test_bare_wall_leaves_the_way_along_it_open():
    bare = hold(beams=False)
    first, second = local_map(bare, along_the_side(-4, 4), 0), local_map(bare, along_the_side(-4, 4), 1)
    refined = refine(first.surface, second.surface, np.array([0.1, 0.02, 0.01]), 0.2)
    assert abs(refined.query_in_reference[1]) < 0.01  # across: found
    assert refined.query_in_reference[0] == pytest.approx(0.1, abs=0.02)  # along: left as it was
    along, across = refined.normal_matrix[0, 0], refined.normal_matrix[1, 1]
    assert along < 0.01 * across
