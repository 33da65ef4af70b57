"""The hold in three dimensions: one flight of Experiment 4 with each lidar that has a cloud."""

from __future__ import annotations

from typing import Any

from gridslam.volume.warm_up import warm_up_volume
from gridslam.warm_up import warm_up
from master_thesis.experiments_3_4.map_variants import MappedFlight
from master_thesis.experiments_3_4.mapping_flight import SCENARIOS, parameters_of
from master_thesis.experiments_3_4.report.mapping_piece import ended_after, mapping_piece
from master_thesis.experiments_3_4.volume.flight import map_and_judge
from master_thesis.flight.parameters import ClosedLoopParameters
from master_thesis.report.piece import Piece
from master_thesis.report.size import Size
from master_thesis.results.picture_files import svg

EXPERIMENT, WORLD, PICTURE = "volume", "hold", "volume"
_COST_S = 50.0
_DRAWN_SEED = 1


def pieces(size: Size) -> list[Piece]:
    """Return the pieces of this size."""
    return [piece(size, lidar, seed) for seed in size.map_seeds for lidar in size.volumes]


def piece(size: Size, lidar: str, seed: int) -> Piece:
    """Return the piece of one flight."""
    given: dict[str, Any] = {"world": WORLD, "lidar": lidar, "seed": seed, "duration_s": size.map_duration_s}
    names = f"{EXPERIMENT}_{WORLD}_{lidar}", f"The hold in three dimensions: {lidar}"
    return mapping_piece(EXPERIMENT, names, make, given, _parameters(**given), _COST_S)


def make(world: str, lidar: str, seed: int, duration_s: float) -> dict:
    """Fly, map the plane, then the clouds along SLAM's path; return the figures and the picture."""
    warm_up()
    warm_up_volume()
    flight = MappedFlight.fly(world, lidar, seed, _parameters(world, lidar, seed, duration_s))
    run = flight.map(seed, loop_closure=True)
    volume = map_and_judge(flight.recording, SCENARIOS[world].world_path, lidar, run.final, seed)
    pictures = {PICTURE: svg(volume.figure())} if seed == _DRAWN_SEED else {}
    ate_m = flight.metrics(run)["ate_rmse_m"]
    return {**volume.error.as_dict(), "clouds": volume.clouds, "ate_rmse_m": ate_m, "pictures": pictures}


def _parameters(world: str, lidar: str, seed: int, duration_s: float) -> ClosedLoopParameters:
    return ended_after(parameters_of(world, lidar, seed), duration_s)
