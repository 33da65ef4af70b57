"""Plates over the bars of a drawn ladder are told apart from those of a web."""

from __future__ import annotations

import numpy as np
import pytest

from gridslam.volume.plates import Plates
from master_thesis.photographing.map_mesh import FREE, OCCUPIED
from master_thesis.photographing.plate_mesh import Kinds, are_bars, beside

SIDE_M = 0.2
"""Of voxels, and of the cells of plates."""
ROWS, COLUMNS = 20, 3


def drawn(*rungs):
    """Voxels (x, y, z) of an upright, one thick: two rails from bottom to top, and rungs in these rows."""
    kinds = np.full((7, COLUMNS + 6, ROWS + 6), FREE, np.int8)
    kinds[3, [3, 5], 3:-3] = OCCUPIED
    kinds[3, 4, np.add(rungs, 3)] = OCCUPIED
    return Kinds(kinds, np.zeros(3), SIDE_M)


def plates_over_all():
    """A plate for each of its voxels, also where one sees through."""
    low = np.array(
        [(0.7, SIDE_M * (3 + column), SIDE_M * (3 + row)) for column in range(COLUMNS) for row in range(ROWS)]
    )
    square = SIDE_M * np.array(((0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)))
    return Plates(low[:, None] + square, np.tile((1.0, 0.0, 0.0), (len(low), 1)))


def points_on(kinds):
    """Nine points on each occupied voxel, where the plates are."""
    voxels = np.argwhere(kinds.values == OCCUPIED)
    offsets = [(0.7 - SIDE_M * 3, u, v) for u in (0.03, 0.1, 0.17) for v in (0.03, 0.1, 0.17)]
    return (SIDE_M * voxels[:, None] + np.array(offsets)).reshape(-1, 3)


LADDER = drawn(*range(0, ROWS, 2))


def test_plates_of_a_ladder_are_bars():
    assert are_bars(plates_over_all(), LADDER, FREE, points_on(LADDER)).all()


def test_those_of_a_whole_web_are_none():
    web = drawn(*range(ROWS))
    assert not are_bars(plates_over_all(), web, FREE, points_on(web)).any()


def test_a_web_that_flat_rays_have_erased_is_no_ladder_as_long_as_clouds_show_it():
    assert not are_bars(plates_over_all(), LADDER, FREE, points_on(drawn(*range(ROWS)))).any()


def test_before_a_wall_one_sees_nothing_through():
    kinds = LADDER.values.copy()
    kinds[2] = OCCUPIED
    assert not are_bars(plates_over_all(), Kinds(kinds, LADDER.low_m, SIDE_M), FREE, points_on(LADDER)).any()


@pytest.mark.parametrize("normal", [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
def test_a_face_is_beside_a_plate_however_it_faces(normal):
    one = plates_over_all().only(np.arange(1))
    along, up = np.eye(3)[[1, 2] if normal[0] else [0, 1]]
    square = 0.1 * np.array((0 * along, along, along + up, up))
    faces_m = np.stack([one.centres_m[0] + 0.05 + square, one.centres_m[0] + 1.0 + square])
    assert beside(one, faces_m, SIDE_M).tolist() == [True, False]
