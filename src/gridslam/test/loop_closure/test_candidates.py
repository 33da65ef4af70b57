"""Candidates: nodes of earlier passes that may be a node's place."""

import math

import numpy as np
import pytest
from room_paths import maps_of, path_along, path_of, snapshot_along

from gridslam import se2
from gridslam.loop_closure import LoopClosureParameters, candidates
from gridslam.loop_closure.candidates import Revisit, far_candidates, near_candidates
from gridslam.loop_closure.path.step_uncertainty import DoubtfulNodes, step_uncertainty
from gridslam.search.field import FULL


def revisit_of(path, first_in_map=0):
    return Revisit(path, len(path) - 1, [], np.ones(len(path), bool), first_in_map)


def test_near_candidates_are_the_nearest_node_of_each_earlier_pass():
    # given 30 m east, back 2 m beside it, and east again in between, by steps of a metre
    x = np.arange(31.0)
    xy = np.vstack([np.column_stack([x, 0 * x]), np.column_stack([x[::-1], 2 + 0 * x])])
    xy = np.vstack([xy, np.column_stack([x[:16], 0.5 + 0 * x[:16]])])
    path, p = path_along(np.column_stack([xy, np.zeros(len(xy))])), LoopClosureParameters()
    found = near_candidates(revisit_of(path), p)
    # then the last node, at (15, 0.5), may be at (15, 0) or at (15, 2), where the path came by
    assert [candidate.older for candidate in found] == [15, 31 + 15]
    for candidate in found:
        predicted = se2.between(path.poses[candidate.older], path.poses[-1])
        np.testing.assert_allclose(candidate.window.predicted, predicted)
        assert p.window_min_m <= candidate.window.reach_m <= p.window_max_m
    # and nodes of an earlier map are none
    assert [each.older for each in near_candidates(revisit_of(path, 20), p)] == [31 + 15]


def test_what_the_path_has_just_passed_is_no_candidate():
    p = LoopClosureParameters()
    path = path_along(np.column_stack([np.arange(0.0, p.separation_m, 1.0)] + [np.zeros(20)] * 2))
    assert near_candidates(revisit_of(path), p) == []


@pytest.mark.table(("seen_rad", "is_searched"), [(math.pi, True), (0.1, False)])
def test_far_places_are_looked_for_only_with_what_tells_a_pose(monkeypatch, seen_rad, is_searched):
    # given a way of 40 m on which odometry has slipped; scans show a room, or 0.6 m of its wall
    p, poses = LoopClosureParameters(), np.column_stack([np.arange(41.0), np.zeros((41, 2))])
    snapshot = snapshot_along(poses, seen_rad=seen_rad)
    path, maps = path_of(snapshot, p), maps_of(snapshot, p)
    doubtful = DoubtfulNodes(contradicted=(35,))
    steps = step_uncertainty(path, np.zeros(40, bool), doubtful, p).covariances
    # when a place is looked for in all that the slip allows, 3 sigma being 30 m
    fields = []
    monkeypatch.setattr(candidates, "PlaceSearch", lambda field: fields.append(field) or NothingFound())
    far_candidates(revisit_of(path), steps, maps.around(path, 40), maps, p)
    # then a map is made for it only if the recent one shows where it is in every direction
    assert len(fields) == is_searched
    # and it shows the rooms: walls at y = -3 and 3
    for field in fields:
        rows = np.flatnonzero((field.table == FULL).mean(axis=1) > 0.3)
        y = field.origin_xy_m[1] + (rows + 0.5) * field.resolution_m
        assert [y.min(), y.max()] == pytest.approx([-3.0, 3.0], abs=0.11)


class NothingFound:
    """A search in vain."""

    def find(self, points_xy_m, settings, window):
        return []
