"""Experiment 4 without GNSS by a planar lidar that nods at each stop, and how true its map of voxels is."""

from __future__ import annotations

from benchmarks.volume_rows.flown import figures_of
from gridslam.odometry.warm_up import warm_up_odometry
from gridslam.volume.warm_up import warm_up_volume
from gridslam.warm_up import warm_up
from master_thesis.experiments_3_4.volume.nodding import WORLD, NoddingFlight, with_nod
from master_thesis.experiments_3_4.without_gnss.flight import parameters_without_gnss


def fly(lidar: str, seed: int) -> dict:
    """Fly the whole mission; return the figures of `flown.fly`. ate_m: of SLAM's path.

    Raises:
        FlightError: the mission was not flown, or something was touched.
    """
    warm_up()
    warm_up_odometry()
    warm_up_volume()
    flight = NoddingFlight.fly(
        f"hold, {lidar}, seed {seed}", with_nod(parameters_without_gnss(WORLD, lidar, seed))
    )
    volume, ate_m = flight.map_and_judge(lidar, seed)
    return {
        "flown": flight.outcome.reached_goal and flight.outcome.landed,
        "contact": flight.outcome.collision,
        "minutes": flight.swept[-1].t_s / 60.0,
        "nodes": volume.clouds,
        "ate_m": ate_m,
        **figures_of(volume.error),
    }
