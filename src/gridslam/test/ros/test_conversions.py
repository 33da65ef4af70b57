"""From the filter's results to messages, and maps back."""

import io
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gridslam import MapError, OccupancyGrid
from gridslam.trajectory import Trajectory

conversions = pytest.importorskip(
    "gridslam_ros.conversions", reason="the workspace is not built, or not sourced"
)
HEADER = conversions.header_of(12.25, "map")
GRID = OccupancyGrid(np.array([[0, -1, 100], [0, 0, 50]]), 0.05, (-1.5, 2.0))
PATH = Trajectory(
    np.array([1.0, 2.0, 3.5]), np.array([(0.0, 0.0, 0.0), (1.0, 0.5, np.pi / 2), (2.0, 1.0, np.pi)])
)


def over_the_wire(message):
    """The message as a subscriber of the plain type gets it."""
    buffer = io.BytesIO()
    message.serialize_numpy(buffer, np)
    return conversions.GridMessage().deserialize(buffer.getvalue())


def test_a_map():
    message = over_the_wire(conversions.grid_message(GRID, HEADER))
    assert (message.header.frame_id, message.header.stamp.to_sec()) == ("map", 12.25)
    assert (message.info.width, message.info.height) == (3, 2)
    assert (message.info.origin.position.x, message.info.origin.position.y) == (-1.5, 2.0)
    assert message.info.origin.orientation.w == 1.0
    assert message.data == (0, -1, 100, 0, 0, 50)


def test_a_map_comes_back():
    grid = conversions.grid_of(over_the_wire(conversions.grid_message(GRID, HEADER)))
    np.testing.assert_array_equal(grid.cells, GRID.cells)
    assert grid.origin_xy_m == GRID.origin_xy_m
    assert grid.resolution_m == pytest.approx(0.05)


def test_maps_that_make_no_sense():
    message = over_the_wire(conversions.grid_message(GRID, HEADER))
    message.info.width = 4
    with pytest.raises(MapError, match="4 x 2 cells, but holds 6"):
        conversions.grid_of(message)
    message.info.origin.orientation.z = 0.1
    with pytest.raises(MapError, match="turned"):
        conversions.grid_of(message)


def test_a_path():
    path = conversions.path_message(PATH, HEADER)
    assert [pose.header.stamp.to_sec() for pose in path.poses] == [1.0, 2.0, 3.5]
    second = path.poses[1].pose
    assert (second.position.x, second.position.y) == (1.0, 0.5)
    assert (second.orientation.z, second.orientation.w) == pytest.approx((np.sqrt(0.5), np.sqrt(0.5)))


def test_closed_loops_are_lines_between_places_on_the_path():
    closures = [
        SimpleNamespace(stamp_from_s=1.0, stamp_to_s=3.5),
        SimpleNamespace(stamp_from_s=1.0, stamp_to_s=2.0),
    ]
    marker = conversions.closures_message(closures, PATH, HEADER)
    assert marker.type == marker.LINE_LIST
    assert [(point.x, point.y) for point in marker.points] == [(0.0, 0.0), (2.0, 1.0), (0.0, 0.0), (1.0, 0.5)]


def test_path_and_closures_are_at_their_heights_as_far_as_they_are_known():
    risen = replace(PATH, heights_m=np.array([0.5, np.nan, 2.5]))
    path = conversions.path_message(risen, HEADER)
    assert [pose.pose.position.z for pose in path.poses] == [0.5, 0.0, 2.5]
    loop = SimpleNamespace(stamp_from_s=1.0, stamp_to_s=3.5)
    assert [point.z for point in conversions.closures_message([loop], risen, HEADER).points] == [0.5, 2.5]
    assert [pose.pose.position.z for pose in conversions.path_message(PATH, HEADER).poses] == [0.0] * 3


def test_no_loops_no_lines():
    empty = Trajectory(np.zeros(0), np.zeros((0, 3)))
    marker = conversions.closures_message([], empty, HEADER)
    assert (marker.action, marker.points) == (marker.DELETE, [])
