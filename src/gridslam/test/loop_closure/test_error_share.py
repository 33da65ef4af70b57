"""How large errors are, as a share of what covariances tell: closed forms along a straight way."""

import math

import numpy as np
import pytest
from room_paths import path_along

from gridslam.loop_closure.edges import Edge, Edges, Match
from gridslam.loop_closure.path.error_share import error_share
from gridslam.loop_closure.path.step_uncertainty import CHI_SQUARE_75

SIGMA_M = 0.05
STEPS, STEP_M, SUPPORT_M = 40, 1.0, 16.0
COVARIANCES = np.tile(np.diag([SIGMA_M, SIGMA_M, 1e-3]) ** 2, (STEPS, 1, 1))
NO_LINKS = Edges.of([])
PATH = path_along(np.column_stack([STEP_M * np.arange(STEPS + 1), np.zeros((STEPS + 1, 2))]))


def closure(older, newer, off_sigmas):
    """A place found again, and so many standard deviations farther along than the path has it."""
    way_m, sigma_m = STEP_M * (newer - older), SIGMA_M * math.sqrt(newer - older)
    found = np.array((way_m + off_sigmas * sigma_m, 0.0, 0.0))
    return Match(older, newer, found, 1e-12 * np.eye(3), 0.9)


def links(error_sigmas, count=STEPS):
    """Exact links, from which each step of the path differs by so many standard deviations, along."""
    off = np.array((STEP_M - error_sigmas * SIGMA_M, 0.0, 0.0))
    return Edges.of([Edge(node, node + 1, off, 1e-12 * np.eye(3)) for node in range(count)])


def share(of_links, closures):
    return error_share(PATH, COVARIANCES, of_links, closures, SUPPORT_M)


def test_before_anything_was_measured_errors_are_as_the_covariances_tell():
    assert share(NO_LINKS, []) == 1.0
    assert share(links(0.1, count=19), []) == 1.0


def test_links_give_the_first_value():
    assert share(links(0.5), []) == pytest.approx(math.sqrt(0.25 / CHI_SQUARE_75), rel=1e-6)
    assert share(links(20.0), []) == 1.0


@pytest.mark.parametrize("sigmas", [0.0, 1.5, 6.0])
def test_a_closure_counts_as_much_as_the_first_value(sigmas):
    # the mean of the first value, 1, and of the closure's square, a third in each of three directions
    mean = (1.0 + sigmas**2 / 3.0) / 2.0
    assert share(NO_LINKS, [closure(0, 20, sigmas)]) == pytest.approx(math.sqrt(mean))


def test_closures_near_each_other_count_by_their_distance():
    # 4 m apart with a support of 16 m: the second counts a quarter; far apart, wholly
    near, far = [closure(0, 20, 3.0), closure(4, 24, 0.0)], [closure(0, 20, 3.0), closure(16, 36, 0.0)]
    assert share(NO_LINKS, near) == pytest.approx(math.sqrt((1.0 + 3.0) / 2.25))
    assert share(NO_LINKS, near[::-1]) == share(NO_LINKS, near)
    assert share(NO_LINKS, far) == pytest.approx(math.sqrt((1.0 + 3.0) / 3.0))
