"""What the algorithms propose, on scans whose answers are known from geometry."""

import math

import numpy as np
import pytest

from cepa import CepaParameters, LaserScan2D
from flights.worlds.placements import R_LB_M
from master_thesis.experiment_2 import summary
from master_thesis.experiment_2.proposals import K_SWEEP, propose, sweep

BEAMS = 1440
ANGLES = np.arange(BEAMS) * 2 * math.pi / BEAMS - math.pi
PARAMETERS = CepaParameters(r_lb=R_LB_M)


def scan(*columns, wall_m=math.inf):
    """A full turn that sees columns (x, y, radius) and a wall along x, this far to the left."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ranges = np.where(np.sin(ANGLES) > 0.0, wall_m / np.sin(ANGLES), math.inf)
    for x, y, radius in columns:
        ahead = x * np.cos(ANGLES) + y * np.sin(ANGLES)
        inside = radius**2 - (x**2 + y**2 - ahead**2)
        hit = np.where((inside >= 0.0) & (ahead > 0.0), ahead - np.sqrt(np.maximum(inside, 0.0)), math.inf)
        ranges = np.minimum(ranges, hit)
    return LaserScan2D(ranges, -math.pi, 2 * math.pi / BEAMS, 0.06, 10.0)


def heading(velocity_xy):
    return math.atan2(velocity_xy[1], velocity_xy[0])


def test_a_wall_alone_is_fled_straight_away_from_by_both():
    proposed = propose(scan(wall_m=0.6), PARAMETERS)
    assert proposed.emergency
    assert proposed.reason == "emergency sum"
    assert proposed.original_xy == proposed.improved_xy
    assert heading(proposed.original_xy) == pytest.approx(-math.pi / 2, abs=0.01)


def test_by_three_columns_only_the_improved_flies_along_the_wall():
    columns = [(x, -0.7, 0.1) for x in (-0.6, 0.0, 0.6)]
    proposed = propose(scan(*columns, wall_m=0.5), PARAMETERS)
    assert proposed.reason == "emergency open section"
    assert heading(proposed.original_xy) == pytest.approx(-math.pi / 2, abs=0.01)
    # Along the wall ahead or behind, within what the corridor of 1.1 m leaves to a body of 0.7 m over 1.2 m
    assert abs(math.sin(heading(proposed.improved_xy))) < (1.1 - 0.7) / 1.2


def test_a_lower_k_spreads_near_obstacles_over_more_beams():
    """One beam ends 0.5 m away, so intrudes by 0.3 m; beside it LS' rises by K per radian up to r_LB."""
    parameters = CepaParameters(r_lb=R_LB_M, emergency_gain=1.0, v_min=0.0, v_max=10.0)
    ranges = np.full(BEAMS, math.inf)
    ranges[0] = 0.5
    thin = LaserScan2D(ranges, 0.0, 2 * math.pi / BEAMS, 0.06, 10.0)
    pushed = {p.k_filter: math.hypot(*p.original_xy) for p in sweep(thin, parameters)}
    assert list(pushed) == list(K_SWEEP)
    # Sum of intrusions along x: closed form of the integral of (0.3 - K a) cos a over |a| < 0.3 / K
    for k in (0.5, 1.0, 2.0):
        spread = 2 * k * (1 - math.cos(0.3 / k))
        assert pushed[k] == pytest.approx(spread, rel=0.01), k
    assert pushed[0.5] > 2 * pushed[2.0] > 4 * pushed[10.0]


def test_without_anything_near_there_is_no_emergency():
    proposed = propose(scan(wall_m=2.0), PARAMETERS)
    assert not proposed.emergency
    assert proposed.improved_xy == proposed.original_xy == (0.0, 0.0)


@pytest.mark.table(
    ("velocity_xy", "words"),
    [
        ((1.0, 0.25), "1.00 m/s ahead, 0.25 m/s to the left"),
        ((-0.5, -1.0), "0.50 m/s back, 1.00 m/s to the right"),
        ((-0.001, 0.0), "0.00 m/s ahead, 0.00 m/s to the left"),
    ],
)
def test_a_velocity_is_told_with_its_side_and_no_sign(velocity_xy, words):
    proposed = {"original_xy": velocity_xy, "improved_xy": (0.0, 0.0), "reason": "FREE"}
    content = {
        **dict.fromkeys(("scenario", "algorithm", "lidar", "failure", "min_clearance_m")),
        "k_filter": 50.0,
        "proposals": [proposed],
        "collision": False,
    }
    assert f"original proposes      {words}" in summary.headline(content)
