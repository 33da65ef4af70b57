"""Experiments 3 and 4 without GNSS: each world with each lidar and seed, flown by the lidar alone."""

from __future__ import annotations

from typing import Any

from flights.flight.parameters import ClosedLoopParameters
from master_thesis.experiments_3_4.report.mapping_piece import ended_after, mapping_piece
from master_thesis.experiments_3_4.without_gnss.flight import fly_without_gnss, parameters_without_gnss
from master_thesis.report.piece import Piece
from master_thesis.report.size import Size

EXPERIMENT = "without_gnss"
DRAWN_EVERY_M = 0.1
_COST_S = {"room": 60.0, "hold": 22.0}


def pieces(size: Size) -> list[Piece]:
    """Return the pieces of this size."""
    return [piece(size, world, lidar, seed) for seed in size.map_seeds for world, lidar in size.without_gnss]


def piece(size: Size, world: str, lidar: str, seed: int) -> Piece:
    """Return the piece of one flight."""
    given: dict[str, Any] = {"world": world, "lidar": lidar, "seed": seed, "duration_s": size.map_duration_s}
    names = f"{EXPERIMENT}_{world}_{lidar}", f"Without GNSS: {world}, {lidar}"
    return mapping_piece(EXPERIMENT, names, make, given, _parameters(**given), _COST_S[world])


def make(world: str, lidar: str, seed: int, duration_s: float) -> dict:
    """Fly; return the metrics, and `path_xy`, the true path in `world`."""
    flight = fly_without_gnss(world, seed, _parameters(world, lidar, seed, duration_s))
    return {**flight.metrics(), "path_xy": flight.path_xy(DRAWN_EVERY_M)}


def _parameters(world: str, lidar: str, seed: int, duration_s: float) -> ClosedLoopParameters:
    return ended_after(parameters_without_gnss(world, lidar, seed), duration_s)
