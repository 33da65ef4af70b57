"""What becomes of a scan before it meets a map: ranges, frames, thinning, surfaces."""

from __future__ import annotations

import math

import numpy as np
import plain_filter as reference
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gridslam.kernels.surfaces import line_normals, surface_normals, thin_out
from gridslam.maps.beams import BEAMS_MAX, THIN_DEPTH, THIN_SPACING, Beams
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan


def beams_of(angles, ranges, lidar=(0.0, 0.0, 0.0), range_max=10.0, **parameters) -> Beams:
    scan = PlanarScan(0.0, np.array(angles, float), np.array(ranges, float), lidar, range_max)
    return Beams.from_scan(scan, SlamParameters(**parameters))


def test_ranges_mean_what_they_mean_to_gmapping():
    # maxUrange 4, maxRange 9: usable, only freeing, no return (two), too far
    beams = beams_of(range(5), (3.0, 5.0, math.inf, 10.0, 9.5), maxUrange=4.0, maxRange=9.0, delta=0.1)
    np.testing.assert_allclose(np.hypot(*beams.ends.T), (30.0, 40.0))
    assert beams.hits.tolist() == [True, False]
    assert len(beams.matching) == 1


def test_no_return_frees_when_max_range_says_so():
    beams = beams_of((0.0,), (math.inf,), maxUrange=4.0, maxRange=math.inf, delta=0.1)
    np.testing.assert_allclose(beams.ends, [(40.0, 0.0)])
    assert not beams.hits.any()


def test_by_default_all_but_the_last_centimetre_is_used():
    beams = beams_of((0.0, 1.0), (9.98, 9.995))
    assert beams.hits.tolist() == [True]


@pytest.mark.table("order", [[0, 1, 2], [2, 1, 0], [1, 2, 0]])
def test_beams_are_put_into_the_base_frame_in_any_order(order):
    # a lidar 1 m ahead of the base, looking to the left
    angles, ranges = np.array([-math.pi / 2, 0.0, 0.5]), np.array([2.0, 1.0, 3.0])
    beams = beams_of(angles[order], ranges[order], lidar=(1.0, 0.0, math.pi / 2), delta=0.1)
    np.testing.assert_allclose(beams.lidar, (10.0, 0.0))
    expected = [(30.0, 0.0), (10.0, 10.0), (10.0 - 30.0 * math.sin(0.5), 30.0 * math.cos(0.5))]
    np.testing.assert_allclose(beams.ends, expected, atol=1e-9)
    np.testing.assert_allclose(beams.matching[:, :2], expected, atol=1e-9)


def test_lskip_leaves_beams_out_of_matching_only():
    angles = np.linspace(-1.5, 1.5, 31)
    beams = beams_of(angles, np.full(31, 5.0), lskip=2)
    assert (len(beams.ends), len(beams.matching)) == (31, 11)


@given(st.integers(0, 200), st.integers(0, 10_000), st.booleans())
def test_thinning_averages_runs_of_neighbours(count, seed, dense):
    rng = np.random.default_rng(seed)
    bearings = np.sort(rng.uniform(-1.0, 1.0 if not dense else -0.9, count))
    ranges = 30.0 + np.cumsum(rng.normal(0.0, 0.5, count))
    thin_bearings, thin_ranges = np.empty(count), np.empty(count)
    number = thin_out(bearings, ranges, THIN_SPACING, THIN_DEPTH, thin_bearings, thin_ranges)
    expected, first = [], 0
    while first < count:
        near = (bearings - bearings[first]) * ranges[first] <= THIN_SPACING
        near &= np.abs(ranges - ranges[first]) <= THIN_DEPTH
        last = first
        while last < count and near[last]:
            last += 1
        expected.append((bearings[first:last].mean(), ranges[first:last].mean()))
        first = last
    got = np.column_stack((thin_bearings[:number], thin_ranges[:number]))
    np.testing.assert_allclose(got, np.reshape(expected, (-1, 2)), atol=1e-9)


@pytest.mark.table(("count", "at_most"), [(180, 180), (3_600, 800), (10_000, 800)])
def test_matching_costs_no_more_for_more_beams_of_the_same_view(count, at_most):
    # a circle of 3 m has 377 cells of 5 cm along its circumference; half a cell apart, 754 beams
    rng = np.random.default_rng(0)
    angles = np.linspace(-math.pi, math.pi, count, endpoint=False)
    beams = beams_of(angles, 3.0 + 0.01 * rng.standard_normal(count))
    assert len(beams.matching) <= at_most


@pytest.mark.table(("count", "at_most"), [(180, 180), (BEAMS_MAX, BEAMS_MAX), (10_000, 1600)])
def test_the_map_gets_each_beam_unless_they_lie_close_together(count, at_most):
    # given a wall all around at 3 m, and nothing in range in every second direction of a quarter
    angles = np.linspace(-math.pi, math.pi, count, endpoint=False)
    ranges = np.where((angles > 0.0) & (angles < 0.5 * math.pi) & (np.arange(count) % 2 > 0), 9.0, 3.0)
    beams = beams_of(angles, ranges, maxUrange=4.0, delta=0.05)
    # then there are at most as many beams as half cells along both circles, and none is between hit and miss
    assert (len(beams.ends) == count) == (count <= BEAMS_MAX)
    assert len(beams.ends) <= at_most
    np.testing.assert_allclose(np.hypot(*beams.ends.T), np.where(beams.hits, 60.0, 80.0), atol=0.01)
    assert (
        np.diff(np.sort(np.arctan2(*beams.ends[beams.hits].T[::-1]))).max()
        < 2.0 * 0.5 / 60.0 + 4 * math.pi / count
    )


def normals_of(points):
    points = np.array(points, float)
    normals, flat = np.empty_like(points), np.empty(len(points), bool)
    surface_normals(points, np.empty(len(points), bool), normals, flat, False)
    return normals, flat


@given(st.floats(-math.pi, math.pi), st.floats(10.0, 100.0), st.integers(0, 1000))
def test_normals_of_a_wall_are_those_of_a_line_fit(direction, distance, seed):
    # given a wall at a distance, its points a cell apart, with a little noise
    rng = np.random.default_rng(seed)
    along = np.arange(-8.0, 9.0)
    wall = np.column_stack((distance + 0.05 * rng.standard_normal(along.size), along))
    points = reference.turned(direction, wall)
    normals, flat = normals_of(points)
    assert flat[2:-2].all()
    # the middle point has three neighbours on either side within REACH, or two at least
    reach = np.hypot(*(points - points[8]).T)
    near = (reach <= 3.0) | (np.abs(np.arange(along.size) - 8) <= 2)
    expected, _ = reference.line_fit(points[near])
    assert abs(normals[8] @ expected) == pytest.approx(1.0, abs=1e-9)


@given(st.integers(0, 1000))
def test_normals_of_a_local_map_are_those_of_line_fits(seed):
    rng = np.random.default_rng(seed)
    bearings = np.sort(rng.uniform(-math.pi, math.pi, 40))
    points = rng.uniform(1.0, 2.0, (40, 1)) * np.column_stack((np.cos(bearings), np.sin(bearings)))
    gaps, normals = np.full(40, 0.8), np.empty((40, 2))
    line_normals(points, gaps, normals)
    for i, point in enumerate(points):
        around = points[max(0, i - 3) : i + 4]
        near = around[np.hypot(*(around - point).T) < 0.8]
        if len(near) < 4:
            assert np.isnan(normals[i]).all()
        else:
            assert abs(normals[i] @ reference.line_fit(near)[0]) == pytest.approx(1.0, abs=1e-6)
            assert normals[i] @ point <= 0.0


def test_corners_and_single_points_have_no_normal():
    # given two walls that meet at a right angle, and a lone point behind a gap
    first = [(20.0, y) for y in range(-6, 1)]
    second = [(20.0 - x, 0.5) for x in range(1, 7)]
    normals, flat = normals_of([*first, *second, (0.0, 40.0)])
    assert flat[1]
    assert abs(normals[1, 0]) == pytest.approx(1.0)
    assert flat[-3]
    assert abs(normals[-3, 1]) == pytest.approx(1.0)
    assert not flat[6]  # the corner itself
    assert not flat[-1]
