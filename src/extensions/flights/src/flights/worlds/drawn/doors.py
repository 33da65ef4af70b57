"""A hallway that walls part into rooms, one after the other; each wall has one door."""

from __future__ import annotations

import numpy as np

from flights.worlds.drawn.materials import CLEAR_M, LINOLEUM, PLASTER
from flights.worlds.writer import Box, Part, Prop, write_world

HALLWAY_M = 6.0
ROOMS_M = 4.0, 7.0
_WALL_M, _HEIGHT_M, _JAMB_M, _BEYOND_M = 0.12, 4.0, 0.4, 3.0


def doors_sdf(rng: np.random.Generator, door_m: float, distance_m: float) -> str:
    """Return a hallway along x whose rooms are joined by doors this wide, anywhere in their walls."""
    half_m, length_m = HALLWAY_M / 2, distance_m + 2 * _BEYOND_M
    side = (Part("wall", Box(length_m, _WALL_M, _HEIGHT_M), PLASTER),)
    end = (Part("wall", Box(_WALL_M, HALLWAY_M, _HEIGHT_M), PLASTER),)
    offset_m = half_m + _WALL_M / 2
    props = [Prop("left", distance_m / 2, offset_m, side), Prop("right", distance_m / 2, -offset_m, side)]
    props += [Prop("behind", -_BEYOND_M, 0.0, end), Prop("ahead", distance_m + _BEYOND_M, 0.0, end)]
    x = CLEAR_M + rng.uniform(0.0, 2.0)
    while x < distance_m - CLEAR_M:
        begin = rng.uniform(_JAMB_M - half_m, half_m - _JAMB_M - door_m)
        for name, low, high in (("right", -half_m, begin), ("left", begin + door_m, half_m)):
            piece = (Part("wall", Box(_WALL_M, high - low, _HEIGHT_M), PLASTER),)
            props.append(Prop(f"{name}_of_door_{len(props)}", x, (low + high) / 2, piece))
        x += rng.uniform(*ROOMS_M)
    comment = f"Rooms one after the other, with doors of {door_m:g} m drawn at random."
    return write_world("doors", comment, LINOLEUM, tuple(props))
