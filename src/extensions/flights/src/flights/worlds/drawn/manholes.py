"""A passage of bulkheads, each with a manhole near the straight way. Something may be behind the first.

What is there moves by a script of simulated time, and leaves the way at last.
"""

from __future__ import annotations

import math

import numpy as np

from flights.worlds.drawn.materials import STEEL
from flights.worlds.drawn.movers import GOAL_SENT_S
from flights.worlds.steel import FRAME, SHELL, Opening, box, transverse_plate
from flights.worlds.writer import Colour, Cylinder, Part, Prop, Surroundings, Walk, write_world

MANHOLES = "manholes"
NOTHING, PERSON, HOSE = "nothing", "person", "hose"
BREADTHS_M, HEIGHTS_M = (0.6, 0.66), (0.8, 0.9)
OFF_M = 0.05
"""The straight way misses a manhole's middle by at most so much, to the side and in height."""
FIRST_M, APART_M, END_M = (2.4, 3.0), (2.4, 3.2), 1.5
_HALF_BREADTH_M, _DECK_M, _PLATE_M, _SHELL_M, _BEYOND_M = 1.5, 3.0, 0.03, 0.1, 2.0
_BEHIND_M = {PERSON: 0.5, HOSE: 0.35}
_SHAPES = {PERSON: Cylinder(0.25, 1.8), HOSE: Cylinder(0.03, 2.6)}
_ASIDE_M, _WALK_M_S, _STEP_S, _GOES_ON_S = 1.1, 0.9, 0.2, 90.0
_SWING_M, _SWINGS_S = (0.3, 0.7), (2.4, 4.0)
_FLOOR = Surroundings(Colour(0.66, 0.62, 0.58), camera=(-6.0, 0.0, 3.0, 0.0, 0.3, 0.0))


def manholes_sdf(rng: np.random.Generator, distance_m: float, height_m: float, behind: str) -> str:
    """Return a passage along x. height_m: of the flight. behind: NOTHING, PERSON or HOSE."""
    plates_x_m = [rng.uniform(*FIRST_M)]
    while plates_x_m[-1] + APART_M[1] < distance_m - END_M:
        plates_x_m.append(plates_x_m[-1] + rng.uniform(*APART_M))
    parts = [part for number, x in enumerate(plates_x_m) for part in _bulkhead(rng, number, x, height_m)]
    props = Prop("shell", 0.0, 0.0, _shell(distance_m)), Prop("bulkheads", 0.0, 0.0, tuple(parts))
    walks = () if behind == NOTHING else (_walk(rng, plates_x_m[0], behind),)
    return write_world(MANHOLES, "Manholes drawn at random.", _FLOOR, props, walks)


def _bulkhead(rng: np.random.Generator, number: int, x: float, height_m: float) -> tuple[Part, ...]:
    y, z = rng.uniform(-OFF_M, OFF_M), height_m + rng.uniform(-OFF_M, OFF_M)
    half_y, half_z = rng.uniform(*BREADTHS_M) / 2, rng.uniform(*HEIGHTS_M) / 2
    opening = Opening((y - half_y, y + half_y), (z - half_z, z + half_z))
    across = (-_HALF_BREADTH_M, _HALF_BREADTH_M), (0.0, _DECK_M)
    return transverse_plate(f"plate_{number}", (x, x + _PLATE_M), *across, (opening,), FRAME)


def _shell(distance_m: float) -> tuple[Part, ...]:
    x, y, z = (-_BEYOND_M, distance_m + _BEYOND_M), (-_HALF_BREADTH_M, _HALF_BREADTH_M), (0.0, _DECK_M)
    return (
        box("port", x, (y[1], y[1] + _SHELL_M), z, SHELL),
        box("starboard", x, (y[0] - _SHELL_M, y[0]), z, SHELL),
        box("aft", (x[0] - _SHELL_M, x[0]), y, z, SHELL),
        box("fore", (x[1], x[1] + _SHELL_M), y, z, SHELL),
        box("deck", x, y, (_DECK_M, _DECK_M + _SHELL_M), SHELL),
    )


def _walk(rng: np.random.Generator, plate_x: float, behind: str) -> Walk:
    """Return what is behind a plate until it goes aside, some seconds after the UAV could be there."""
    leaves_s = GOAL_SENT_S + rng.uniform(8.0, 14.0)
    times_s = np.arange(0.0, leaves_s + _GOES_ON_S, _STEP_S)
    begins_y = rng.uniform(-0.1, 0.1)
    if behind == HOSE:
        swing_m, period_s = rng.uniform(*_SWING_M), rng.uniform(*_SWINGS_S)
        begins_y = begins_y + swing_m * np.sin(2.0 * math.pi * np.minimum(times_s, leaves_s) / period_s)
    aside_m = _WALK_M_S * np.maximum(0.0, times_s - leaves_s)
    y = np.minimum(begins_y + aside_m, np.maximum(_ASIDE_M, begins_y))
    x = np.full_like(times_s, plate_x + _PLATE_M + _BEHIND_M[behind])
    waypoints = np.column_stack((times_s, x, y, np.zeros_like(x), np.zeros_like(x)))
    part = Part("body", _SHAPES[behind], STEEL)
    return Walk("behind", (part,), tuple(map(tuple, waypoints.tolist())))
