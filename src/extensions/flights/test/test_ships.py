"""Given the ships of the worlds, their places are named, and every wall lies in an area."""

from pathlib import Path

import numpy as np
import pytest

from inspection.ship.ship_file import read_ship

SHIPS = Path(__file__).resolve().parents[1] / "config/ships"


@pytest.mark.table(
    ("name", "half", "told"),
    [
        ("hold_3d", (15.0, 10.0, 10.0), {(0.3, -9.9, 5.0): "Fr. 60 + 300, strake C, S"}),
        ("hold_3d_cargo", (15.0, 10.0, 10.0), {}),
        ("ballast_tank", (10.0, 1.5, 5.0), {(2.1, 1.5, 2.5): "Fr. 75 + 100, strake B, P"}),
    ],
)
def test_walls_floor_and_deck_of_a_world_lie_in_plates_and_areas(name, half, told):
    ship = read_ship(SHIPS / f"{name}.yaml")
    for place, words in told.items():
        assert ship.describe(place) == words
    x, y, z = half
    across = np.random.default_rng(1).uniform((-x, -y, 0.0), (x, y, z), (600, 3))
    for axis, value in ((0, x), (0, -x), (1, y), (1, -y), (2, 0.0), (2, z)):
        wall = across.copy()
        wall[:, axis] = value
        assert (ship.plates_of(wall) >= 0).all(), (axis, value)
        assert (ship.areas_of(wall, [None] * len(wall)) >= 0).all(), (axis, value)
