"""A filter that begins with a given map, to extend it or only to find its way on it."""

from __future__ import annotations

import numpy as np
import pytest
import rooms

from gridslam import GridSlam, MapError, OccupancyGrid, ParameterError, SlamParameters


@pytest.fixture(scope="module")
def log():
    return rooms.log()


def test_a_starting_map_grows(log):
    # given the lower half of the room, on cells that are shifted against the filter's own
    first = rooms.begin(log)
    rooms.run(first, log)
    whole = first.grid()
    half = OccupancyGrid(whole.cells[:60], 0.05, np.add(whole.origin_xy_m, (0.013, -0.021)))
    # when it is flown through
    slam = rooms.begin(log, starting_map=half)
    rooms.run(slam, log)
    # then the other half has been added, and all is shifted as the given half is
    path = slam.trajectory()
    truth = log.truth.poses_in_map[np.searchsorted(log.truth.stamps_s, path.stamps_s)] + (0.013, -0.021, 0.0)
    distances = np.hypot(*(path.poses_in_map - truth)[:, :2].T)
    assert np.sqrt(np.mean(distances**2)) <= 2.0 * rooms.RMSE_MAX_M  # that of the given map, and its own
    assert (slam.grid().cells == 0).sum() > 1.5 * (half.cells == 0).sum()


def test_a_starting_map_of_other_cells_is_refused():
    grid = OccupancyGrid(np.zeros((3, 3), np.int8), 0.1, (0.0, 0.0))
    with pytest.raises(MapError, match="set delta to that"):
        GridSlam(SlamParameters(), starting_map=grid)
    with pytest.raises(ParameterError, match="needs a starting map"):
        GridSlam(SlamParameters(), localisation_only=True)
