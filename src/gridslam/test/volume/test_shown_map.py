"""What a map shows, and the layers for planners, against dense arrays and scipy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_volume import filled, leaves_of_binary
from scipy import ndimage

from gridslam import ParameterError
from gridslam.volume import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    Box,
    CorrectedMap,
    DistanceField,
    Frontiers,
    NodeSpacing,
    Pose,
    Rebuilding,
    ShownMap,
    VolumeParameters,
)

RESOLUTION = 0.2
ONLY_FIRST = NodeSpacing(1e9, 1e9, 1e9)
coordinate = st.floats(-5.0, 5.0, width=32)
point = st.tuples(coordinate, coordinate, coordinate)
clouds = st.lists(st.tuples(point, st.lists(point, min_size=1, max_size=12)), min_size=1, max_size=5)


def at(position):
    return Pose(np.eye(3), np.array(position, float))


def kinds(values):
    return np.where(np.isnan(values), UNKNOWN, np.where(values >= 0.0, OCCUPIED, FREE))


@settings(max_examples=12)
@given(clouds)
def test_layers_kept_up_to_date_equal_dense_ones(given_clouds):
    """Also after each cloud, and after a correction, not only when all is computed at once."""
    corrected = CorrectedMap(VolumeParameters(resolution_m=RESOLUTION), NodeSpacing(period_s=1e-9))
    shown, distances, frontiers = ShownMap(RESOLUTION), DistanceField(RESOLUTION, 1.0), Frontiers(RESOLUTION)
    for number, (origin, points) in enumerate(given_clouds):
        corrected.add(10.0 * number, np.array(points), at(origin), Pose.identity())
        follow(corrected, shown, distances, frontiers)
    Rebuilding(corrected, [at((1.0, 0.5, 0.0)) @ node.sensor_in_map for node in corrected.nodes]).take_over()
    follow(corrected, shown, distances, frontiers)


def follow(corrected, shown, distances, frontiers):
    changed = shown.refresh(corrected)
    distances.update(shown, changed)
    frontiers.update(shown, changed)
    low, high = corrected.voxels.box()
    box, wide = Box(low, high), Box(low - 16, high + 16)
    corrected.transient.forget()  # then only the map is shown
    changed = shown.refresh(corrected)
    distances.update(shown, changed)
    frontiers.update(shown, changed)
    expected = kinds(corrected.voxels.values(wide))
    np.testing.assert_array_equal(shown.dense(wide), expected)
    is_full = expected == OCCUPIED
    far = np.full(is_full.shape, np.inf)
    exact = ndimage.distance_transform_edt(~is_full) if is_full.any() else far
    inside = (slice(16, -16),) * 3
    has_tile = np.kron(tiles_in(corrected, box), np.ones((16, 16, 16), bool))
    np.testing.assert_allclose(
        distances.distances_m(box)[has_tile], np.minimum(exact * RESOLUTION, 1.0)[inside][has_tile], rtol=1e-6
    )
    beside = ndimage.binary_dilation(expected == UNKNOWN, ndimage.generate_binary_structure(3, 1))
    z, y, x = np.nonzero((expected == FREE) & beside)
    centres = (np.stack((x, y, z), axis=1) + wide.low + 0.5) * RESOLUTION
    np.testing.assert_allclose(in_order(frontiers.centres()), in_order(centres.astype(np.float32)))
    beside = ndimage.binary_dilation(expected == FREE, ndimage.generate_binary_structure(3, 1))
    z, y, x = np.nonzero((expected == UNKNOWN) & beside)
    centres = (np.stack((x, y, z), axis=1) + wide.low + 0.5) * RESOLUTION
    unknown = frontiers.unknown_centres(shown)
    np.testing.assert_allclose(in_order(unknown), in_order(centres.astype(np.float32)))


def tiles_in(corrected, box):
    voxels = corrected.voxels
    low, high = (np.asarray(edge) // 16 - voxels.corner for edge in box)
    return voxels.table[low[2] : high[2], low[1] : high[1], low[0] : high[0]] > 0


def in_order(points):
    return points[np.lexsort(points.T)]


def test_the_binary_octree_holds_what_is_shown():
    corrected, shown = CorrectedMap(VolumeParameters(resolution_m=RESOLUTION)), ShownMap(RESOLUTION)
    corrected.add(0.0, np.array([(2.0, 1.0, 0.5), (-3.0, 2.0, 1.0)]), at((0.1, 0.1, 0.1)), Pose.identity())
    shown.refresh(corrected)
    box = corrected.voxels.box()
    read = filled(leaves_of_binary(shown.octree().data), box)
    np.testing.assert_array_equal(
        np.where(np.isnan(read), UNKNOWN, np.where(read > 0, OCCUPIED, FREE)), shown.dense(box)
    )
    np.testing.assert_allclose(
        in_order(shown.centres(OCCUPIED)), in_order(np.array([(2.1, 1.1, 0.7), (-2.9, 2.1, 1.1)])), atol=1e-6
    )


DOOR, BEHIND = np.array([(2.1, 0.1, 0.1)]), np.array([(4.1, 0.1, 0.1)])


def kind_at_door(corrected, shown):
    shown.refresh(corrected)
    voxel = np.array((10, 0, 0))
    return shown.dense(Box(voxel, voxel + 1))[0, 0, 0]


def test_a_door_seen_closed_is_free_five_clouds_after_it_opens():
    """Given a door that ten kept clouds have seen closed, when clouds between nodes see through it..."""
    corrected = CorrectedMap(VolumeParameters(resolution_m=RESOLUTION), NodeSpacing(1e9, 1e9, 1.0))
    shown = ShownMap(RESOLUTION)
    for second in range(10):
        corrected.add(float(second), DOOR - 0.1, at((0.1, 0.1, 0.1)), Pose.identity())
    assert kind_at_door(corrected, shown) == OCCUPIED
    found = []
    for tick in range(1, 8):
        corrected.add(9.0 + 2.5 + 0.05 * tick, BEHIND - 0.1, at((0.1, 0.1, 0.1)), Pose.identity())
        found.append(kind_at_door(corrected, shown))
    assert found == [OCCUPIED] * 4 + [FREE] * 3


def test_what_appears_between_nodes_is_shown_at_once_and_forgotten():
    corrected = CorrectedMap(VolumeParameters(resolution_m=RESOLUTION), ONLY_FIRST)
    shown = ShownMap(RESOLUTION)
    corrected.add(0.0, BEHIND - 0.1, at((0.1, 0.1, 0.1)), Pose.identity())
    assert kind_at_door(corrected, shown) == FREE
    corrected.add(5.0, DOOR - 0.1, at((0.1, 0.1, 0.1)), Pose.identity())
    assert kind_at_door(corrected, shown) == OCCUPIED
    for stamp in (6.5, 8.0):  # two seconds later, from where the door is not seen
        corrected.add(stamp, BEHIND - 0.1, at((0.1, 5.1, 0.1)), Pose.identity())
    assert kind_at_door(corrected, shown) == FREE


def test_a_map_that_begins_anew_shows_nothing():
    corrected, shown = CorrectedMap(VolumeParameters(resolution_m=RESOLUTION)), ShownMap(RESOLUTION)
    corrected.add(0.0, DOOR, at((0.1, 0.1, 0.1)), Pose.identity())
    assert len(shown.refresh(corrected))
    corrected.reset()
    assert len(shown.refresh(corrected))
    assert not len(shown.centres(FREE))
    assert not len(shown.refresh(corrected))


def test_distances_that_do_not_fit_are_told():
    with pytest.raises(ParameterError, match="voxels"):
        DistanceField(0.01, 3.0)
