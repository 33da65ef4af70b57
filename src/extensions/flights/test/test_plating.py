"""Wide planes of a map are plating; strips and rods are structure."""

import numpy as np
import pytest

from flights.photographing.plating import is_plating

SIDE_M = 0.1


def rectangle(origin_m, first, second, size_m):
    """Quads (n, 4, 3) of SIDE_M on a rectangle."""
    steps = [np.arange(round(size / SIDE_M)) * SIDE_M for size in size_m]
    u, v = (each.ravel() for each in np.meshgrid(*steps, indexing="ij"))
    corners = []
    for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
        along = (u + du * SIDE_M)[:, None] * np.array(first) + (v + dv * SIDE_M)[:, None] * np.array(second)
        corners.append(np.array(origin_m) + along)
    return np.stack(corners, axis=1)


def told(*rectangles):
    """The share of each rectangle that is plating."""
    faces_m = np.concatenate(rectangles)
    wide = is_plating(faces_m.reshape(-1, 3), np.arange(4 * len(faces_m)).reshape(-1, 4))
    ends = np.cumsum([len(each) for each in rectangles])
    return [part.mean() for part in np.split(wide, ends[:-1])]


@pytest.mark.table("turn_deg", [0.0, 17.0])
def test_a_wall_is_plating_and_its_webs_a_beam_and_a_stanchion_are_structure(turn_deg):
    x, y, z = np.eye(3)
    wall = rectangle((0, 0, 0), y, z, (6.0, 4.0))
    webs = [rectangle((0, at, 0), x, z, (0.3, 4.0)) for at in (1.5, 3.0, 4.5)]
    beam = rectangle((0, 0, 3.5), x, y, (0.5, 6.0))
    stanchion = rectangle((3.0, 3.0, 0), y, z, (0.2, 4.0))
    turn = np.radians(turn_deg)
    turned = np.array(((np.cos(turn), -np.sin(turn), 0), (np.sin(turn), np.cos(turn), 0), (0, 0, 1)))
    parts = [each @ turned.T for each in (wall, *webs, beam, stanchion)]
    shares = told(*parts)
    assert shares[0] > 0.95
    assert max(shares[1:]) == 0.0


def test_of_a_surface_of_1_m2_in_the_open_nothing_is_plating_and_of_a_wide_one_all_but_corners():
    x, y, _ = np.eye(3)
    # A disc of 1 m has 3.14 m2, of which plating fills 40 %. At a corner, a quarter of it is on the plate.
    small, wide = rectangle((0, 0, 0), x, y, (1.0, 1.0)), rectangle((9, 0, 0), x, y, (5.0, 5.0))
    shares = told(small, wide)
    assert shares[0] == 0.0
    assert 0.9 < shares[1] < 1.0
