"""Open fields with barriers that a lidar hardly sees across the straight way: fences, panes of glass."""

from __future__ import annotations

import math

import numpy as np

from flights.worlds.drawn.materials import CLEAR_M, GRASS, STEEL
from flights.worlds.writer import Box, Colour, Cylinder, Part, Prop, write_world

FENCE, GLASS = "fence", "glass"
"""Kinds of barriers. The name of a pane's model begins with GLASS, by which `LidarFaults` finds it."""
WIRES_M = 0.25
"""From wire to wire."""
THICKNESSES_M = 0.004, 0.012
"""Of wires."""
LENGTHS_M, GAPS_M, TURN_MAX_RAD = (3.0, 7.0), (5.0, 8.0), 0.6
_HEIGHT_M, _PANE_M = 4.0, 0.01
_PANE = Colour(0.75, 0.85, 0.90, 0.7)


def barriers_sdf(rng: np.random.Generator, kind: str, distance_m: float) -> str:
    """Return a field with barriers of one kind, FENCE or GLASS, one behind the other."""
    props: list[Prop] = []
    x = CLEAR_M + rng.uniform(1.0, 3.0)
    while x < distance_m - CLEAR_M - 1.0:
        length_m, yaw_rad = rng.uniform(*LENGTHS_M), rng.uniform(-TURN_MAX_RAD, TURN_MAX_RAD)
        y = rng.uniform(-0.3, 0.3) * length_m
        parts = _wires(rng, length_m) if kind == FENCE else _pane(length_m)
        props.append(Prop(f"{kind}_{len(props)}", x, y, parts, yaw_rad))
        x += rng.uniform(*GAPS_M)
    return write_world(kind, "Barriers that a lidar hardly sees, drawn at random.", GRASS, tuple(props))


def _wires(rng: np.random.Generator, length_m: float) -> tuple[Part, ...]:
    radius_m, number = rng.uniform(*THICKNESSES_M) / 2, math.floor(length_m / WIRES_M) + 1
    wire, middle_z = Cylinder(radius_m, _HEIGHT_M), _HEIGHT_M / 2
    places_m = WIRES_M * (np.arange(number) - (number - 1) / 2)
    return tuple(Part(f"wire_{k}", wire, STEEL, (0.0, y, middle_z)) for k, y in enumerate(places_m.tolist()))


def _pane(length_m: float) -> tuple[Part, ...]:
    return (Part("pane", Box(_PANE_M, length_m, _HEIGHT_M), _PANE, (0.0, 0.0, _HEIGHT_M / 2)),)
