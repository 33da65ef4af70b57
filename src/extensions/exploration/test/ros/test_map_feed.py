"""The map goes to the planner, filled by what is known before the flight, whenever that comes."""

from types import SimpleNamespace

import numpy as np
import pytest
from exploration_ros.map_feed import MapFeed
from std_msgs.msg import Header

from exploration.planning import FREE, OCCUPIED, UNKNOWN, PathPlanner, PlannerParameters
from flight_basics.errors import FlightBasicsError

SIDE, RESOLUTION_M = 4, 0.2


class Drawing:
    """It knows air in two tiles."""

    def tiles(self, resolution_m, side):
        return np.array([(0, 0, 0), (1, 0, 0)])

    def filled(self, resolution_m, side, tiles, voxels):
        return np.where(voxels == UNKNOWN, FREE, voxels).astype(np.uint8)


def message(seq, tile, kinds):
    voxels = np.full(SIDE**3, UNKNOWN, np.uint8)
    voxels[: len(kinds)] = kinds
    return SimpleNamespace(
        header=Header(seq=seq, frame_id="map"), resolution=RESOLUTION_M, side=SIDE, tiles=list(tile),
        voxels=voxels.tobytes(), unit=0.0,
    )  # fmt: skip


def kinds_of(planner):
    """How many voxels of each kind the planner knows."""
    values = planner._map.grid.kinds
    return {kind: int((values == kind).sum()) for kind in (FREE, OCCUPIED)}


@pytest.fixture
def fed():
    planner = PathPlanner(PlannerParameters())
    return planner, MapFeed(planner, "map", keeps=True)


def test_what_was_seen_before_the_drawing_came_is_kept(fed):
    planner, feed = fed
    feed.take(message(1, (0, 0, 0), [OCCUPIED, FREE]))
    assert kinds_of(planner) == {FREE: 1, OCCUPIED: 1}
    feed.use(Drawing())
    assert planner.has_map
    assert kinds_of(planner) == {FREE: 2 * SIDE**3 - 1, OCCUPIED: 1}
    feed.use(None)
    assert kinds_of(planner) == {FREE: 1, OCCUPIED: 1}


def test_a_map_that_begins_anew_forgets_what_was_seen(fed):
    planner, feed = fed
    feed.use(Drawing())
    assert not planner.has_map  # the size of its voxels is not known yet
    feed.take(message(5, (0, 0, 0), [OCCUPIED]))
    feed.take(message(1, (1, 0, 0), [OCCUPIED, OCCUPIED]))
    assert kinds_of(planner) == {FREE: 2 * SIDE**3 - 2, OCCUPIED: 2}
    feed.use(None)
    assert kinds_of(planner) == {FREE: 0, OCCUPIED: 2}


def test_a_map_of_another_connection_is_another_map_though_its_numbers_go_on(fed):
    planner, feed = fed
    old, new = {"callerid": "/slam_octomap"}, {"callerid": "/slam_octomap"}
    for seq, connection, tile in (
        (1, old, (0, 0, 0)),
        (2, old, (1, 0, 0)),
        (3, new, (2, 0, 0)),
        (4, new, (3, 0, 0)),
    ):
        told = message(seq, tile, [OCCUPIED])
        told._connection_header = connection
        feed.take(told)
    assert kinds_of(planner)[OCCUPIED] == 2


def test_a_map_in_another_frame_is_refused(fed):
    _, feed = fed
    other = message(1, (0, 0, 0), [FREE])
    other.header.frame_id = "odom"
    with pytest.raises(FlightBasicsError, match='"odom"'):
        feed.take(other)
