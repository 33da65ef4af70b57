"""The path's steps: measured by scans, by odometry, or contradicted."""

import numpy as np
import pytest
from room_paths import path_along, snapshot_along

from gridslam import se2
from gridslam.loop_closure import LoopClosureParameters
from gridslam.loop_closure.local_maps.stretches import LocalMaps
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.path.odometry_scale import Scale
from gridslam.loop_closure.path.step_uncertainty import (
    SHARE_MIN,
    UNDECIDED,
    DoubtfulNodes,
    step_edges,
    step_uncertainty,
)
from gridslam.tracking.evidence import Agreement


def test_steps_are_as_firm_as_their_links_and_without_one_like_odometry():
    # given a way of 12 m in steps of half a metre, as odometry has it, too
    x = np.arange(0.0, 12.1, 0.5)
    path, p = path_along(np.column_stack([x, np.zeros((len(x), 2))])), LoopClosureParameters()
    count = len(x) - 1
    uncertainty = step_uncertainty(path, np.ones(count, bool), DoubtfulNodes(), p)
    # when links measure all steps but one, which is open along x
    by_links = np.tile(np.diag([1e4, 2500.0, 4e4]), (count, 1, 1))
    by_links[3], by_links[4] = 0.0, np.diag([0.0, 2500.0, 4e4])
    edges = step_edges(path, uncertainty, by_links, path.poses, p).covariance
    # then a step has the information of both. One without links is as good as odometry, which has not erred
    odometry = np.array((0.1**2 * 0.5 + 0.002**2, 0.1**2 * 0.5 + 0.002**2, 0.1**2 * 0.5 + 0.0005**2))
    expected = np.diag(1.0 / (np.diag(by_links[0]) + 1.0 / odometry))
    np.testing.assert_allclose(edges[0], expected, atol=1e-12)
    np.testing.assert_allclose(edges[3], SHARE_MIN * np.diag(odometry), atol=1e-12)
    assert edges[4][0, 0] == pytest.approx(odometry[0])
    assert edges[4][1, 1] < 0.02**2


@pytest.mark.table(("share", "expected"), [(0.5, 0.25), (3.0, 1.0)])
def test_the_path_tells_how_good_odometry_is(share, expected):
    # given odometry whose deviations are a share of the assumed ones, with a few great errors
    rng, p, count = np.random.default_rng(0), LoopClosureParameters(), 400
    x = np.arange(count + 1.0)
    assumed = np.sqrt([0.1**2 + 0.002**2, 0.1**2 + 0.002**2, 0.1**2 + 0.0005**2])
    errors = share * assumed * rng.standard_normal((count, 3))
    errors[::40] *= 20.0
    odometry = [np.zeros(3)]
    for error in errors:
        odometry.append(se2.compose(odometry[-1], np.array([1.0, 0.0, 0.0]) + error))
    path = path_along(np.column_stack([x, np.zeros((count + 1, 2))]), np.array(odometry))
    uncertainty = step_uncertainty(path, np.ones(count, bool), DoubtfulNodes(), p)
    by_links = np.tile(np.eye(3), (count, 1, 1))
    by_links[7] = 0.0
    edges = step_edges(path, uncertainty, by_links, path.poses, p)
    # then that is found out, where no link measures a step, too. Assumed lengths are those that odometry has
    lengths = np.hypot(*edges.newer_in_older[count:, :2].T)
    ratios = edges.covariance[count:, 0, 0] / (0.1**2 * lengths + 0.002**2)
    assert ratios[0] == pytest.approx(expected, rel=0.2)
    np.testing.assert_allclose(np.delete(ratios, 7), ratios[0])
    assert ratios[7] == pytest.approx(ratios[0], rel=0.05)
    # and it stays as it was assumed where filter and odometry exclude each other, and nothing has decided
    undecided = uncertainty.decided(np.array([7]), np.array([UNDECIDED]))
    edges = step_edges(path, undecided, by_links, path.poses, p)
    assert edges.covariance[count + 7, 0, 0] / (0.1**2 * lengths[7] + 0.002**2) == pytest.approx(1.0)


def test_where_scans_say_nothing_steps_get_odometrys_scale():
    # given steps of a metre along the way, by a vehicle that turns by 90 degrees at each, as odometry has it
    turns, count = np.pi / 2 * (np.arange(41) % 2), 40
    path, p = path_along(np.column_stack([np.arange(41.0), np.zeros(41), turns])), LoopClosureParameters()
    # when odometry's metre is 2 % too long. Links measure all steps but two, which are open along the way,
    # and a third one
    links = np.tile(1e8 * np.eye(3), (count, 1, 1))
    links[4], links[5] = np.diag([1e8, 0.0, 1e8]), np.diag([0.0, 1e8, 1e8])
    links[6] = 0.0
    uncertainty = step_uncertainty(path, np.ones(count, bool), DoubtfulNodes(), p, Scale(0.98))
    edges = step_edges(path, uncertainty, links, path.poses, p)
    # then these three are shorter, and so is all of odometry
    expected = path.steps * np.where(np.isin(np.arange(count), [4, 5, 6]), 0.98, 1.0)[:, None] ** (1, 1, 0)
    np.testing.assert_allclose(edges.newer_in_older[:count], expected, atol=1e-5)
    np.testing.assert_allclose(edges.newer_in_older[count:], path.steps * (0.98, 0.98, 1.0), atol=1e-12)


def test_an_unmeasured_step_is_as_uncertain_as_odometry_was_wrong():
    # given five steps of a metre by odometry; by the filter the second one is 9 m long
    x = np.arange(6.0)
    by_filter, by_odometry = (np.column_stack([each, np.zeros((6, 2))]) for each in (x + 8.0 * (x > 1.0), x))
    path, p = path_along(by_filter, by_odometry), LoopClosureParameters()
    # when a guess is a step among the edges only
    links = np.zeros((5, 3, 3))
    guessed = step_uncertainty(path, np.zeros(5, bool), DoubtfulNodes(guessed=(2,)), p)
    own = np.diag([0.1**2 + 0.002**2, 0.1**2 + 0.002**2, 0.1**2 + 0.0005**2])
    wide = own + np.diag([8.0**2, 0.0, 0.0])
    np.testing.assert_allclose(step_edges(path, guessed, links, path.poses, p).covariance[:2], [own, wide])
    np.testing.assert_array_equal(guessed.covariances, path.covariances)
    # and when a link spans the last step only; the scans of nodes 2, 3 and 5 did not agree with the map
    doubtful = DoubtfulNodes(unmatched=(2,), contradicted=(3, 5))
    found = step_uncertainty(path, np.array([False, False, False, False, True]), doubtful, p).covariances
    # then the second step may err by 8 m, and the third by the deviations of a slip
    np.testing.assert_allclose(found[1], wide)
    np.testing.assert_allclose(found[2], own + np.diag([p.slip_m, p.slip_m, p.slip_rad]) ** 2)
    # and the others are as certain as matching makes them
    np.testing.assert_array_equal(found[[0, 3, 4]], path.covariances[[0, 3, 4]])


def test_corrected_poses_keep_the_measured_steps_and_later_ones_follow():
    # given a path of four nodes that climbs by 0.5 m a step, whose last three were corrected
    p, maps = LoopClosureParameters(), LocalMaps(LoopClosureParameters())
    measured = np.column_stack([np.arange(6.0), np.zeros((6, 2))])
    corrected = measured[:4] + np.array([(0.0, 0.0, 0.0), *[(0.2, 0.1, 0.0)] * 3])
    heights_m, higher_m = 0.5 * np.arange(6.0), np.array([0.0, 0.1, 0.2, 0.3, 0.3, 0.3])
    first = snapshot_along(measured[:4], heights_m=heights_m[:4])
    maps.extend(first.scans)
    path = MeasuredPath.empty().followed(first, maps.informations, p)
    path = path.corrected_to(corrected, (heights_m + higher_m)[:4])
    np.testing.assert_array_equal(path.steps, np.tile((1.0, 0.0, 0.0), (3, 1)))
    # when the filter goes on from there
    poses = np.vstack([corrected, corrected[-1] + [(1.5, 0.0, 0.0), (2.5, 0.0, 0.0)]])
    later = snapshot_along(poses, heights_m=heights_m + higher_m)
    maps.extend(later.scans)
    path = path.followed(later, maps.informations, p)
    # then the old steps are as they were measured, and the new ones begin at the corrected pose
    np.testing.assert_allclose(path.steps[:, 0], [1.0, 1.0, 1.0, 1.5, 1.0])
    np.testing.assert_allclose(path.way_m, [0.0, 1.0, 2.0, 3.0, 4.5, 5.5])
    np.testing.assert_allclose(path.heights_m, heights_m + higher_m)
    np.testing.assert_allclose(path.climbs_m, 0.5)
    np.testing.assert_allclose(path.way_in_space_m[:4], np.hypot(1.0, 0.5) * np.arange(4.0))


def test_scans_that_do_not_measure_their_step_are_noted():
    # given a way of six scans. The second could not be compared, the fourth contradicts the map in most beams
    agreements = [Agreement(90, 10, 0)] * 6
    agreements[1], agreements[3] = Agreement(5, 0, 95), Agreement(49, 51, 0)
    doubtful = DoubtfulNodes()
    for node, agreement in enumerate(agreements):
        doubtful = doubtful.with_scan(node, agreement)
    # then the step to the second is not measured, and the steps to and from the fourth are guesses
    assert doubtful == DoubtfulNodes(unmatched=(1,), guessed=(3, 4))
    doubtful = doubtful.with_new_place(6, is_contradicted=True).with_new_place(7, is_contradicted=False)
    assert doubtful == DoubtfulNodes((1, 7), (3, 4), (6,))
