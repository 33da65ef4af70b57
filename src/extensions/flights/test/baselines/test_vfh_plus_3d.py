"""3DVFH+ on clouds whose answers follow from geometry."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cepa import LaserScan2D, Motion, Reason
from cepa.motion import Cloud
from flights.baselines.vfh_plus_3d import VfhPlus3d, VfhPlus3dParameters, VoxelMemory, bin_directions

EMPTY_SCAN = LaserScan2D(np.full(360, np.inf), -math.pi, math.radians(1.0), 0.1, 30.0)
AHEAD = (2.0, 0.0)
ENLARGEMENT_M = VfhPlus3dParameters().enlargement_m
ALPHA = math.radians(6.0)


def motion(stamp_s=0.0, position=(0.0, 0.0, 2.0), yaw=0.0, climb_ref=0.0):
    attitude = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    return Motion(stamp_s, position, attitude, (0.0, 0.0, 0.0), climb_ref)


def cloud(*points):
    return Cloud(np.array(points, dtype=float).reshape(-1, 3), (-0.26, 0.26), 0.5, 100.0)


def grid(x, ys, zs):
    """Return points on a wall across the way, 0.1 m apart."""
    y, z = np.meshgrid(np.arange(*ys, 0.1), np.arange(*zs, 0.1))
    return np.column_stack((np.full(y.size, x), y.ravel(), z.ravel()))


def steer(points, steering=None, v_ref=AHEAD, where=None):
    steering = steering or VfhPlus3d()
    return steering.steer(EMPTY_SCAN, v_ref, (0.0, 0.0), where or motion(), cloud(*points))


def direction(decision):
    vector = np.array((*decision.velocity_xy, decision.climb_m_s))
    return vector / np.linalg.norm(vector)


def test_in_the_open_the_reference_is_flown_unchanged_in_three_dimensions():
    decision = steer([], where=motion(climb_ref=0.5))
    assert (*decision.velocity_xy, decision.climb_m_s) == pytest.approx((2.0, 0.0, 0.5))
    assert decision.reason is Reason.CUSHION_CLEAR


def test_it_passes_a_long_beam_on_the_nearer_side_with_its_enlargement():
    """A beam across the way, 0.3 m above the lidar and 2.5 m ahead: below it is nearer."""
    beam = grid(2.5, (-6.0, 6.0), (0.3, 0.4))
    decision = steer(beam)
    assert decision.reason is Reason.STEERED
    assert decision.climb_m_s < 0.0
    assert np.linalg.norm((*decision.velocity_xy, decision.climb_m_s)) == pytest.approx(2.0)
    angle = math.acos((beam / np.linalg.norm(beam, axis=1)[:, None] @ direction(decision)).max())
    assert angle >= math.asin(ENLARGEMENT_M / 2.7) - ALPHA


def test_it_goes_round_a_high_trunk_and_over_a_low_wall():
    trunk = grid(2.5, (0.0, 0.3), (-3.0, 3.0))
    decision = steer(trunk)
    assert decision.velocity_xy[1] < -0.3  # the trunk stands to the left
    assert abs(decision.climb_m_s) < 0.3
    wall = grid(2.5, (-6.0, 6.0), (-2.0, 0.1))
    assert steer(wall).climb_m_s > 0.3


def test_it_stops_where_everything_is_blocked():
    angles = bin_directions(6.0).reshape(-1, 3)
    decision = steer(1.5 * angles)
    assert decision.reason is Reason.BLOCKED
    assert (*decision.velocity_xy, decision.climb_m_s) == (0.0, 0.0, 0.0)


def test_it_climbs_and_sinks_no_faster_than_px4_and_not_too_low():
    low, high = VfhPlus3dParameters().sink_m_s, VfhPlus3dParameters().climb_m_s
    steering = VfhPlus3d()
    climbs = 4.0 * bin_directions(6.0)[:, :, 2]
    can = steering.flyable(4.0, motion(position=(0.0, 0.0, 9.0)))
    assert climbs[can].min() >= -low
    assert climbs[can].max() <= high
    assert climbs[~can & (climbs < 0)].max() < -low + 4.0 * ALPHA
    near_ground = steering.flyable(4.0, motion(position=(0.0, 0.0, 0.8)))
    assert climbs[near_ground].min() >= 0.0


def test_the_histogram_fills_the_bins_within_the_enlargement():
    """One voxel: the bins within asin(r / d) hold a - b (d - r), the others nothing."""
    p = VfhPlus3dParameters()
    point = np.array((1.0, 1.0, 1.0))
    density = VfhPlus3d().density(point[None])
    d = math.sqrt(3.0)
    angles = np.arccos(bin_directions(6.0) @ (point / d))
    weight = p.near_weight - (p.near_weight - 1.0) * (d - ENLARGEMENT_M) / (p.window_m - ENLARGEMENT_M)
    reach = math.asin(ENLARGEMENT_M / d)
    assert density[angles < reach - 1e-3] == pytest.approx(weight, rel=1e-5)
    assert not density[angles > reach + 1e-3].any()
    assert VfhPlus3d().density(np.array([[p.window_m - 1e-6, 0.0, 0.0]])).max() == pytest.approx(
        1.0, rel=1e-3
    )


def test_the_binary_histogram_has_hysteresis():
    density, before = np.array([2.0, 1.2, 1.2, 0.9]), np.array([False, True, False, True])
    assert VfhPlus3d().binary(density, before).tolist() == [True, True, False, False]


def test_the_memory_is_in_the_odometrys_frame_and_forgets():
    memory = VoxelMemory(VfhPlus3dParameters(memory_s=3.0))
    (voxel,) = memory.around(np.array([[2.1, 0.1, 0.1]]), motion(0.0))
    assert voxel == pytest.approx((2.1, 0.1, 0.1), abs=0.1)
    # It flies a metre ahead and turns to the left by 90 degrees: what was ahead is to its right
    (turned,) = memory.around(np.empty((0, 3)), motion(1.0, (1.0, 0.0, 2.0), math.pi / 2))
    assert turned == pytest.approx((0.1, -1.1, 0.1), abs=0.1)
    assert not len(memory.around(np.empty((0, 3)), motion(3.1)))
    memory.around(np.array([[2.1, 0.1, 0.1]]), motion(4.0))
    assert not len(memory.around(np.empty((0, 3)), motion(4.1, (-9.0, 0.0, 2.0))))  # out of the window


def test_without_a_cloud_it_stays_level():
    ranges = np.full(360, np.inf)
    ranges[170:191] = 2.0
    decision = VfhPlus3d().steer(
        LaserScan2D(ranges, -math.pi, math.radians(1.0), 0.1, 30.0), AHEAD, (0.0, 0.0), motion(climb_ref=0.2)
    )
    assert decision.reason is Reason.STEERED
    assert decision.climb_m_s is None
    assert math.hypot(*decision.velocity_xy) == pytest.approx(2.0)
