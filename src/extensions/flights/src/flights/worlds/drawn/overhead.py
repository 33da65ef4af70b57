"""What a horizontal lidar misses: beams, overhangs, low walls, cables and ladders across a wide hallway.

The hallway is too high for the UAV to leave it and its obstacles reach from wall to wall, but a ladder does
not. So the goal is reached over or under each obstacle.
"""

from __future__ import annotations

from typing import Callable

import numpy as np

from flights.worlds.drawn.materials import CLEAR_M, CONCRETE, LINOLEUM, PLASTER, RUBBER, STEEL
from flights.worlds.writer import Box, Cylinder, Part, Prop, write_world

HALF_WIDTH_M, HEIGHT_M = 4.0, 6.0
GAPS_M = (5.0, 7.0)
BEAM_OFFSET_M = 0.2
"""A beam's middle is so far above or below the flight."""
CABLE_RADIUS_M = 0.01
_WALL_M, _LADDER_M, _RUNG_GAP_M = 0.2, 0.4, 0.3


def _beam(rng: np.random.Generator, height_m: float) -> tuple[Part, ...]:
    side = rng.uniform(0.1, 0.3)
    z = height_m + (BEAM_OFFSET_M if rng.random() < 0.5 else -BEAM_OFFSET_M)
    return (Part("beam", Box(side, 2 * HALF_WIDTH_M, side), STEEL, (0.0, 0.0, z)),)


def _overhang(rng: np.random.Generator, height_m: float) -> tuple[Part, ...]:
    """Hang something from above, which ends up to 0.3 m below or above the flight."""
    bottom_m, along_m = height_m + rng.uniform(-0.3, 0.3), rng.uniform(0.3, 2.0)
    slab = Box(along_m, 2 * HALF_WIDTH_M, HEIGHT_M - bottom_m)
    return (Part("slab", slab, CONCRETE, (0.0, 0.0, (bottom_m + HEIGHT_M) / 2)),)


def _low_wall(rng: np.random.Generator, height_m: float) -> tuple[Part, ...]:
    top_m = height_m + rng.uniform(-0.3, 0.3)
    return (Part("wall", Box(rng.uniform(0.15, 0.5), 2 * HALF_WIDTH_M, top_m), CONCRETE),)


def _cable(rng: np.random.Generator, height_m: float) -> tuple[Part, ...]:
    z = height_m + rng.uniform(-0.15, 0.15)
    edge = 2 * CABLE_RADIUS_M
    return (Part("cable", Box(edge, 2 * HALF_WIDTH_M, edge), RUBBER, (0.0, 0.0, z)),)


def _ladder(rng: np.random.Generator, height_m: float) -> tuple[Part, ...]:
    """Put up a ladder near the straight way, its rungs across it."""
    y, top_m = rng.uniform(-0.4, 0.4), height_m + rng.uniform(0.3, 1.0)
    post, rung = Cylinder(0.03, top_m), Box(0.03, _LADDER_M, 0.03)
    posts = {"left": y + _LADDER_M / 2, "right": y - _LADDER_M / 2}
    heights = np.arange(_RUNG_GAP_M, top_m, _RUNG_GAP_M)
    return (
        *(Part(name, post, STEEL, (0.0, post_y, top_m / 2)) for name, post_y in posts.items()),
        *(Part(f"rung_{number}", rung, STEEL, (0.0, y, z)) for number, z in enumerate(heights)),
    )


OBSTACLES: dict[str, Callable[[np.random.Generator, float], tuple[Part, ...]]] = {
    "beams": _beam,
    "overhangs": _overhang,
    "low_walls": _low_wall,
    "cables": _cable,
    "ladders": _ladder,
}
"""What makes an obstacle for a flight at a height, by the world's name."""


def overhead_sdf(rng: np.random.Generator, kind: str, distance_m: float, height_m: float) -> str:
    """Return a hallway with obstacles of one kind (of `OBSTACLES`) for a flight at this height."""
    offset = HALF_WIDTH_M + _WALL_M / 2
    wall = (Part("wall", Box(distance_m + 2 * CLEAR_M, _WALL_M, HEIGHT_M), PLASTER),)
    end = (Part("wall", Box(_WALL_M, 2 * HALF_WIDTH_M, HEIGHT_M), PLASTER),)
    props = [Prop(name, distance_m / 2, side * offset, wall) for name, side in (("left", 1), ("right", -1))]
    props += [Prop("behind", -CLEAR_M, 0.0, end), Prop("ahead", distance_m + CLEAR_M, 0.0, end)]
    x = CLEAR_M + rng.uniform(1.0, 3.0)
    while x < distance_m - CLEAR_M - 1.0:
        props.append(Prop(f"obstacle_{len(props)}", x, 0.0, OBSTACLES[kind](rng, height_m)))
        x += rng.uniform(*GAPS_M)
    comment = f"A hallway with {kind.replace('_', ' ')}, drawn at random."
    return write_world(kind, comment, LINOLEUM, tuple(props))
