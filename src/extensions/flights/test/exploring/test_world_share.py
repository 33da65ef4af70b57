"""Rooms in closed form: how much of them a map knows, also of the room behind a narrow opening."""

import numpy as np
import pytest
import trimesh

from flights.exploring.summary import rows_of
from flights.exploring.world_share import share_of_world
from gridslam.evaluation.volume.surface import Surface

SIDE_M, BEGIN_M = 0.2, np.array((1.0, 1.5, 1.0))
WALL_X_M, THICK_M, END_M = 3.0, 0.1, (6.1, 3.0, 2.0)
"""Two rooms of 3 x 3 x 2 m beside each other, of 18 m3 each, and a wall between."""


def two_rooms(hole_m=0.8, shell=True):
    """A shell around both, and a wall with an opening from y = 1 on, z from 0.6 to 1.6 m."""
    y, t = 1.0 + hole_m, (WALL_X_M, WALL_X_M + THICK_M)
    parts = [
        ((t[0], 0.0, 0.0), (t[1], 1.0, 2.0)),
        ((t[0], y, 0.0), (t[1], 3.0, 2.0)),
        ((t[0], 1.0, 0.0), (t[1], y, 0.6)),
        ((t[0], 1.0, 1.6), (t[1], y, 2.0)),
        *([((0.0, 0.0, 0.0), END_M)] if shell else []),
    ]
    corners = [np.array(trimesh.creation.box(bounds=part).triangles) for part in parts]
    return Surface(np.concatenate(corners), ("tank",), np.zeros(12 * len(parts), int))


def map_to(x_m):
    """The centres of all voxels from x = 0 to here."""
    shape = np.round(np.array((x_m, END_M[1], END_M[2])) / SIDE_M).astype(int)
    return (np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), -1).reshape(-1, 3) + 0.5) * SIDE_M


def share(known_m, surface, begin_m=BEGIN_M):
    return share_of_world(known_m, SIDE_M, surface, begin_m, np.random.default_rng(1))


def test_a_map_of_one_of_two_rooms_knows_half_of_the_world():
    """A voxel of 0.1 m beside each wall belongs to the wall: 2.8 x 2.8 x 1.8 m of each room at least."""
    found = share(map_to(3.0), two_rooms())
    assert found.known_share == pytest.approx(0.5, abs=0.02)
    assert 2 * 2.8 * 2.8 * 1.8 <= found.room_m3 <= 36.0
    assert share(map_to(6.2), two_rooms()).known_share == 1.0


def test_a_crack_joins_no_rooms():
    found = share(map_to(3.0), two_rooms(hole_m=0.1))
    assert found.known_share == pytest.approx(1.0, abs=0.01)
    assert found.room_m3 <= 18.0


def test_an_open_place_and_a_place_in_a_wall_have_no_share():
    assert share(map_to(3.0), two_rooms(shell=False)) is None
    assert share(map_to(3.0), two_rooms(), np.array((3.05, 0.5, 0.5))) is None
    assert share(map_to(3.0), two_rooms(), np.array((50.0, 0.5, 0.5))) is None


def test_the_headline_says_of_what_99_per_cent_are_and_what_the_world_has():
    told = {"end": "explored", "unknown": [], "time_99_s": 20.0, "known_m3": 18.0}
    told |= {"is_home": True, "home_s": 30.0, "views": 3, "swaps": 0}
    assert rows_of(told)["known on the map"] == "18 m3, free or occupied; 99 % of these 18 m3 after 20 s"
    assert "known of the world" not in rows_of(told)
    world = rows_of({**told, "world": {"room_m3": 36.0, "known_share": 0.5}})["known of the world"]
    assert world.startswith("50 % of the 36 m3 of all rooms")
