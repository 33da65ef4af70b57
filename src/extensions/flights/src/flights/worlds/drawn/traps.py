"""An open field with a trap for who only flies towards the goal: a U, a double lip, a spiral, or a gap."""

from __future__ import annotations

from typing import Callable

import numpy as np

from flights.worlds.drawn.materials import CLEAR_M, CONCRETE, GRASS
from flights.worlds.writer import Box, Part, Prop, write_world

BUG_TRAP, U, DOUBLE_LIP, SPIRAL, GAP = "bug_trap", "u", "double_lip", "spiral", "gap"
DEPTHS_M, WIDTHS_M = (4.0, 7.0), (4.0, 8.0)
"""Of a U, and of a room with lips."""
MOUTHS_M, LIPS_M = (1.8, 2.8), (1.0, 2.0)
"""Between two lips, and how far they reach into the room."""
CORRIDORS_M, SPIRAL_SIDES = (2.2, 3.0), (6, 8)
"""Between the turns of a spiral, and how many sides it has."""
GAPS_M, WALLS_M, GAP_ASIDE_M = (0.8, 1.2), (16.0, 30.0), 2.0
"""A gap, the wall that it is in, and how far it is off the straight way."""
TURN_MAX_RAD = 0.2
_WALL_M, _HEIGHT_M = 0.2, 4.0

Line = tuple[tuple[float, float], ...]


def trap_sdf(rng: np.random.Generator, kind: str, distance_m: float) -> str:
    """Return a field whose straight way leads into a trap of a kind; kind: of `TRAPS`."""
    lines = TRAPS[kind](rng)
    corners = np.concatenate([np.array(line) for line in lines])
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle = 0.5 * (low + high)
    parts = tuple(
        _wall(f"wall_{number}", np.array(begin) - middle, np.array(end) - middle)
        for number, (begin, end) in enumerate(side for line in lines for side in zip(line, line[1:]))
    )
    free_m = distance_m - 2.0 * CLEAR_M - (high - low)[0]
    x = CLEAR_M + 0.5 * (high - low)[0] + rng.uniform(0.3, 0.7) * free_m
    y, yaw_rad = rng.uniform(-0.5, 0.5), rng.uniform(-TURN_MAX_RAD, TURN_MAX_RAD)
    prop = Prop(kind, float(x), float(y), parts, float(yaw_rad))
    return write_world(BUG_TRAP, "A trap drawn at random.", GRASS, (prop,))


def _u(rng: np.random.Generator) -> tuple[Line, ...]:
    depth, half = rng.uniform(*DEPTHS_M), 0.5 * rng.uniform(*WIDTHS_M)
    return (((0.0, half), (depth, half), (depth, -half), (0.0, -half)),)


def _double_lip(rng: np.random.Generator) -> tuple[Line, ...]:
    depth, half = rng.uniform(*DEPTHS_M), 0.5 * rng.uniform(*WIDTHS_M)
    mouth, lip = 0.5 * rng.uniform(*MOUTHS_M), rng.uniform(*LIPS_M)
    upper = (lip, mouth), (0.0, mouth), (0.0, half), (depth, half)
    lower = (depth, -half), (0.0, -half), (0.0, -mouth), (lip, -mouth)
    return ((*upper, *lower),)


def _spiral(rng: np.random.Generator) -> tuple[Line, ...]:
    """Return a spiral of right angles, that opens to any side."""
    corridor, sides = rng.uniform(*CORRIDORS_M), int(rng.integers(SPIRAL_SIDES[0], SPIRAL_SIDES[1] + 1))
    place, points = np.zeros(2), [(0.0, 0.0)]
    for number in range(sides):
        direction = np.array(((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[number % 4])
        place = place + (1 + number // 2) * corridor * direction
        points.append((float(place[0]), float(place[1])))
    turns, mirror = rng.integers(4), rng.choice((-1.0, 1.0))
    c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[turns]
    return (tuple((c * x - s * mirror * y, s * x + c * mirror * y) for x, y in points),)


def _gap(rng: np.random.Generator) -> tuple[Line, ...]:
    half, length = 0.5 * rng.uniform(*GAPS_M), rng.uniform(*WALLS_M)
    at = rng.uniform(-GAP_ASIDE_M, GAP_ASIDE_M)
    return ((0.0, -0.5 * length), (0.0, at - half)), ((0.0, at + half), (0.0, 0.5 * length))


TRAPS: dict[str, Callable[[np.random.Generator], tuple[Line, ...]]] = {
    U: _u,
    DOUBLE_LIP: _double_lip,
    SPIRAL: _spiral,
    GAP: _gap,
}


def _wall(name: str, begin: np.ndarray, end: np.ndarray) -> Part:
    """Return a wall along x or y; at corners walls overlap by half their thickness, but not at free ends."""
    x_m, y_m = np.abs(end - begin)
    shape = Box(float(x_m), _WALL_M, _HEIGHT_M) if x_m > y_m else Box(_WALL_M, float(y_m), _HEIGHT_M)
    x, y = (0.5 * (begin + end)).tolist()
    return Part(name, shape, CONCRETE, (x, y, 0.5 * _HEIGHT_M))
