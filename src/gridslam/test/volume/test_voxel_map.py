"""Insertion against OctoMap's rules written slowly, and against OctoMap itself."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from plain_volume import PlainVolume, body_of, dense, filled, leaves_of_full
from room_clouds import puck_in_hold

from gridslam import MapError
from gridslam.volume import FLAT_MISS, Board, VolumeParameters, VoxelMap, stream_of
from gridslam.volume.drawing.centres import occupied_centres
from gridslam.volume.kernels.rays import LANES

RESOLUTION = 0.1
on_the_grid = st.integers(-60, 60).map(lambda half_voxels: half_voxels * RESOLUTION / 2.0)
"""Coordinates on the voxels' borders and in their middles, where rounding decides."""
anywhere = st.floats(-3.0, 3.0, width=32)
point = st.tuples(*[st.one_of(on_the_grid, anywhere)] * 3)
cloud = st.tuples(point, st.lists(point, max_size=12))


def mapped(clouds, **given_parameters):
    voxel_map, board = VoxelMap(VolumeParameters(**given_parameters)), Board()
    for origin, points in clouds:
        voxel_map.insert(voxel_map.rays(origin, np.array(points, np.float32).reshape(-1, 3)), board)
    assert not np.concatenate((board.misses, board.hits)).any()
    return voxel_map


def oracle_of(clouds, max_range=-1.0):
    octomap = pytest.importorskip("pyoctomap")
    tree = octomap.OcTree(RESOLUTION)
    for origin, points in clouds:
        # To float32 first, as OctoMap's points are
        origin, points = (np.array(part, np.float32).astype(float) for part in (origin, points))
        tree.insertPointCloud(points.reshape(-1, 3), origin, max_range)
    return tree


@given(st.lists(cloud, min_size=1, max_size=4), st.sampled_from([-1.0, 1.5]))
@example([((0.0, 0.0, 0.0), [(1.0, 1.0, 1.0), (1.0, 1.0, 0.0), (-1.0, 1.0, -1.0)])], -1.0)
@example([((0.05, 0.05, 0.05), [(1.0, 0.05, 0.05)])] * 3, -1.0)
def test_voxels_equal_those_of_octomaps_rules_written_slowly(clouds, max_range):
    plain = PlainVolume(RESOLUTION, max_range)
    for origin, points in clouds:
        plain.insert(origin, points)
    voxel_map = mapped(clouds, max_range_m=max_range)
    box = voxel_map.box()
    np.testing.assert_array_equal(voxel_map.values(box), dense(plain.voxels, box))


@given(st.tuples(point, st.lists(point, min_size=LANES, max_size=3 * LANES)), st.integers(1, 7))
def test_voxels_of_many_rays_equal_octomaps_also_where_they_are_surely_free(cloud, times):
    """Rays are followed side by side; five misses give a voxel the least log-odds."""
    origin, points = cloud
    plain, clouds = PlainVolume(RESOLUTION), [cloud] * times + [(points[0], [origin, *points])]
    for each in clouds:
        plain.insert(*each)
    voxel_map = mapped(clouds)
    box = voxel_map.box()
    np.testing.assert_array_equal(voxel_map.values(box), dense(plain.voxels, box))
    assert_sure_rows_are_true(voxel_map)


def test_most_of_a_hold_is_surely_free_after_some_clouds():
    voxel_map = mapped([puck_in_hold((12.0 + 0.1 * k, 9.0, 4.0), k, columns=450) for k in range(12)])
    assert assert_sure_rows_are_true(voxel_map) > 100_000
    assert_sure_rows_are_true(voxel_map.copy())


def assert_sure_rows_are_true(voxel_map):
    """A bit says that a voxel has the least log-odds, and every such voxel has it. Return their number."""
    pool = voxel_map.pool
    bits = np.unpackbits(pool.sure_rows.view(np.uint8), axis=1, bitorder="little")
    np.testing.assert_array_equal(bits, pool.cubes == voxel_map.parameters.model.low)
    return np.count_nonzero(bits)


@given(st.lists(cloud, min_size=1, max_size=4), st.sampled_from([-1.0, 1.5]))
def test_voxels_equal_octomaps(clouds, max_range):
    tree, voxel_map = oracle_of(clouds, max_range), mapped(clouds, max_range_m=max_range)
    box = voxel_map.box()
    leaves = leaves_of_full(body_of(tree.write())) if tree.size() else []
    np.testing.assert_array_equal(voxel_map.values(box), filled(leaves, box))


@pytest.mark.long
def test_clouds_of_a_flight_through_a_hold_give_octomaps_voxels():
    clouds = [puck_in_hold((4.0 + 6.0 * k, 3.0 + 5.0 * k, 2.0 + 2.0 * k), k, columns=450) for k in range(3)]
    tree, voxel_map = oracle_of(clouds), mapped(clouds)
    assert stream_of(voxel_map, is_binary=False).data == body_of(tree.write())


@pytest.mark.table("wall", [1.0, 1.05, 0.95, 1.0 - 1e-7])
def test_a_wall_at_the_maps_edge_stands_when_rays_graze_it(wall):
    along = np.linspace(-2.0, 2.0, 400)
    points = np.column_stack([along, np.full_like(along, wall), np.zeros_like(along)])
    clouds = [((x, wall - 0.3, 0.02), points) for x in (-1.5, 0.0, 1.5)]
    voxel_map = mapped(clouds)
    box = voxel_map.box()
    values = voxel_map.values(box)
    row = int(np.floor(np.float64(np.float32(wall)) * (1.0 / RESOLUTION))) - box.low[1]
    hit = values[-box.low[2], row, -20 - box.low[0] : 20 - box.low[0]]
    assert (hit > 0.0).all()
    assert np.isnan(values[:, row + 1 :]).all()  # nothing behind the wall is known


def test_parameters_of_the_sensor_model_count():
    settings_of = {"hit": 0.6, "miss": 0.45, "least": 0.3, "greatest": 0.8}
    clouds = [((0.0, 0.0, 0.0), [(1.03, 0.02, 0.01)])] * 9
    plain = PlainVolume(RESOLUTION, **settings_of)
    for origin, points in clouds:
        plain.insert(origin, points)
    voxel_map = mapped(clouds, **settings_of)
    box = voxel_map.box()
    np.testing.assert_array_equal(voxel_map.values(box), dense(plain.voxels, box))
    assert np.nanmax(voxel_map.values(box)) == np.float32(np.log(4.0))


def test_points_that_are_not_finite_or_too_far_are_left_out():
    bad = [(np.nan, 0.0, 0.0), (np.inf, 0.0, 0.0), (0.0, 4000.0, 0.0), (0.0, 0.0, -1e30)]
    clouds = [((0.0, 0.0, 0.0), [*bad, (0.55, 0.0, 0.0)])]
    voxel_map = mapped(clouds)
    assert np.count_nonzero(~np.isnan(voxel_map.values(voxel_map.box()))) == 6


def test_a_sensor_outside_of_all_octrees_is_told():
    voxel_map = VoxelMap(VolumeParameters())
    with pytest.raises(MapError, match="check the transforms"):
        voxel_map.rays((1e6, 0.0, 0.0), [(0.0, 0.0, 0.0)])


def test_a_cloud_that_needs_too_much_memory_is_told_and_the_map_stays():
    voxel_map = mapped([((0.0, 0.0, 0.0), [(1.0, 0.0, 0.0)])])
    before = voxel_map.values(voxel_map.box())
    with pytest.raises(MapError, match="max_range"):
        voxel_map.insert(voxel_map.rays((0.0, 0.0, 0.0), [(1500.0, 1500.0, 1500.0)]), Board())
    np.testing.assert_array_equal(voxel_map.values(voxel_map.box()), before)


def test_stamps_say_which_tiles_changed():
    voxel_map, board = VoxelMap(VolumeParameters()), Board()
    near, far = ((0.05, 0.05, 0.05), [(1.0, 0.05, 0.05)]), ((5.0, 5.0, 5.0), [(5.5, 5.0, 5.0)])
    for origin, points in (near, far, near):
        voxel_map.insert(voxel_map.rays(origin, points), board)
    tiles = voxel_map.pool.tiles
    near_tile, far_tile = (
        voxel_map.table[tuple((k - voxel_map.corner)[::-1])] for k in (np.zeros(3, int), np.full(3, 3))
    )
    assert (tiles.written[near_tile], tiles.turned[near_tile]) == (3, 1)
    assert (tiles.written[far_tile], tiles.turned[far_tile]) == (2, 2)


def share_of_floor_kept(miss):
    """Return how much of a floor's strip, 16.9 to 17.9 m ahead, is occupied after a level lidar came by.

    It flies 4.5 m above the floor by 1.4 m. Ranges err by 0.01 m, heights by 0.02 m. Only its lowest ring of
    beams, at -15 deg, meets the strip.
    """
    rng, height_m, down = np.random.default_rng(1), 4.5, np.radians(15.0)
    azimuths, clouds = np.arange(-0.1, 0.1, np.radians(0.2)), []
    for x in np.arange(0.0, 1.4, 0.05):
        directions = np.stack((np.cos(azimuths), np.sin(azimuths), np.full(len(azimuths), -np.tan(down))), 1)
        ranges = height_m / np.sin(down) + rng.normal(0.0, 0.01, len(azimuths))
        origin = np.array((x, 0.0, height_m + rng.normal(0.0, 0.02)))
        clouds.append((origin, origin + ranges[:, None] * np.cos(down) * directions))
    centres = occupied_centres(mapped(clouds, miss=miss))
    inside = centres[(np.abs(centres - (17.4, 0.0, 0.0)) < (0.5, 1.0, 0.1)).all(axis=1)]
    return len(np.unique(inside[:, :2].round(2), axis=0)) / (10 * 20)


def test_a_floor_at_a_flat_angle_stays_with_the_miss_for_level_lidars():
    assert share_of_floor_kept(0.4) < 0.8  # OctoMap's own erases it
    assert share_of_floor_kept(FLAT_MISS) > 0.95
