"""Closed rooms in a row to explore, and bug traps: what leads an explorer to stay, or to end, too early.

The UAV starts at the origin of the world, on the floor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable

import numpy as np

from flights.worlds.drawn.materials import CONCRETE, LINOLEUM, PLASTER, STEEL
from flights.worlds.steel import Opening, Range, box, closed_box, transverse_plate
from flights.worlds.writer import Part, Prop, write_world

DOOR_HEIGHT_M = 1.8, 2.3
BOXES, BOX_M, BOX_HEIGHT_M = (0, 3), (0.4, 1.4), (0.4, 2.2)
STEP_M, BEAM_M = (0.2, 0.6), (0.15, 0.3)
FREE_M = 1.2
"""No box is nearer to the start, or to a wall across the row."""
FREE_HEIGHT_M = 2.6
"""Over the start no beam hangs lower: the UAV takes off to 2 m, and nothing looks up meanwhile."""
WALL_M = 0.15


@dataclass(frozen=True)
class RoomSizes:
    """Least and greatest number of rooms, and their sizes, m. length_m: of each, along the row."""

    rooms: tuple[int, int] = (2, 3)
    length_m: Range = (3.5, 6.0)
    breadth_m: Range = (4.0, 8.0)
    height_m: Range = (3.0, 5.0)
    door_m: Range = (1.2, 1.8)


SMALL = RoomSizes((2, 2), (3.5, 4.5), (3.5, 5.0), (2.8, 3.2), (1.6, 1.8))
"""Explored within half a minute, on a map of 0.2 m."""


@dataclass(frozen=True)
class Rooms:
    """A world and its inner space: low_m, high_m are the corners (x, y, z) of a box around it, m."""

    sdf: str
    low_m: tuple[float, float, float]
    high_m: tuple[float, float, float]


def rooms_world(rng: np.random.Generator, sizes: RoomSizes | None = None) -> Rooms:
    """Draw rooms in a row: one door to the next, boxes, a beam, and floors of different heights."""
    sizes = sizes or RoomSizes()
    lengths_m = rng.uniform(*sizes.length_m, size=rng.integers(*sizes.rooms, endpoint=True))
    breadth_m, height_m = rng.uniform(*sizes.breadth_m), rng.uniform(*sizes.height_m)
    length_m = float(lengths_m.sum())
    edges_m = np.concatenate(([0.0], np.cumsum(lengths_m))) - length_m / 2
    shell = closed_box((length_m, breadth_m, height_m), WALL_M, PLASTER)
    parts: list[Part] = []
    for number, (low, high) in enumerate(zip(edges_m.tolist(), edges_m[1:].tolist())):
        floor_m = float(rng.uniform(*STEP_M)) if number and rng.random() < 0.5 else 0.0
        if floor_m:
            parts.append(box(f"step_{number}", (low, high), _half(breadth_m), (0.0, floor_m), CONCRETE))
        if number:
            parts += _wall(rng, number, low, (breadth_m, height_m), floor_m, sizes.door_m)
        parts += _furniture(rng, number, (low, high), breadth_m, (floor_m, height_m))
    return _world("rooms", shell, parts, (length_m, breadth_m, height_m), edges_m[0] + lengths_m[0] / 2)


def _wall(
    rng: np.random.Generator,
    number: int,
    x: float,
    size_m: tuple[float, float],
    floor_m: float,
    door_bounds_m: Range,
) -> tuple[Part, ...]:
    """Return a wall with a door that reaches from the higher floor. size_m: breadth and height."""
    breadth_m, height_m = size_m
    door_m, half = float(rng.uniform(*door_bounds_m)), breadth_m / 2
    begin = float(rng.uniform(0.1 - half, half - door_m - 0.1))
    top = min(floor_m + float(rng.uniform(*DOOR_HEIGHT_M)), height_m - 0.1)
    opening = Opening((begin, begin + door_m), (floor_m, top))
    plate = (x - WALL_M / 2, x + WALL_M / 2)
    parts = transverse_plate(f"wall_{number}", plate, (-half, half), (0.0, height_m), (opening,), PLASTER)
    return tuple(part for part in parts if _has_volume(part))


def _furniture(rng: np.random.Generator, number: int, x_m: Range, breadth_m: float, z_m: Range) -> list[Part]:
    parts, half = [], breadth_m / 2
    for k in range(int(rng.integers(*BOXES, endpoint=True))):
        size_x, size_y = rng.uniform(*BOX_M, size=2).tolist()
        x = float(rng.uniform(x_m[0] + FREE_M, max(x_m[0] + FREE_M, x_m[1] - FREE_M - size_x)))
        y = float(rng.uniform(-half, half - size_y))
        top = min(z_m[0] + float(rng.uniform(*BOX_HEIGHT_M)), z_m[1])
        off_x, off_y = (x_m[0] + x_m[1]) / 2 - x, -y  # of the room's middle
        apart_m = math.hypot(off_x - np.clip(off_x, 0.0, size_x), off_y - np.clip(off_y, 0.0, size_y))
        if number or apart_m >= FREE_M:
            parts.append(box(f"box_{number}_{k}", (x, x + size_x), (y, y + size_y), (z_m[0], top), CONCRETE))
    if rng.random() < 0.5:
        side, x = float(rng.uniform(*BEAM_M)), float(rng.uniform(x_m[0] + 0.5, x_m[1] - 0.5))
        z = float(rng.uniform(z_m[0] + 0.6 * (z_m[1] - z_m[0]), z_m[1] - side))
        apart_m = abs((x_m[0] + x_m[1]) / 2 - (x + side / 2)) - side / 2
        if number or apart_m >= FREE_M / 2 or z >= FREE_HEIGHT_M:
            parts.append(box(f"beam_{number}", (x, x + side), (-half, half), (z, z + side), STEEL))
    return parts


def _u_shape(rng: np.random.Generator, size_m: tuple[float, float, float]) -> list[Part]:
    """A U around the start, open towards the near wall only."""
    _, _, top = size_m
    half, back = float(rng.uniform(1.2, 1.6)), float(rng.uniform(2.0, 3.0))
    return [
        box("left", (-2.5, back), (half, half + WALL_M), (0.0, top), CONCRETE),
        box("right", (-2.5, back), (-half - WALL_M, -half), (0.0, top), CONCRETE),
        box("back", (back, back + WALL_M), (-half - WALL_M, half + WALL_M), (0.0, top), CONCRETE),
    ]


def _spiral(rng: np.random.Generator, size_m: tuple[float, float, float]) -> list[Part]:
    """Walls by turns from both sides: the way to the end is a snake."""
    length, breadth, top = size_m
    gap = float(rng.uniform(1.3, 1.6))
    walls = []
    for number, x in enumerate(np.arange(1.6, length / 2 - 1.4, 1.7).tolist()):
        y = (-breadth / 2, breadth / 2 - gap) if number % 2 == 0 else (gap - breadth / 2, breadth / 2)
        walls.append(box(f"wall_{number}", (x, x + WALL_M), y, (0.0, top), CONCRETE))
    return walls


def _cells(rng: np.random.Generator, size_m: tuple[float, float, float]) -> list[Part]:
    """Many pockets that end in a wall, on one side of the room."""
    length, breadth, top = size_m
    deep = float(rng.uniform(1.6, 2.2))
    return [
        box(f"side_{number}", (x, x + WALL_M), (breadth / 2 - deep, breadth / 2), (0.0, top), CONCRETE)
        for number, x in enumerate(np.arange(1.5 - length / 2, length / 2 - 1.0, 1.5).tolist())
    ]


def _shaft(rng: np.random.Generator, size_m: tuple[float, float, float]) -> list[Part]:
    """An upper floor with a hole: the UAV climbs through it."""
    length, breadth, top = size_m
    hole, z = float(rng.uniform(1.4, 1.8)), top / 2
    slab = (z, z + WALL_M)
    x0 = length / 2 - 0.6 - hole
    return [
        box("floor_aft", (-length / 2, x0), (-breadth / 2, breadth / 2), slab, CONCRETE),
        box("floor_fore", (x0 + hole, length / 2), (-breadth / 2, breadth / 2), slab, CONCRETE),
        box("floor_port", (x0, x0 + hole), (hole / 2, breadth / 2), slab, CONCRETE),
        box("floor_starboard", (x0, x0 + hole), (-breadth / 2, -hole / 2), slab, CONCRETE),
    ]


def _under(rng: np.random.Generator, size_m: tuple[float, float, float]) -> list[Part]:
    """A wall that is open below only: the UAV sinks to pass."""
    length, breadth, top = size_m
    x, opening = length / 6, float(rng.uniform(1.2, 1.4))
    return [box("wall", (x, x + WALL_M), (-breadth / 2, breadth / 2), (opening, top), CONCRETE)]


TRAPS: dict[str, Callable[[np.random.Generator, tuple[float, float, float]], list[Part]]] = {
    "u_shape": _u_shape,
    "snake": _spiral,
    "cells": _cells,
    "shaft": _shaft,
    "under": _under,
}
"""What is in a room, by the trap's name."""
TRAP_SIZE_M = {"shaft": (9.0, 5.0, 5.6)}
ANY_TRAP_M = (11.0, 6.0, 3.2)


def trap_world(rng: np.random.Generator, kind: str) -> Rooms:
    """Draw a room with a trap of a kind, of `TRAPS`."""
    size_m = TRAP_SIZE_M.get(kind, ANY_TRAP_M)
    return _world(kind, closed_box(size_m, WALL_M, PLASTER), TRAPS[kind](rng, size_m), size_m, 0.0)


def _world(
    name: str, shell: tuple[Part, ...], parts: list[Part], size_m: tuple[float, float, float], start_x: float
) -> Rooms:
    """Return a world whose start, at an x of the space, is its origin."""
    props = [Prop("shell", -start_x, 0.0, shell)]
    if parts:
        props.append(Prop("inside", -start_x, 0.0, tuple(parts)))
    sdf = write_world(name, f"A place to explore ({name}), drawn at random.", LINOLEUM, tuple(props))
    half_x, half_y = size_m[0] / 2, size_m[1] / 2
    return Rooms(
        sdf,
        (-half_x - start_x - 0.3, -half_y - 0.3, -0.3),
        (half_x - start_x + 0.3, half_y + 0.3, size_m[2] + 0.3),
    )


def _half(breadth_m: float) -> Range:
    return -breadth_m / 2, breadth_m / 2


def _has_volume(part: Part) -> bool:
    size = part.shape
    return all(edge > 1e-6 for edge in vars(size).values())
