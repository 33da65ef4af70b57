"""What Dynamic tells of its answers, for cases whose numbers follow from geometry."""

import math

import numpy as np
import pytest

from cepa import CepaParameters, Dynamic, LaserScan2D, Motion, Reason

BEAMS = 720
ANGLES = -math.pi + np.arange(BEAMS) * 2.0 * math.pi / BEAMS
TO_THE_LEFT = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
AHEAD = np.abs(ANGLES) < 0.3


def scan(ranges, seen=None):
    return LaserScan2D(ranges, -math.pi, 2.0 * math.pi / BEAMS, 0.06, 10.0, seen)


def fly(algorithm, ranges, stamp_s=0.0, seen=None, x=0.0):
    """Answer a scan of a UAV that looks along the odometry's y axis and flies 1 m/s ahead."""
    motion = Motion(stamp_s, (0.0, x, 2.0), TO_THE_LEFT, (0.0, 1.0, 0.0))
    return algorithm.steer(scan(ranges, seen), (1.0, 0.0), (1.0, 0.0), motion)


def test_in_the_open_the_paths_lead_straight_ahead():
    algorithm = Dynamic()
    assert algorithm.report() is None
    assert algorithm.view() is None
    assert fly(algorithm, np.full(BEAMS, np.inf)).reason is Reason.CUSHION_CLEAR
    report, view = algorithm.report(), algorithm.view()
    assert (report.clearance_m, report.admissible) == (math.inf, None)
    for path in (view.predicted_m, view.braking_m):
        np.testing.assert_allclose(path[:, 1], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.diff(view.predicted_m[1:, 0]), 0.05, rtol=0.15)  # 1 m/s, but for the delay
    steps = np.diff(view.braking_m[1:, 0])
    assert (np.diff(steps) < 1e-3).all()
    assert abs(steps[-1]) < 0.05 * 0.1  # slower than 0.1 m/s
    assert len(view.remembered_m) == len(view.movers) == 0


def test_before_a_wall_it_counts_what_can_be_flown():
    algorithm = Dynamic(CepaParameters(body_radius=0.35))
    decision = fly(algorithm, np.where(AHEAD, 1.1 / np.cos(ANGLES), np.inf))
    report = algorithm.report()
    assert report.clearance_m == pytest.approx(1.1 - 0.35)
    assert 0 < report.admissible < decision.directions_tested
    assert report.braking_margin_m < 1.1 - 0.5  # what it has where it stands, beyond r_LB


def test_the_view_shows_what_was_seen_and_does_not_change_the_answers():
    asked, silent = Dynamic(), Dynamic()
    wall = np.where(AHEAD, 3.0 / np.cos(ANGLES), np.inf)
    steps = [
        (wall, None, 0.0),
        (np.full(BEAMS, np.inf), ~AHEAD, 0.2),
        *4 * [(np.full(BEAMS, np.inf), None, 0.4)],
    ]
    left = []
    for number, (ranges, seen, x) in enumerate(steps):
        answers = [fly(algorithm, ranges, 0.1 * number, seen, x) for algorithm in (asked, silent)]
        assert answers[0] == answers[1]
        left.append(asked.view())
    np.testing.assert_allclose(left[1].remembered_m[:, 0], 2.8, atol=1e-6)  # the wall, 0.2 m nearer
    assert left[1].hidden.all()
    assert left[2].hidden.all()  # one scan sees past it
    assert len(left[5].remembered_m) == 0  # four do


@pytest.mark.table("change", [{}, {"r_ub": 1.5}, {"window_m": 12.0}, {"response_p": 1.4}])
def test_another_set_of_parameters_takes_over_what_is_known(change):
    wall, nothing = np.where(AHEAD, 3.0 / np.cos(ANGLES), np.inf), np.full(BEAMS, np.inf)
    earlier, unchanged, other = Dynamic(), Dynamic(), Dynamic(CepaParameters(**change))
    for number in range(4):
        for algorithm in (earlier, unchanged):
            fly(algorithm, wall, 0.1 * number, x=0.1 * number)
    other.take_over(earlier)
    answers = [fly(algorithm, nothing, 0.4, ~AHEAD, 0.4) for algorithm in (other, unchanged)]
    assert len(other.view().remembered_m) == len(unchanged.view().remembered_m) > 0
    assert other.view().hidden.all()
    assert change or answers[0] == answers[1]
