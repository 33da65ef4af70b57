"""The sizes of the report."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

from flights.worlds import scenario
from flights.worlds.experiment_1 import GOAL_X_M
from flights.worlds.placements import SCENARIOS as PLACEMENTS

PLACEMENTS_A_PIECE = 5
WORLDS = ("room", "hold")
EXPERIMENTS = (
    "experiment_1",
    "experiment_2",
    "experiment_3",
    "experiment_4",
    "volume",
    "without_gnss",
    "exploration",
    "measurement_1",
    "measurement_2",
)


@dataclass(frozen=True)
class Size:
    """The amount of computation.

    seeds: of Experiment 1's flights, over goal_x_m. placements: variations of each of Experiment 2's.
    map_seeds: of the flights that map; map_duration_s: 0: the whole mission. without_gnss: worlds and lidars
    of the flights without GNSS, which take longest. volumes: lidars whose clouds or nods are mapped in three
    dimensions. explored: places that are explored. launches, builds: number of rounds; 0: no measurement.
    """

    name: str
    seeds: tuple[int, ...]
    placements: int
    map_seeds: tuple[int, ...]
    launches: int
    builds: int
    scenarios: tuple[str, ...] = scenario.SCENARIOS
    goal_x_m: float = GOAL_X_M
    emergencies: tuple[str, ...] = PLACEMENTS
    worlds: tuple[str, ...] = WORLDS
    lidars: tuple[str, ...] = scenario.LIDARS
    without_gnss: tuple[tuple[str, str], ...] = tuple(product(WORLDS, scenario.LIDARS))
    volumes: tuple[str, ...] = ("puck", "m8", "ust", "urg")
    explored: tuple[str, ...] = ("hold_3d", "cells")
    map_duration_s: float = 0.0


FULL = Size("full", seeds=(1, 2, 3, 4, 5), placements=20, map_seeds=(1, 2, 3), launches=3, builds=2)
QUICK = replace(
    FULL,
    name="quick",
    seeds=(1,),
    placements=PLACEMENTS_A_PIECE,
    map_seeds=(1,),
    lidars=("urg", "ust", "puck"),
    without_gnss=(("hold", "ust"),),
    volumes=("puck",),
    explored=("cells",),
    launches=1,
    builds=1,
)
SMALLEST = Size(
    "smallest",
    seeds=(1,),
    placements=1,
    map_seeds=(1,),
    launches=0,
    builds=0,
    scenarios=("forest",),
    goal_x_m=1.5,
    emergencies=("wall_three_columns",),
    worlds=("room",),
    lidars=("ust",),
    without_gnss=(("room", "ust"),),
    volumes=("puck",),
    explored=("cells",),
    map_duration_s=3.0,
)
