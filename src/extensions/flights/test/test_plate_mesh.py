"""Faces of voxels that lie near plates are found."""

from __future__ import annotations

import numpy as np
import pytest

from flights.photographing.plate_mesh import beside
from gridslam.volume.plates import Plates

SIDE_M = 0.2
"""Of voxels, and of the cells of plates."""


def one_plate():
    square = SIDE_M * np.array(((0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)))
    return Plates((0.7, 0.6, 0.6) + square[None], np.array(((1.0, 0.0, 0.0),)))


@pytest.mark.table("normal", [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
def test_a_face_is_beside_a_plate_however_it_faces(normal):
    one = one_plate()
    along, up = np.eye(3)[[1, 2] if normal[0] else [0, 1]]
    square = 0.1 * np.array((0 * along, along, along + up, up))
    faces_m = np.stack([one.centres_m[0] + 0.05 + square, one.centres_m[0] + 1.0 + square])
    assert beside(one, faces_m, SIDE_M).tolist() == [True, False]
