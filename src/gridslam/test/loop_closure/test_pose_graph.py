"""The pose graph in closed form and beside plain versions, and the path's uncertainty."""

import math

import numpy as np
import pytest
from equal_steps import Steps, match
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from gridslam import se2
from gridslam.kernels.pose_graph import shortest_ways
from gridslam.loop_closure.edges import Edge, Edges
from gridslam.loop_closure.path.pose_graph import ROBUST_SCALE, optimise
from gridslam.loop_closure.path.way_uncertainty import way_covariances


def test_a_wrong_turn_yields_to_what_scans_say_however_wrong_the_start():
    """Odometry and two exact links contradict one step of the filter, which turns by 2 rad too much."""
    true = Steps((1.0, 0.0, 0.0), np.diag([0.01, 0.01, 0.01]), 10)
    wrong = Steps((1.0, 0.0, 0.0), np.diag([0.01, 0.01, 0.01]), 10)
    wrong.steps[5, 2] = 2.0
    start = [np.zeros(3)]
    for step in wrong.steps:
        start.append(se2.compose(start[-1], step))
    links = [match(4, 6, (2.0, 0.0, 0.0), 0.01), match(5, 6, (1.0, 0.0, 0.0), 0.01)]
    edges = [*wrong.edges(), *true.edges(), *links]
    assert np.abs(optimise(np.array(start), Edges.of(edges), is_far=True) - true.poses).max() < 0.1


def plain_errors(moved, edges):
    """Each edge's error, divided by its deviations, for poses (k, 3) in one row."""
    poses = moved.reshape(-1, 3)
    older, newer = np.array([(edge.older, edge.newer) for edge in edges]).T
    errors = se2.between([edge.newer_in_older for edge in edges], se2.between(poses[older], poses[newer]))
    whitening = [np.linalg.inv(np.linalg.cholesky(edge.covariance)) for edge in edges]
    return np.einsum("nij,nj->ni", whitening, errors)


@pytest.mark.table("seed", range(2))
def test_path_is_where_no_small_step_of_any_node_lowers_the_robust_cost(seed):
    # given a bent path with errors, and measurements between nodes drawn at random, one of them wrong
    rng = np.random.default_rng(seed)
    covariance = np.diag([0.05, 0.02, 0.01]) ** 2 + 1e-4 * np.ones((3, 3))
    chain = Steps((1.0, 0.0, 0.3), covariance, 70)
    edges = chain.edges()
    for older, newer in np.sort([rng.choice(71, 2, replace=False) for _ in range(40)]):
        true = se2.between(chain.poses[older], chain.poses[newer])
        edges.append(Edge(older, newer, true + rng.multivariate_normal(np.zeros(3), covariance), covariance))
    edges.append(Edge(3, 40, np.array([9.0, 9.0, 3.0]), covariance))
    start = np.vstack([chain.poses[:1], chain.poses[1:] + 0.1 * rng.standard_normal((70, 3))])
    # when it is optimised
    found = optimise(start, Edges.of(edges), 1e-12).ravel()
    # then the first node stays, and the slope of the plain cost is zero along all others
    np.testing.assert_allclose(found[:3], start[0], atol=1e-6)

    def cost(moved):
        squares = (plain_errors(moved, edges) ** 2).sum(axis=1)
        return 0.5 * ROBUST_SCALE**2 * np.log1p(squares / ROBUST_SCALE**2).sum()

    shifts = 1e-4 * np.eye(len(found))[3:]
    ahead, behind = (np.array([cost(found + sign * shift) for shift in shifts]) for sign in (1.0, -1.0))
    slopes, curvatures = (ahead - behind) / 2e-4, (ahead + behind - 2.0 * cost(found)) / 1e-8
    assert np.abs(slopes / curvatures).max() < 1e-4


def test_shortest_ways_are_those_of_dijkstra():
    rng = np.random.default_rng(0)
    older, newer = np.arange(199), np.arange(1, 200)
    jumps = np.array([rng.choice(200, 2, replace=False) for _ in range(30)])
    older, newer = np.append(older, jumps[:, 0]), np.append(newer, jumps[:, 1])
    lengths = rng.uniform(0.1, 2.0, len(older))
    found, before, edges = shortest_ways(200, older, newer, lengths, 120)
    graph = coo_matrix((lengths, (older, newer)), shape=(200, 200)).tocsr()
    np.testing.assert_allclose(found, dijkstra(graph, directed=False, indices=120))
    others = np.flatnonzero(np.arange(200) != 120)
    np.testing.assert_allclose(found[others] - found[before[others]], lengths[edges[others]])
    assert {*zip(older, newer), *zip(newer, older)}.issuperset(zip(others, before[others]))


def test_same_graph_gives_the_same_path_bit_for_bit():
    chain = Steps((1.0, 0.0, 0.1), np.diag([0.01, 0.01, 0.0004]), 200)
    closures = [match(i, i + 63, (0.1, 0.05, 0.02 * i)) for i in range(0, 130, 7)]
    edges = Edges.of([*chain.edges(), *closures])
    assert np.array_equal(optimise(chain.poses, edges), optimise(chain.poses, edges))


def test_uncertainty_along_the_way_is_that_of_drawn_paths():
    # Given a bent chain, its covariance against 4000 paths with drawn errors
    covariance = np.diag([0.02, 0.01, 0.005]) ** 2
    chain = Steps((1.0, 0.0, 0.15), covariance, 12)
    predicted = way_covariances(chain, chain.covariances, [], 12, drift_share=0.0)[0]
    rng = np.random.default_rng(0)
    ends = np.zeros((4000, 3))
    for step in chain.steps:
        noise = rng.multivariate_normal(np.zeros(3), covariance, size=len(ends))
        ends = se2.compose(se2.compose(ends, step[None]), noise)
    drawn = np.cov(se2.between(chain.poses[-1], ends).T)
    assert predicted == pytest.approx(drawn, abs=0.08 * np.abs(drawn).max())


def test_the_ways_need_no_code_that_the_warm_up_does_not_compile():
    chain = Steps((1.0, 0.0, 0.1), np.eye(3), 4)
    way_covariances(chain, chain.covariances, [], 0, 0.01)
    layouts = {kind.layout for kinds in shortest_ways.signatures for kind in kinds if hasattr(kind, "layout")}
    assert layouts == {"C"}, "numba compiles the kernel in flight"


def test_closures_shorten_the_way():
    chain = Steps((1.0, 0.0, 2 * math.pi / 40), np.diag([0.03, 0.03, 0.01]) ** 2, 40)
    closures = [match(0, 39, se2.between(chain.poses[0], chain.poses[39]))]
    ways = [way_covariances(chain, chain.covariances, known, 40, 0.0)[0] for known in ([], closures)]
    assert np.trace(ways[1]) < 0.1 * np.trace(ways[0])
    # the drift is a share of the way: 40 m, or a step and 0.1 m over the closure
    steps = np.zeros_like(chain.covariances)
    drift = way_covariances(chain, steps, [], 40, 0.01)[0]
    np.testing.assert_allclose(drift, np.diag([0.4**2, 0.4**2, 0.0]), rtol=1e-2)
    certain = [match(0, 39, closures[0].newer_in_older, sigma=0.0)]
    drift = way_covariances(chain, steps, certain, 40, 0.01)[0]
    np.testing.assert_allclose(drift, np.diag([0.011**2, 0.011**2, 0.0]), rtol=1e-2)
