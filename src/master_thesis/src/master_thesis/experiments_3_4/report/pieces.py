"""Experiments 3 and 4: each world with each lidar and seed, flown once and mapped twice."""

from __future__ import annotations

from typing import Any

from flights.flight.parameters import ClosedLoopParameters
from flights.mapping.mapping_flight import parameters_of
from flights.results.picture_files import svg
from gridslam.warm_up import warm_up
from master_thesis.experiments_3_4.map_variants import MappedFlight
from master_thesis.experiments_3_4.report.mapping_piece import ended_after, in_each_world, mapping_piece
from master_thesis.report.piece import Piece
from master_thesis.report.size import Size
from master_thesis.report.thesis import TIM_RANGE_IN_TEXT_M

EXPERIMENTS = {"room": "experiment_3", "hold": "experiment_4"}
OPEN, CLOSED = "open", "closed"
"""Without and with loop closure."""
_COST_S = {
    "room": {"urg": 12, "ust": 22, "utm": 21, "puck": 24, "tim": 17, "m8": 28},
    "hold": {"urg": 4, "ust": 6, "utm": 11, "puck": 13, "tim": 9, "m8": 14},
}
_DRAWN_SEED = 1


def pieces(size: Size) -> list[Piece]:
    """Return the pieces of this size."""
    found = in_each_world(size, piece)
    if "hold" in size.worlds and "tim" in size.lidars:
        found += [tim_of_the_text(size, seed) for seed in size.map_seeds]
    return found


def tim_of_the_text(size: Size, seed: int) -> Piece:
    """Return the piece of the hold, seen by the TiM with the range in the thesis's text."""
    return piece(size, "hold", "tim", seed, range_max_m=TIM_RANGE_IN_TEXT_M)


def piece(size: Size, world: str, lidar: str, seed: int, range_max_m: float = 0.0) -> Piece:
    """Return the piece of one flight and its maps. range_max_m: replaces the lidar's own, unless 0."""
    given: dict[str, Any] = {
        "world": world,
        "lidar": lidar,
        "seed": seed,
        "duration_s": size.map_duration_s,
        "range_max_m": range_max_m,
    }
    seen = f"{lidar}_{range_max_m:g}m" if range_max_m else lidar
    experiment = EXPERIMENTS[world]
    names = f"{experiment}_{seen}", f"Experiment {experiment[-1]}: {world}, {seen.replace('_', ' ')}"
    return mapping_piece(experiment, names, make, given, _parameters(**given), float(_COST_S[world][lidar]))


def make(world: str, lidar: str, seed: int, duration_s: float, range_max_m: float) -> dict:
    """Fly, and map without and with loop closure."""
    warm_up()
    flight = MappedFlight.fly(world, lidar, seed, _parameters(world, lidar, seed, duration_s, range_max_m))
    numbers: dict = {}
    pictures: dict[str, bytes] = {}
    for name in (OPEN, CLOSED):
        run = flight.map(seed, loop_closure=name == CLOSED)
        numbers[name] = flight.metrics(run)
        if seed == _DRAWN_SEED:
            words = "with" if name == CLOSED else "without"
            pictures[name] = svg(flight.picture(run, f"{flight.recording.name}, {words} loop closure"))
    return {**numbers, "pictures": pictures}


def _parameters(
    world: str, lidar: str, seed: int, duration_s: float, range_max_m: float
) -> ClosedLoopParameters:
    return ended_after(parameters_of(world, lidar, seed, lidar_range_max_m=range_max_m), duration_s)
