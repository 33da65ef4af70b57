"""Which border may open a way for the UAV: a room of voxels with holes in its walls."""

import numpy as np
import pytest

from exploration.next_view.unknown_room import is_near_room
from exploration.planning import FREE, OCCUPIED, UNKNOWN, Limits, PlannerParameters
from exploration.planning.kernels.distances import squared_clearances
from exploration.planning.space import Space
from exploration.planning.voxel_grid import VoxelGrid

SIDE_M = 0.2
PARAMETERS = PlannerParameters(radius=0.35, margin=0.15, comfort=0.0)


def space_of(kinds):
    grid = VoxelGrid(SIDE_M, 8)
    grid.kinds = kinds
    squares = squared_clearances(np.pad(kinds, 4) != FREE, 4)[4:-4, 4:-4, 4:-4]
    return Space.of(grid, squares, PARAMETERS, Limits(), (), 0.0)


def walled():
    """A free room of 20 x 20 x 20 voxels with walls of one voxel, in unknown."""
    kinds = np.full((40, 40, 40), UNKNOWN, np.uint8)
    kinds[9:31, 9:31, 9:31] = OCCUPIED
    kinds[10:30, 10:30, 10:30] = FREE
    return kinds


def near(kinds, least_m3=0.5, known=0):
    space = space_of(kinds)
    space.grid.known = known
    return is_near_room(space, np.array([[20, 20, 20]]), least_m3)


def test_a_closed_room_has_no_way_out():
    assert not near(walled()).any()


def test_a_hole_of_unknown_that_the_uav_fits_through_counts():
    kinds = walled()
    kinds[16:24, 16:24, 30] = UNKNOWN
    found = near(kinds)
    assert found[18:22, 18:22, 30].all()
    assert not found[:, :, :20].any()


def test_a_small_hole_does_not_count_even_if_room_lies_behind():
    """The great hole in one wall leads outside, and so behind the small hole in the other wall, too."""
    kinds = walled()
    kinds[16:24, 16:24, 30] = UNKNOWN
    kinds[20:22, 20:22, 9] = UNKNOWN
    found = near(kinds)
    assert found[18:22, 18:22, 30].all()
    assert not found[20:22, 20:22, 9].any()


def test_what_is_unknown_beside_a_door_counts_if_room_lies_behind():
    """The UAV's centre passes only free voxels, but not clear of what is unknown."""
    kinds = walled()
    kinds[16:24, 16:24, 30] = UNKNOWN
    kinds[18:22, 18:22, 30:39] = FREE
    found = near(kinds)
    assert found[17, 17:23, 30].all()


@pytest.mark.table(("least_m3", "counts"), [(0.5, True), (1000.0, False)])
def test_small_pieces_of_room_do_not_count(least_m3, counts):
    kinds = walled()
    kinds[16:24, 16:24, 30] = UNKNOWN
    assert near(kinds, least_m3).any() == counts


@pytest.mark.table(("high", "known_m3", "counts"), [(8, 641.0, False), (8, 639.0, True), (12, 1e5, True)])
def test_niches_of_a_large_place_do_not_count_while_all_of_them_are_a_thousandth(high, known_m3, counts):
    """The UAV's centre keeps 2 voxels to each side: in a niche of 8 x 8 it has room of 4 x 4 x 5, 0.64 m3.

    In one that is 12 high it has 1.28 m3, which always counts.
    """
    kinds = walled()
    kinds[10:30, 10:30, 31:] = OCCUPIED
    kinds[12 : 12 + high, 12:20, 30:37] = UNKNOWN
    assert near(kinds, 0.5, round(known_m3 / SIDE_M**3)).any() == counts
    assert near(kinds, 0.0, round(known_m3 / SIDE_M**3)).any()  # so asked, all room counts
