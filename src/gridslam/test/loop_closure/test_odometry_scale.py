"""Odometry's scale is that of links, where links tell it."""

import numpy as np
import pytest

from gridslam import se2
from gridslam.loop_closure.edges import Edges
from gridslam.loop_closure.path.odometry_scale import odometry_scale

SIGMA_M = 0.005


def path_and_links(scale, nodes=200, back=5, seed=0):
    """A winding way in steps of half a metre: its odometry without the scale, and noisy links."""
    rng = np.random.default_rng(seed)
    true = np.zeros((nodes, 3))
    for i in range(1, nodes):
        true[i] = se2.compose(true[i - 1], (0.5, 0.0, 0.2 * np.sin(0.1 * i)))
    odometry = true / (scale, scale, 1.0)
    older, newer = np.array([(i - k, i) for i in range(nodes) for k in range(1, back + 1) if k <= i]).T
    poses = se2.between(true[older], true[newer]) + SIGMA_M * rng.standard_normal((len(older), 3))
    covariances = np.tile(SIGMA_M**2 * np.eye(3), (len(older), 1, 1))
    return odometry, Edges(older, newer, poses, covariances)


@pytest.mark.table("scale", [0.95, 0.99, 1.0, 1.02])
def test_scale_is_found_from_links(scale):
    odometry, links = path_and_links(scale)
    # 200 steps of 0.5 m, each measured to 5 mm and odometry to 7 cm in 0.5 m: one permille is generous
    assert odometry_scale(links, odometry, 0.1, 5).mean == pytest.approx(scale, abs=2e-3)


def test_wrong_links_and_open_ones_do_not_matter():
    odometry, links = path_and_links(0.98)
    # given a tenth of links that are off by half a metre, and half of them open along the way, and short
    wrong = np.arange(len(links.older)) % 10 == 0
    links.newer_in_older[wrong, 0] += 0.5
    is_open = np.arange(len(links.older)) % 2 == 1
    links.newer_in_older[is_open, 0] *= 0.8
    links.covariance[is_open, 0, 0] = 100.0
    assert odometry_scale(links, odometry, 0.1, 5).mean == pytest.approx(0.98, abs=5e-3)


def test_a_turned_link_counts_by_its_covariance_along_the_way():
    # given a vehicle that flies along x while it looks along y; links are open in its own y, which is x
    nodes = 60
    true = np.column_stack([0.5 * np.arange(nodes), np.zeros(nodes), np.full(nodes, np.pi / 2)])
    true[:, 2] += np.pi / 2 * (np.arange(nodes) % 2)
    older, newer = np.arange(nodes - 1), np.arange(1, nodes)
    poses = se2.between(true[older], true[newer])
    covariance = np.tile(SIGMA_M**2 * np.eye(3), (nodes - 1, 1, 1))
    # by the newer node's heading, x of the way is its -y or its -x
    axis = np.where(newer % 2 == 0, 1, 0)
    covariance[np.arange(nodes - 1), axis, axis] = 1e4
    odometry = true / (0.98, 0.98, 1.0)
    # then links tell nothing
    assert odometry_scale(Edges(older, newer, poses, covariance), odometry, 0.1, 1).mean == pytest.approx(
        1.0, abs=1e-3
    )
    # and turned by 90 degrees they tell the scale, together with what is known without them: 1 +- 0.05
    weight = 59 * 0.5**2 / (SIGMA_M**2 + 0.1**2 * 0.5)
    expected = (400.0 + weight * 0.98) / (400.0 + weight)
    turned = covariance[:, [1, 0, 2]][:, :, [1, 0, 2]]
    assert odometry_scale(Edges(older, newer, poses, turned), odometry, 0.1, 1).mean == pytest.approx(
        expected, abs=2e-4
    )


def test_few_links_tell_nothing():
    odometry, links = path_and_links(0.9, nodes=5)
    assert odometry_scale(links, odometry, 0.1, 5).mean == 1.0
    assert odometry_scale(Edges.of([]), odometry, 0.1, 5).mean == 1.0
