"""An open field with dead ends on the straight way: U-shapes and cul-de-sacs, open towards the UAV."""

from __future__ import annotations

import numpy as np

from flights.worlds.drawn.materials import CLEAR_M, CONCRETE, GRASS
from flights.worlds.writer import Box, Part, Prop, write_world

DEPTHS_M, GAPS_M = (3.0, 8.0), (3.0, 5.0)
WIDTHS_M = {"u_shape": (4.0, 7.0), "cul_de_sac": (2.0, 3.0)}
"""Between the side walls' faces. A UAV can turn in the one; the other is hardly wider than the UAV's ways."""
TURN_MAX_RAD, DEEP_TURN_MAX_RAD = 0.25, 0.05
"""A deep one that is turned farther does not have the straight way in it."""
_WALL_M, _HEIGHT_M = 0.2, 4.0


def dead_ends_sdf(rng: np.random.Generator, distance_m: float) -> str:
    """Return a field in which the straight way leads from one dead end into the next."""
    props: list[Prop] = []
    mouth_x = CLEAR_M + rng.uniform(0.0, 2.0)
    while True:
        kind = "u_shape" if rng.random() < 0.5 else "cul_de_sac"
        depth_m, width_m = rng.uniform(*DEPTHS_M), rng.uniform(*WIDTHS_M[kind])
        yaw_rad = rng.uniform(-TURN_MAX_RAD, TURN_MAX_RAD)
        y = rng.uniform(-0.25, 0.25) * width_m
        if mouth_x + depth_m > distance_m - CLEAR_M - 1.0:
            break
        middle_x = mouth_x + depth_m / 2
        props.append(Prop(f"{kind}_{len(props)}", middle_x, y, _walls(depth_m, width_m), yaw_rad))
        mouth_x += depth_m + rng.uniform(*GAPS_M)
    return write_world("dead_ends", "Dead ends drawn at random.", GRASS, tuple(props))


def deep_dead_end_sdf(rng: np.random.Generator, depth_m: float) -> str:
    """Return a field in which the straight way leads into one dead end of this depth."""
    kind = "u_shape" if rng.random() < 0.5 else "cul_de_sac"
    width_m, yaw_rad = rng.uniform(*WIDTHS_M[kind]), rng.uniform(-DEEP_TURN_MAX_RAD, DEEP_TURN_MAX_RAD)
    middle_x, y = CLEAR_M + rng.uniform(0.0, 2.0) + depth_m / 2, rng.uniform(-0.25, 0.25) * width_m
    prop = Prop(kind, middle_x, y, _walls(depth_m, width_m), yaw_rad)
    return write_world("deep_dead_end", "A deep dead end drawn at random.", GRASS, (prop,))


def _walls(depth_m: float, width_m: float) -> tuple[Part, ...]:
    side, back = Box(depth_m, _WALL_M, _HEIGHT_M), Box(_WALL_M, width_m + 2 * _WALL_M, _HEIGHT_M)
    offset, middle_z = (width_m + _WALL_M) / 2, _HEIGHT_M / 2
    return (
        Part("left", side, CONCRETE, (0.0, offset, middle_z)),
        Part("right", side, CONCRETE, (0.0, -offset, middle_z)),
        Part("back", back, CONCRETE, ((depth_m + _WALL_M) / 2, 0.0, middle_z)),
    )
