"""The map that the filter draws: its best particle's, and no more of it than has changed."""

from __future__ import annotations

import numpy as np
import plain_filter as reference
import pytest
import rooms
from plain_maps import plain_of


@pytest.fixture(scope="module")
def log():
    return rooms.log()


def test_the_drawing_is_the_best_particles_map_and_only_changes_are_drawn(log):
    slam = rooms.begin(log)
    rooms.run(slam, log, 0, 90)
    grid = slam.grid()
    plain = reference.render(plain_of(slam._map.tiles, slam.best_particle), slam.parameters.occ_thresh)
    row, column = (
        np.round(np.array(grid.origin_xy_m[::-1]) / 0.05).astype(int) - slam._map.tiles.corner[::-1] * 32
    )
    height, width = grid.cells.shape
    np.testing.assert_array_equal(grid.cells, plain[row : row + height, column : column + width])
    assert (plain != -1).sum() == (grid.cells != -1).sum()
    # nothing has changed since
    slam.grid()
    assert slam._map._renderer.drawn == 0
    # what a later drawing shows is what a renderer that begins then shows, and the earlier map stays
    rooms.run(slam, log, 90)
    earlier, later = grid.cells.copy(), slam.grid()
    assert slam._map._renderer.drawn > 0
    np.testing.assert_array_equal(grid.cells, earlier)
    fresh = type(slam._map._renderer)(slam.parameters).render(slam._map.tiles, slam.best_particle)
    np.testing.assert_array_equal(later.cells, fresh.cells)


def test_the_map_covers_the_box_that_is_asked_for(log):
    slam = rooms.begin(log, xmin=-6.0, ymin=-5.0, xmax=10.0, ymax=4.5)
    rooms.run(slam, log, 0, 5)
    grid = slam.grid()
    low, high = np.array(grid.origin_xy_m), np.add(grid.origin_xy_m, grid.size_m)
    assert (low <= (-6.0, -5.0)).all()
    assert (high >= (10.0 - 1e-9, 4.5 - 1e-9)).all()
