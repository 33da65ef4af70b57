"""Clouds and voxels that are kept packed come back bit for bit, and take less memory."""

from __future__ import annotations

import numpy as np
from flown_volumes import PARAMETERS, assert_equal, cloud_at, flown
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hypothesis_numpy
from room_clouds import puck_directions, ranges_in_hold

from gridslam.volume import Board, KeptCloud, VoxelMap
from gridslam.volume.clouds import COORDINATE_MAX, rounded, step_of
from gridslam.volume.correction.settled_events import PackedVoxels
from gridslam.volume.kernels.tiles import VOXELS

PATH = [(6.0 + 3.0 * k, 5.0 + 2.0 * k, 3.0, 0.4 * k) for k in range(4)]
whole_points = hypothesis_numpy.arrays(
    np.int16, st.tuples(st.integers(0, 40), st.just(3)), elements=st.integers(-COORDINATE_MAX, COORDINATE_MAX)
)


@given(whole_points, st.sampled_from([0.05, 0.1, 0.3]))
def test_a_kept_cloud_returns_its_rounded_points(whole, resolution_m):
    """Also when neighbours are as far apart as can be, so that their differences overflow."""
    points = whole * np.float32(step_of(resolution_m))
    cloud = KeptCloud.of(rounded(points, resolution_m), resolution_m)
    np.testing.assert_array_equal(cloud.points(), points)


def test_the_cloud_of_a_room_takes_less_than_two_bytes_a_point():
    directions = puck_directions()
    points = directions * ranges_in_hold(np.array((14.0, 9.0, 4.0)), directions)[:, None]
    cloud = KeptCloud.of(rounded(points, 0.1), 0.1)
    assert len(cloud.packed) < 2 * cloud.count


def test_packed_voxels_go_on_as_if_they_had_never_been_packed(monkeypatch):
    monkeypatch.setattr("gridslam.volume.correction.settled_events.AT_ONCE", 20)
    voxels = flown(PATH).voxels
    packed = PackedVoxels.of(voxels)
    assert len(packed.packed) > 2
    unpacked = packed.unpacked()
    assert_equal(unpacked, voxels)
    points, pose = cloud_at(14.0, 9.0, 4.0, 1.0, seed=20)
    for each in (unpacked, voxels):
        each.insert(each.rays(pose.translation, pose.of_points(points)), Board())
    assert_equal(unpacked, voxels)
    assert_equal(packed.unpacked(), flown(PATH).voxels)  # what was unpacked is the caller's


def test_packed_voxels_take_a_tenth_of_their_memory():
    voxels = flown(PATH).voxels
    packed = PackedVoxels.of(voxels)
    assert sum(map(len, packed.packed)) < 0.1 * 4 * VOXELS * len(packed.tiles)


def test_a_map_without_voxels_is_packed_too():
    unpacked = PackedVoxels.of(VoxelMap(PARAMETERS)).unpacked()
    assert not len(unpacked.known_tiles())
