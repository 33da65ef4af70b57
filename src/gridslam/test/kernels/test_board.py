"""Beams counted in one tile, against the board."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gridslam.kernels.board import count_beam, count_in_tile
from gridslam.kernels.tiles import SIDE

TILES = 3
inside = st.floats(1.0, TILES * SIDE - 1.001)
point = st.tuples(inside, inside)


@given(point, point)
def test_a_beam_counts_in_one_tile_what_it_counts_there_on_the_board(lidar, end):
    lidar, end = np.array(lidar), np.array(end)
    board, (crossed, passed) = np.zeros(TILES**2 * SIDE**2, np.uint8), np.zeros((2, TILES**2), bool)
    is_home = count_beam(lidar, end, board, np.ones(TILES**2, bool), crossed, passed, TILES, 0, 0)
    for tile in range(TILES**2):
        part = np.zeros(SIDE**2, np.uint8)
        found = count_in_tile(lidar, end, tile % TILES, tile // TILES, part)
        np.testing.assert_array_equal(part, board[tile * SIDE**2 : (tile + 1) * SIDE**2])
        assert found == (part.any(), is_home)
    assert not passed.any()


@given(point, point, st.lists(st.integers(0, TILES**2 - 1)))
def test_tiles_that_are_not_wanted_are_left_out_and_named(lidar, end, wanted):
    lidar, end = np.array(lidar), np.array(end)
    counts, flags = np.zeros((2, TILES**2 * SIDE**2), np.uint8), np.zeros((2, 2, TILES**2), bool)
    are_wanted = np.isin(np.arange(TILES**2), wanted)
    count_beam(lidar, end, counts[0], np.ones(TILES**2, bool), *flags[0], TILES, 0, 0)
    count_beam(lidar, end, counts[1], are_wanted, *flags[1], TILES, 0, 0)
    whole, part = counts.reshape(2, TILES**2, SIDE**2)
    np.testing.assert_array_equal(part[are_wanted], whole[are_wanted])
    assert not (part.any(axis=1) & ~flags[1, 0]).any()
    np.testing.assert_array_equal(flags[1].any(axis=0) & ~are_wanted, flags[0, 0] & ~are_wanted)
