"""Straight hallways with cabinets along their walls."""

from __future__ import annotations

import numpy as np

from flights.worlds.drawn.materials import CLEAR_M, LINOLEUM, PLASTER, STEEL
from flights.worlds.writer import Box, Part, Prop, write_world

_CABINET_X_M, _CABINET_Y_M, _CABINET_GAP_M = 0.9, 0.4, 3.0
_WALL_M = 0.2


def hallway_sdf(rng: np.random.Generator, width_m: float, distance_m: float) -> str:
    """Return a straight hallway along x, this wide between its walls, with cabinets along them.

    A cabinet takes 0.4 m of the width; the next one, on either side, is 3 m or more farther on.
    """
    length, middle = distance_m + 6.0, distance_m / 2
    offset = (width_m + _WALL_M) / 2
    wall = (Part("wall", Box(length, _WALL_M, 4.0), PLASTER),)
    end = (Part("wall", Box(_WALL_M, width_m, 4.0), PLASTER),)
    props = [Prop("left", middle, offset, wall), Prop("right", middle, -offset, wall)]
    props += [Prop("behind", -3.0, 0.0, end), Prop("ahead", distance_m + 3.0, 0.0, end)]
    cabinet = (Part("cabinet", Box(_CABINET_X_M, _CABINET_Y_M, 4.0), STEEL),)
    x = CLEAR_M + rng.uniform(0.0, _CABINET_GAP_M)
    while x < distance_m - CLEAR_M:
        side = 1.0 if rng.random() < 0.5 else -1.0
        props.append(Prop(f"cabinet_{len(props)}", x, side * (width_m - _CABINET_Y_M) / 2, cabinet))
        x += _CABINET_GAP_M + rng.uniform(0.0, _CABINET_GAP_M)
    comment = f"A hallway {width_m:g} m wide, its cabinets drawn at random."
    return write_world("random_hallway", comment, LINOLEUM, tuple(props))
