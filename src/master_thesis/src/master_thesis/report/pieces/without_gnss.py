"""Experiments 3 and 4 without GNSS: each world with each lidar and seed, flown by the lidar alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from master_thesis.experiments_3_4.flight_without_gnss import fly_without_gnss, parameters_without_gnss
from master_thesis.experiments_3_4.mapping_flight import PACKAGE, SCENARIOS
from master_thesis.flight.closed_loop import ClosedLoopParameters
from master_thesis.report.piece import Piece, fingerprint
from master_thesis.report.size import Size

EXPERIMENT = "without_gnss"
DRAWN_EVERY_M = 0.1
_COST_S = {"room": 60.0, "hold": 22.0}


def pieces(size: Size) -> list[Piece]:
    """Return the pieces of this size."""
    return [
        piece(size, world, lidar, seed)
        for seed in size.map_seeds
        for world in size.worlds
        for lidar in size.lidars
    ]


def piece(size: Size, world: str, lidar: str, seed: int) -> Piece:
    """Return the piece of one flight."""
    given: dict[str, Any] = {"world": world, "lidar": lidar, "seed": seed, "duration_s": size.map_duration_s}
    shorter = f"_{size.map_duration_s:g}s" if size.map_duration_s else ""
    return Piece(
        name=f"{EXPERIMENT}_{world}_{lidar}_{seed}{shorter}",
        experiment=EXPERIMENT,
        title=f"Without GNSS: {world}, {lidar}, seed {seed}",
        run=make,
        given=given,
        inputs=fingerprint(
            _parameters(**given),
            world=SCENARIOS[world].world_path,
            slam=PACKAGE / "config" / f"gridslam_{world}.yaml",
        ),
        cost_s=_COST_S[world],
        lidar=lidar,
    )


def make(world: str, lidar: str, seed: int, duration_s: float) -> dict:
    """Fly; return the metrics, and `path_xy`, the true path in `world`."""
    flight = fly_without_gnss(world, seed, _parameters(world, lidar, seed, duration_s))
    return {**flight.metrics(), "path_xy": flight.path_xy(DRAWN_EVERY_M)}


def _parameters(world: str, lidar: str, seed: int, duration_s: float) -> ClosedLoopParameters:
    parameters = parameters_without_gnss(world, lidar, seed)
    return replace(parameters, duration_s=duration_s) if duration_s else parameters
