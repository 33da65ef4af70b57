"""The hold in three dimensions: one flight of Experiment 4 with each lidar that has a cloud, or that nods."""

from __future__ import annotations

from typing import Any

from flights.flight.parameters import ClosedLoopParameters
from flights.mapping.mapping_flight import SCENARIOS, parameters_of
from flights.results.picture_files import svg
from gridslam.volume.warm_up import warm_up_volume
from gridslam.warm_up import warm_up
from master_thesis.experiments_3_4.map_variants import MappedFlight
from master_thesis.experiments_3_4.report.mapping_piece import ended_after, mapping_piece
from master_thesis.experiments_3_4.volume.flight import map_and_judge
from master_thesis.experiments_3_4.volume.nodding import NoddingFlight, with_nod
from master_thesis.report.piece import Piece
from master_thesis.report.size import Size

EXPERIMENT, WORLD, PICTURE = "volume", "hold", "volume"
NODDING = ("urg", "ust", "utm", "tim")
_COST_S, _COST_NODDING_S = 50.0, 150.0
_DRAWN_SEED = 1


def pieces(size: Size) -> list[Piece]:
    """Return the pieces of this size."""
    return [piece(size, lidar, seed) for seed in size.map_seeds for lidar in size.volumes]


def piece(size: Size, lidar: str, seed: int) -> Piece:
    """Return the piece of one flight."""
    given: dict[str, Any] = {"world": WORLD, "lidar": lidar, "seed": seed, "duration_s": size.map_duration_s}
    cost_s = _COST_NODDING_S if lidar in NODDING else _COST_S
    names = f"{EXPERIMENT}_{WORLD}_{lidar}", f"The hold in three dimensions: {lidar}"
    return mapping_piece(EXPERIMENT, names, make, given, _parameters(**given), cost_s)


def make(world: str, lidar: str, seed: int, duration_s: float) -> dict:
    """Fly, map the plane, then the clouds along SLAM's path; return the figures and the picture."""
    warm_up()
    warm_up_volume()
    parameters = _parameters(world, lidar, seed, duration_s)
    if parameters.nod is not None:
        volume, ate_m = NoddingFlight.fly(f"{world}, {lidar}, seed {seed}", parameters).map_and_judge(
            lidar, seed
        )
    else:
        flight = MappedFlight.fly(world, lidar, seed, parameters)
        run = flight.map(seed, loop_closure=True)
        volume = map_and_judge(flight.recording, SCENARIOS[world].world_path, lidar, run.final, seed)
        ate_m = flight.metrics(run)["ate_rmse_m"]
    pictures = {PICTURE: svg(volume.figure())} if seed == _DRAWN_SEED else {}
    return {**volume.error.as_dict(), "clouds": volume.clouds, "ate_rmse_m": ate_m, "pictures": pictures}


def _parameters(world: str, lidar: str, seed: int, duration_s: float) -> ClosedLoopParameters:
    parameters = parameters_of(world, lidar, seed)
    return ended_after(with_nod(parameters) if lidar in NODDING else parameters, duration_s)
