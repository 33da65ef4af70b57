"""Which faces count as wall: those that can be seen from where the UAV flies."""

import numpy as np
import pytest

from flights.errors import ScenarioError
from flights.worlds.floor_plan import Outline
from flights.worlds.true_walls import inside, seen_faces


def box(x, y, width, depth, top=3.0):
    half = np.array((width, depth)) / 2
    corners = np.array(((-1, -1), (1, -1), (1, 1), (-1, 1))) * half + (x, y)
    return Outline("box", corners, 0.0, top)


ROOM = [box(0, 2.1, 8.4, 0.2), box(0, -2.1, 8.4, 0.2), box(4.1, 0, 0.2, 4.0), box(-4.1, 0, 0.2, 4.0)]


def length(faces):
    return np.linalg.norm(faces[:, 1] - faces[:, 0], axis=1).sum()


def test_of_a_closed_room_the_inner_faces_count():
    faces = seen_faces(ROOM, 2.0, (0.0, 0.0))
    assert length(faces) == pytest.approx(2 * (8.0 + 4.0))
    assert np.all(np.abs(faces.reshape(-1, 2)) <= (4.0 + 1e-9, 2.0 + 1e-9))


def test_from_outside_the_outer_faces_count():
    assert length(seen_faces(ROOM, 2.0, (9.0, 0.0))) == pytest.approx(2 * (8.4 + 4.4))


def test_a_box_s_four_faces_count_and_one_that_it_hides_does_not():
    alone = seen_faces([*ROOM, box(1.0, 0.0, 1.0, 0.5)], 2.0, (0.0, 0.0))
    assert length(alone) == pytest.approx(24.0 + 3.0)
    against = seen_faces([*ROOM, box(1.0, 1.75, 1.0, 0.5)], 2.0, (0.0, 0.0))
    # 0.5 + 1 + 0.5 m of the box in place of 1 m of the wall
    assert length(against) == pytest.approx(24.0 + 1.0)


def test_only_what_stands_at_the_height_counts():
    assert length(seen_faces([*ROOM, box(1.0, 0.0, 1.0, 0.5, top=1.5)], 2.0, (0.0, 0.0))) == pytest.approx(24)


def test_nothing_to_see_and_nowhere_to_stand():
    with pytest.raises(ScenarioError, match="no walls to map"):
        seen_faces(ROOM, 5.0, (0.0, 0.0))
    with pytest.raises(ScenarioError, match=r"A solid stands at \(1, 0\)"):
        seen_faces([*ROOM, box(1.0, 0.0, 1.0, 0.5)], 2.0, (1.0, 0.0))


def test_inside_a_triangle():
    triangle = np.array(((0.0, 0.0), (2.0, 0.0), (0.0, 2.0)))
    points = np.array(((0.5, 0.5), (1.0, 1.0), (1.1, 1.0), (-0.1, 0.5)))
    assert inside(points, triangle).tolist() == [True, True, False, False]
