"""The worst places for CEPA's search: the narrowest hallway that it can fly, and a dense thicket.

A lidar with 1440 beams all around and a UST's noise sees them from places with nothing within r_LB. There
the search has most work, because an emergency needs no search.
"""

from __future__ import annotations

import math

import numpy as np

from benchmarks.shared.flights import Question
from cepa import LaserScan2D
from flights.worlds.writer import Box, Colour, Cylinder, Part, Prop, Surroundings, write_world
from simulation_tools.sdf.parser import load_world
from simulation_tools.world.world import PhysicsWorld

BEAMS = 1440
NOISE_M = 0.04 / 3
RANGE_MIN_M, RANGE_MAX_M = 0.06, 10.0
HEIGHT_M = 2.0
_COLOUR = Colour(0.5, 0.5, 0.5)


def hallway(width_m: float) -> str:
    """Return the SDF text of a straight hallway along x, 40 m long, with a door every 6 m."""
    doors = np.arange(-15.0, 16.0, 6.0)
    walls = [
        Prop(
            f"wall_{side}_{number}",
            x + 3.0,
            side * (width_m / 2 + 0.1),
            (Part("wall", Box(5.0, 0.2, 4.0), _COLOUR),),
        )
        for side in (1, -1)
        for number, x in enumerate(doors)
    ]
    return write_world("narrow", "A narrow hallway.", Surroundings(_COLOUR), tuple(walls))


def thicket(rng: np.random.Generator, spacing_m: float) -> str:
    """Return the SDF text of 20 x 20 m of thin trunks, about `spacing_m` from each other."""
    places = np.arange(-10.0, 10.1, spacing_m)
    trunks = [
        Prop(
            f"trunk_{row}_{column}",
            float(x + rng.uniform(-0.25, 0.25) * spacing_m),
            float(y + rng.uniform(-0.25, 0.25) * spacing_m),
            (Part("trunk", Cylinder(float(rng.uniform(0.03, 0.12)), 4.0), _COLOUR),),
        )
        for row, x in enumerate(places)
        for column, y in enumerate(places)
    ]
    return write_world("thicket", "A thicket.", Surroundings(_COLOUR), tuple(trunks))


def questions(
    world_path: str, rng: np.random.Generator, count: int, half_xy_m: tuple[float, float], keep_out_m: float
) -> list[Question]:
    """Return `count` questions from random places of a world, flown at 1 to 4 m/s in random directions.

    half_xy_m: places are drawn within +- these. keep_out_m: no place has anything seen within this distance.

    Raises:
        RuntimeError: hardly any place is that free.
    """
    world = PhysicsWorld(load_world(world_path))
    try:
        found: list[Question] = []
        for _ in range(200 * count):
            ranges = _scan(world, rng, half_xy_m)
            if ranges.min() > keep_out_m:
                scan = LaserScan2D(ranges, -math.pi, 2 * math.pi / BEAMS, RANGE_MIN_M, RANGE_MAX_M)
                found.append(Question(scan, _velocity(rng, 1.0, 4.0), _velocity(rng, 0.0, 4.0)))
                if len(found) == count:
                    return found
    finally:
        world.close()
    raise RuntimeError(
        f"{world_path}: only {len(found)} of {count} places have nothing within {keep_out_m} m."
    )


def _scan(world: PhysicsWorld, rng: np.random.Generator, half_xy_m: tuple[float, float]) -> np.ndarray:
    x_m, y_m = (rng.uniform(-half_m, half_m) for half_m in half_xy_m)
    position = np.array((x_m, y_m, HEIGHT_M))
    angles = rng.uniform(-math.pi, math.pi) + np.arange(BEAMS) * 2 * math.pi / BEAMS
    directions = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(BEAMS)))
    ranges = world.rays.cast(position, directions, RANGE_MAX_M).astype(float)
    return ranges + rng.normal(0.0, NOISE_M, BEAMS)


def _velocity(rng: np.random.Generator, least: float, most: float) -> tuple[float, float]:
    speed, angle = rng.uniform(least, most), rng.uniform(-math.pi, math.pi)
    return speed * math.cos(angle), speed * math.sin(angle)
