"""Given groups of points, those that hang together are those of all pairs, in little memory."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from inspection.findings.linking import linked, pieces_of
from inspection.findings.merging import merged
from inspection.findings.placing import Placed


def by_all_pairs(groups, apart_m):
    """A slow reference."""
    of = np.repeat(np.arange(len(groups)), [len(each) for each in groups])
    pairs = cKDTree(np.concatenate(groups)).query_pairs(apart_m, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), (of[pairs[:, 0]], of[pairs[:, 1]])), (len(groups),) * 2)
    count, numbers = connected_components(graph, directed=False)
    return {frozenset(np.flatnonzero(numbers == number).tolist()) for number in range(count)}


@given(st.integers(0, 2**32 - 1))
def test_groups_hang_together_as_by_all_pairs(seed):
    rng = np.random.default_rng(seed)
    middles = rng.uniform(-0.5, 0.5, (rng.integers(1, 40), 3))
    groups = [m + rng.normal(0.0, rng.uniform(0.001, 0.1), (rng.integers(1, 20), 3)) for m in middles]
    assert set(map(frozenset, linked(groups, 0.06))) == by_all_pairs(groups, 0.06)
    points = np.concatenate(groups)
    assert {frozenset(each.tolist()) for each in pieces_of(points, 0.06)} == by_all_pairs(
        points[:, None], 0.06
    )


@pytest.mark.table(("apart", "is_one"), [(0.0599, True), (0.0601, False)])
def test_what_is_just_apart_stays_apart(apart, is_one):
    groups = [np.zeros((1, 3)), np.array([[0.0, -apart, 0.0]])]
    assert (len(linked(groups, 0.06)) == 1) == is_one


def test_a_spot_of_many_points_in_many_photographs_takes_little_memory():
    """60 spots of 10 cm, each of 400 points in 10 photographs: 0.5 G pairs."""
    rng = np.random.default_rng(1)
    spots = rng.uniform(0.0, 30.0, (60, 3)) * (1.0, 0.0, 1.0)
    disc = rng.uniform(-0.05, 0.05, (400, 3)) * (1.0, 0.0, 1.0)
    placed = [
        Placed(
            "rust", spot + disc, np.array((0.0, 1.0, 0.0)), 0.008, f"{k}.jpg", 1.0, np.array((0.0, 2.0, 0.0))
        )
        for spot in spots
        for k in range(10)
    ]
    tracemalloc.start()
    found = merged(placed, 0.06)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(found) == 60
    assert peak < 100e6
