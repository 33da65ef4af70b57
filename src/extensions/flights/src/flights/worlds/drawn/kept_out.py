"""Forests with keep-out boxes beside the straight way, into which a UAV that evades a trunk would fly."""

from __future__ import annotations

import numpy as np

from cepa import KeepOutBox
from flights.worlds.drawn.materials import CLEAR_M

KEEP_OUT = "keep_out"
BOXES, EDGES_M, ASIDE_M, HEIGHT_M = 3, (1.0, 3.0), (0.3, 1.0), 6.0
"""How many boxes, their edges, and how far from the straight way they begin; they stand on the floor."""


def draw_boxes(rng: np.random.Generator, distance_m: float) -> tuple[KeepOutBox, ...]:
    """Return boxes one after the other along the way, on either side of it."""
    boxes, room_m = [], (distance_m - 2.0 * CLEAR_M) / BOXES
    for number in range(BOXES):
        along_m, across_m = rng.uniform(*EDGES_M, 2).tolist()
        x = CLEAR_M + number * room_m + rng.uniform(0.0, max(0.0, room_m - along_m))
        near_m, side = rng.uniform(*ASIDE_M), rng.choice((-1.0, 1.0))
        y = sorted((side * near_m, side * (near_m + across_m)))
        boxes.append(KeepOutBox((x, y[0], 0.0), (x + along_m, y[1], HEIGHT_M), str(number + 1)))
    return tuple(boxes)
