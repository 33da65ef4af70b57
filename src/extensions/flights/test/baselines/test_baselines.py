"""The baselines on scans whose answers follow from geometry, and in short flights."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cepa import CepaParameters, LaserScan2D, Reason
from flights.baselines import BASELINES, CollisionPrevention, CollisionPreventionParameters, VfhPlus
from flights.baselines.sectors import Sectors, angle_between

BEAMS = 720
AHEAD = (2.0, 0.0)


def scan_of(distance):
    """Return a full turn of ranges given by a function of the angles, rad in -pi..pi."""
    angles = -math.pi + np.arange(BEAMS) * 2.0 * math.pi / BEAMS
    return LaserScan2D(distance(angles), -math.pi, 2.0 * math.pi / BEAMS, 0.1, 30.0)


def wall_ahead(distance_m):
    """Return an endless wall across the way."""

    def distance(angles):
        with np.errstate(divide="ignore"):
            return np.where(np.abs(angles) < math.pi / 2, distance_m / np.cos(angles), np.inf)

    return scan_of(distance)


def disc(distance_m, radius_m, bearing_rad=0.0):
    """Return a single round trunk."""

    def distance(angles):
        across = np.abs(np.sin(angles - bearing_rad)) * distance_m
        hit = (across < radius_m) & (np.cos(angles - bearing_rad) > 0)
        along = distance_m * np.cos(angles - bearing_rad)
        return np.where(hit, along - np.sqrt(np.maximum(radius_m**2 - across**2, 0.0)), np.inf)

    return scan_of(distance)


@pytest.mark.table("name", BASELINES)
def test_in_the_open_the_reference_is_flown_unchanged(name):
    decision = BASELINES[name]().steer(scan_of(lambda a: np.full_like(a, np.inf)), (1.2, -0.7))
    assert decision.velocity_xy == pytest.approx((1.2, -0.7))
    assert decision.reason is Reason.CUSHION_CLEAR


@pytest.mark.parametrize("name", BASELINES)
@given(seed=st.integers(0, 2**32 - 1), direction=st.floats(-math.pi, math.pi))
def test_nobody_is_ever_faster_than_the_reference(name, seed, direction):
    rng = np.random.default_rng(seed)
    ranges = np.where(rng.random(BEAMS) < 0.3, np.inf, rng.uniform(0.2, 8.0, BEAMS))
    v_ref = (2.0 * math.cos(direction), 2.0 * math.sin(direction))
    decision = BASELINES[name]().steer(scan_of(lambda _: ranges), v_ref, rng.uniform(-2, 2, 2))
    assert math.hypot(*decision.velocity_xy) <= 2.0 + 1e-9


def test_collision_prevention_brakes_as_its_law_says():
    """Its speed is the less of P x distance and the root of s = v^2 / 2a + 2 v a / j."""
    p = CollisionPreventionParameters(CP_DIST=1.0, CP_GUIDE_ANG=0.0)
    steering = CollisionPrevention(collision_prevention=p)
    for distance_m in (1.2, 2.0, 3.0):
        v, _ = steering.steer(wall_ahead(distance_m), (5.0, 0.0)).velocity_xy
        s = distance_m - p.CP_DIST
        by_jerk = v**2 / (2 * p.MPC_ACC_HOR) + 2 * v * p.MPC_ACC_HOR / p.MPC_JERK_MAX
        assert v == pytest.approx(p.MPC_XY_P * s, rel=1e-3) or by_jerk == pytest.approx(s, rel=1e-3)
        assert v <= p.MPC_XY_P * s * 1.001
        assert by_jerk <= s * 1.001


def test_collision_prevention_keeps_the_distance_within_which_cepa_flees():
    """Both are hard limits; compared with CEPA's soft radius, it would stop before gaps that CEPA flies."""
    assert CollisionPreventionParameters().CP_DIST == CepaParameters().r_lb == 0.5
    steering = CollisionPrevention()
    assert steering.steer(wall_ahead(0.49), AHEAD).reason is Reason.BLOCKED
    assert steering.steer(wall_ahead(1.2), AHEAD).velocity_xy[0] > 0.5


def test_collision_prevention_stops_at_its_distance_and_sooner_if_fast():
    steering = CollisionPrevention(collision_prevention=CollisionPreventionParameters(CP_DIST=1.0))
    assert steering.steer(wall_ahead(0.9), AHEAD).reason is Reason.BLOCKED
    standing, _ = steering.steer(wall_ahead(2.0), AHEAD, (0.0, 0.0)).velocity_xy
    closing, _ = steering.steer(wall_ahead(2.0), AHEAD, (1.5, 0.0)).velocity_xy
    assert 0.0 < closing < standing


def test_collision_prevention_does_not_fly_into_the_unseen():
    ranges = np.full(BEAMS, np.inf)
    scan = LaserScan2D(ranges, -math.pi, 2 * math.pi / BEAMS, 0.1, 30.0, seen=np.arange(BEAMS) < BEAMS // 4)
    blind = CollisionPrevention(collision_prevention=CollisionPreventionParameters(CP_GUIDE_ANG=0.0))
    assert blind.steer(scan, AHEAD).reason is Reason.BLOCKED
    bold = CollisionPrevention(collision_prevention=CollisionPreventionParameters(CP_GO_NO_DAT=True))
    assert bold.steer(scan, AHEAD).velocity_xy == pytest.approx(AHEAD)


@pytest.mark.table("side", [-1.0, 1.0])
def test_vfh_plus_passes_a_trunk_on_the_nearer_side_with_its_enlargement(side):
    bearing = -side * 0.05
    decision = VfhPlus().steer(disc(2.0, 0.2, bearing), AHEAD)
    angle = math.atan2(decision.velocity_xy[1], decision.velocity_xy[0])
    assert decision.reason is Reason.STEERED
    assert angle * side > 0.0
    assert angle_between(angle, bearing) >= math.asin(0.8 / 2.0) - Sectors(72).width_rad


def test_vfh_plus_flies_through_the_middle_of_a_narrow_gap():
    def gap(angles):
        return np.where(np.abs(angles - 0.3) < 0.6, np.inf, 1.5)

    decision = VfhPlus().steer(scan_of(gap), AHEAD)
    angle = math.atan2(decision.velocity_xy[1], decision.velocity_xy[0])
    assert angle == pytest.approx(0.3, abs=Sectors(72).width_rad)


def test_vfh_plus_stops_where_everything_is_blocked():
    assert VfhPlus().steer(scan_of(lambda a: np.full_like(a, 1.0)), AHEAD).reason is Reason.BLOCKED


def test_the_binary_histogram_has_hysteresis():
    steering = VfhPlus()
    density, before = np.array([0.2, 0.1, 0.1, 0.01]), np.array([False, True, False, True])
    assert steering.binary(density, before).tolist() == [True, True, False, False]


def test_sectors_know_what_they_do_not_see():
    scan = LaserScan2D([2.0, 3.0], 0.0, math.pi / 2, 0.1, 30.0)
    nearest = Sectors(4).nearest(scan.full_turn(0))
    assert nearest[:2].tolist() == [2.0, 3.0]
    assert np.isnan(nearest[2:]).all()
