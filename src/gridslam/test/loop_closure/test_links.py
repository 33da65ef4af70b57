"""Scans are linked by their surfaces, with the uncertainty that their surfaces leave."""

import math

import numpy as np
import pytest
from planar_world import Lidar, scan_at
from rooms import WALLS

from gridslam import se2
from gridslam.evaluation import Walls
from gridslam.kernels.links import Surfaces, align, nearest_by_bearing, nearest_earlier
from gridslam.loop_closure import LoopClosureParameters
from gridslam.loop_closure.edges import Edge
from gridslam.loop_closure.links import scan_links
from gridslam.loop_closure.links.scan_links import ScanLinks
from gridslam.loop_closure.links.scan_pairs import LINK_SIGMA_M, link_pairs
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.maps.scan_surfaces import ScanSurfaces, surfaces_of

LIDAR = Lidar(2.0 * math.pi * 359 / 360, 360, 10.0, 0.01, 10.0)
PARAMETERS = LoopClosureParameters()


def scan_from(walls, pose, seed=0):
    return scan_at(walls, np.array(pose, float), LIDAR, np.random.default_rng(seed))


def path_of(poses, odometry=None):
    """A path along these poses; odometry has them, too, or others."""
    steps = se2.between(poses[:-1], poses[1:])
    way_m = np.concatenate([[0.0], np.cumsum(np.hypot(*steps[:, :2].T))])
    odometry = poses if odometry is None else odometry
    stamps_s, covariances = np.arange(len(poses), dtype=float), np.zeros((len(steps), 3, 3))
    return MeasuredPath(
        stamps_s, poses, steps, covariances, odometry, way_m, np.zeros(len(poses)), np.zeros(len(steps))
    )


def seen_from(walls, pose, seed=0) -> Surfaces:
    return surfaces_of(scan_from(walls, pose, seed), 30.0)


def test_nearest_point_is_that_of_all_points():
    surfaces = seen_from(WALLS, (1.0, -1.5, 0.7))
    rng = np.random.default_rng(1)
    for x, y in rng.uniform(-6.0, 6.0, (400, 2)):
        distance = np.hypot(*(surfaces.points - (x, y)).T)
        for gate in (0.3, 5.0):
            found = nearest_by_bearing(surfaces, x, y, gate)
            if distance.min() >= gate:
                assert found == -1
            else:
                assert distance[found] == pytest.approx(distance.min())


def link(scans, predicted):
    return link_pairs(np.array([(0, 1)]), ScanSurfaces(scans), predicted[None, None], PARAMETERS)[0]


def normal_matrix(reference: Surfaces, query: Surfaces, pose, gate_m: float) -> tuple[np.ndarray, int]:
    """The sum of J^T J over the pairs of points, one by one."""
    total, pairs = np.zeros((3, 3)), 0
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    to_reference = np.array([[cos, -sin], [sin, cos]])
    for point, normal in zip(query.points, query.normals):
        moved = to_reference @ point + pose[:2]
        distance = np.hypot(*(reference.points - moved).T)
        j = int(distance.argmin())
        target = reference.normals[j]
        if distance[j] < gate_m and (to_reference @ normal) @ target > math.cos(math.radians(40.0)):
            here = to_reference.T @ target
            row = np.array([*here, point[0] * here[1] - point[1] * here[0]])
            total, pairs = total + np.outer(row, row), pairs + 1
    return total, pairs


def test_alignment_is_right_and_its_matrix_that_of_the_plain_sum():
    first, second = (1.0, -1.5, 0.2), (1.4, -1.2, 0.6)
    reference, query = seen_from(WALLS, first, 1), seen_from(WALLS, second, 2)
    truth = se2.between(np.array(first), np.array(second))
    pose, matrix = truth + np.array([0.1, -0.08, 0.05]), np.zeros((3, 3))
    pairs, rms_m = align(reference, query, pose, 0.3, 0.0, matrix)
    np.testing.assert_allclose(pose, truth, atol=0.01)
    assert rms_m < 0.03
    plain, count = normal_matrix(reference, query, pose, 0.15)  # the gate ends at half
    assert abs(pairs - count) <= 2
    np.testing.assert_allclose(matrix, plain, rtol=0.05, atol=0.05 * count)


def test_nearest_nodes_of_earlier_passes_are_those_of_a_plain_search():
    rng = np.random.default_rng(3)
    poses, way_m = rng.uniform(-4.0, 4.0, (60, 3)), np.cumsum(rng.uniform(0.2, 1.0, 60))
    found = nearest_earlier(poses, way_m, 20, 3.0, 10.0, 2)
    for newer, nodes in zip(range(20, 60), found):
        distance = np.hypot(*(poses[:, :2] - poses[newer, :2]).T)
        allowed = np.flatnonzero((distance < 3.0) & (way_m < way_m[newer] - 10.0))
        nearest = allowed[np.argsort(distance[allowed])][:2]
        assert nodes.tolist() == [*nearest, *[-1] * (2 - len(nearest))]


def test_scans_with_too_few_pairs_are_given_up_at_once():
    reference, query = seen_from(WALLS, (1.0, -1.5, 0.2)), seen_from(WALLS, (1.4, -1.2, 0.6))
    pose, matrix = np.array([40.0, 0.0, 0.0]), np.zeros((3, 3))
    assert align(reference, query, pose, 0.3, 0.1, matrix) == (0, math.inf)
    assert pose.tolist() == [40.0, 0.0, 0.0]


def test_no_link_spans_a_step_along_a_bare_corridor():
    corridor = Walls.from_polygons([np.array([(-50.0, -1.2), (50.0, -1.2), (50.0, 1.2), (-50.0, 1.2)])])
    for walls, y, is_spanned in ((corridor, 0.1, False), (WALLS, -1.5, True)):
        links, poses = ScanLinks(PARAMETERS), np.array([(1.0, y, 0.0), (1.5, y, 0.0)])
        links.extend([scan_from(walls, pose, 1) for pose in poses], path_of(poses))
        assert links.is_spanned().tolist() == [is_spanned]


def test_along_a_bare_corridor_a_link_measures_nothing():
    corridor = Walls.from_polygons([np.array([(-50.0, -1.2), (50.0, -1.2), (50.0, 1.2), (-50.0, 1.2)])])
    scans = [seen_from(corridor, (0.0, 0.1, 0.0), 1), seen_from(corridor, (1.0, 0.1, 0.0), 2)]
    found = link(scans, np.array([0.8, 0.0, 0.0]))
    assert found.covariance[0, 0] > 50.0  # m2
    # across it, as much as so many independent points of a wall
    across = PARAMETERS.match_sigma_m**2 / PARAMETERS.match_points + LINK_SIGMA_M**2
    assert found.covariance[1, 1] == pytest.approx(across, rel=0.05)
    assert found.covariance[2, 2] < 0.01**2
    assert abs(found.newer_in_older[1]) < 0.02


def test_odometrys_prediction_mends_a_wrong_turn_of_the_filter():
    # given two scans, and a filter that has turned by a radian too much
    poses = np.array([(1.0, -1.5, 0.0), (1.4, -1.3, 0.2)])
    scans = [scan_from(WALLS, pose, seed) for seed, pose in enumerate(poses)]
    turned = poses + np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
    truth = se2.between(poses[0], poses[1])
    for by_filter, by_odometry, is_found in ((turned, turned, False), (turned, poses, True)):
        links = ScanLinks(PARAMETERS)
        links.extend(scans, path_of(by_filter, by_odometry))
        errors = [np.abs(se2.between(truth, edge.newer_in_older)).max() for edge in links.edges]
        assert (bool(errors) and errors[0] < 0.02) == is_found


def test_a_step_is_known_as_well_as_all_links_to_its_newer_node_together():
    poses = np.array([(1.0, -1.5, 0.0), (1.6, -1.5, 0.0), (2.2, -1.5, 0.1)])
    links = ScanLinks(PARAMETERS)
    scans = [scan_from(WALLS, pose, seed) for seed, pose in enumerate(poses)]
    links.extend(scans, path_of(poses))
    of_last = [np.linalg.inv(edge.covariance) for edge in links.edges if edge.newer == 2]
    assert len(of_last) == 2
    np.testing.assert_allclose(links.information()[1], sum(of_last), rtol=1e-6)


def test_what_does_not_overlap_is_not_linked():
    scans = [seen_from(WALLS, (1.0, -1.5, 0.0)), seen_from(WALLS, (-3.0, 1.5, 2.0))]
    assert link(scans, np.array([20.0, 0.0, 0.0])) is None


def test_pairs_after_the_last_one_that_is_wanted_are_left_out():
    poses = [(1.0 + 0.3 * i, -1.5, 0.0) for i in range(4)]
    scans = ScanSurfaces(seen_from(WALLS, pose, seed) for seed, pose in enumerate(poses))
    pairs = np.array([(2, 3), (1, 3), (0, 3)])
    predicted = np.array([[(0.3, 0.0, 0.0)], [(20.0, 0.0, 0.0)], [(0.9, 0.0, 0.0)]])
    for most, expected in ((None, [True, False, True]), (1, [True, False, False])):
        edges = link_pairs(pairs, scans, predicted, PARAMETERS, most=most)
        assert [edge is not None for edge in edges] == expected
    assert (edges[0].older, edges[0].newer) == (2, 3)


def test_passes_of_a_place_are_linked_and_links_survive_a_saved_state():
    # given a way round the room and back to the start, 14 m later
    corners = np.array([(2.0, -1.5), (2.0, 1.0), (-2.0, 1.5), (-2.0, -1.5), (2.0, -1.5)])
    poses = np.concatenate(
        [np.linspace(a, b, 6, endpoint=False) for a, b in zip(corners[:-1], corners[1:])] + [corners[-1:]]
    )
    poses = np.column_stack([poses, np.linspace(0.0, 2.0 * math.pi, len(poses))])
    path = path_of(poses)
    scans = [scan_from(WALLS, pose, seed) for seed, pose in enumerate(poses)]
    links = ScanLinks(PARAMETERS)
    links.extend(scans, path)
    assert links.is_spanned().all()
    assert links.link_passes(poses, path.way_m) > 0
    for edge in links.edges:
        truth = se2.between(poses[edge.older], poses[edge.newer])
        np.testing.assert_allclose(edge.newer_in_older[:2], truth[:2], atol=0.03)
    # then a copy knows the same, and finds nothing new
    copy = ScanLinks(PARAMETERS)
    copy.restore(links.state(), len(scans))
    copy.extend(scans, path)
    assert [(e.older, e.newer) for e in copy.edges] == [(e.older, e.newer) for e in links.edges]
    assert copy.link_passes(poses, path.way_m) == 0


@pytest.mark.table(
    ("off", "sigmas", "odometry_off", "is_kept"),
    [
        ((3.0, 0.0, 0.0), (0.01, 0.01, 0.01), 0.0, False),  # as in the next of rooms that look alike
        ((0.0, -3.0, 0.2), (5.0, 0.02, 0.01), 0.0, False),
        ((3.0, 0.0, 0.0), (5.0, 0.02, 0.01), 0.0, True),  # along a bare corridor
        ((3.0, 0.0, 0.0), (0.01, 0.01, 0.01), 2.9, True),  # odometry says so, too
        ((0.5, 0.5, 0.0), (0.01, 0.01, 0.01), 0.0, True),
    ],
)
def test_a_link_that_both_filter_and_odometry_exclude_is_none(
    monkeypatch, off, sigmas, odometry_off, is_kept
):
    poses = np.array([(1.0, -1.5, 0.0), (1.5, -1.5, 0.0)])
    found = Edge(0, 1, np.array((0.5, 0.0, 0.0)) + off, np.diag(np.square(sigmas)))
    monkeypatch.setattr(scan_links, "link_pairs", lambda *given, **options: [found])
    links = ScanLinks(PARAMETERS)
    odometry = poses + np.array([(0.0, 0.0, 0.0), (odometry_off, 0.0, 0.0)])
    links.extend([scan_from(WALLS, pose) for pose in poses], path_of(poses, odometry))
    assert links.edges == ([found] if is_kept else [])
