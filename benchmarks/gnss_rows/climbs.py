"""Climbs between the bottom and the deck of `hold_3d`: places drawn in the hold are flown to one by one.

Deck beams, coaming, frames and stanchions change what a level lidar sees with the height. Odometry is
compared with the truth as it is: both begin at the same place, and nothing is aligned. Without SLAM.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Sequence

import numpy as np

from benchmarks.shared.results import ROOT
from gridslam.cloud_odometry.warm_up import warm_up_cloud_odometry
from gridslam.odometry.warm_up import warm_up_odometry
from inspection_tools import PositionControllerParameters, Waypoint
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.parameters import ClosedLoopParameters
from simulation_tools.geometry import Pose
from simulation_tools.simulation import SimulationParameters
from simulation_tools.world.rays import RayScene

WORLD = ROOT / "src/master_thesis/worlds/hold_3d.world"
START_XYZ_M = (-9.0, 5.0, 0.0)
LOWEST_XYZ_M, HIGHEST_XYZ_M = (-12.5, -7.5, 0.6), (12.5, 7.5, 8.6)
ROOM_M, STEP_M = 1.3, 0.4
"""Nothing is nearer to the way than this; it is looked at every so far."""
TURNS_S = 4.0
"""At each place, for the turn and the braking."""
METRICS = ("ate_m", "worst_m", "height_p95_m", "cpu_ms", "cpu_p99_ms")


def fly(lidar: str, seed: int, minutes: float = 10.0) -> dict:
    """Fly about so many minutes; return the errors of the odometry in m, and its CPU time for each cloud.

    ate_m: root mean square. worst_m: the greatest. height_p95_m: of the height, 95 %. remarks: estimates
    that told a doubt.
    """
    warm_up_odometry()
    warm_up_cloud_odometry()
    simulation = SimulationParameters(
        str(WORLD),
        lidar=lidar,
        sensors=("range_finder",),
        gnss=False,
        seed=seed,
        spawn_pose=Pose(START_XYZ_M),
    )
    controller = PositionControllerParameters()
    with ClosedLoop(ClosedLoopParameters(simulation, goal_xyz_m=None, pose_source="odometry")) as empty:
        rays, speed = empty.simulation.world.rays, controller.max_speed
        places = drawn_places(rays, np.random.default_rng(seed), 60.0 * minutes, speed)
    mission = tuple(Waypoint(place) for place in places)
    parameters = ClosedLoopParameters(simulation, mission=mission, pose_source="odometry")
    with ClosedLoop(replace(parameters, position_controller=controller)) as loop:
        outcome = loop.run()
        truth = loop.log.truth.array("t_s", "x_m", "y_m", "z_m")
        assert loop.own_odometry is not None  # there is no GNSS
        estimates, cpu_ms = loop.own_odometry.estimates[1:], loop.own_odometry.cpu_ms
    times_s = np.array([estimate.stamp_s for estimate in estimates])
    found = np.array([estimate.position_xyz for estimate in estimates])
    off = found - np.column_stack([np.interp(times_s, truth[:, 0], truth[:, axis]) for axis in (1, 2, 3)])
    off_m = np.linalg.norm(off, axis=1)
    return {
        "flown": outcome.reached_goal and outcome.landed,
        "contact": outcome.collision,
        "failure": outcome.failure,
        "places": len(places),
        "minutes": float(times_s[-1] / 60.0),
        "remarks": sum(bool(estimate.remark) for estimate in estimates),
        "ate_m": float(np.sqrt(np.square(off_m).mean())),
        "worst_m": float(off_m.max()),
        "height_p95_m": float(np.percentile(np.abs(off[:, 2]), 95)),
        "cpu_ms": float(np.median(cpu_ms)),
        "cpu_p99_ms": float(np.percentile(cpu_ms, 99)),
    }


def drawn_places(
    rays: RayScene, rng: np.random.Generator, seconds: float, speed_m_s: float
) -> list[tuple[float, float, float]]:
    """Return places, each seen from the one before it with room around the way.

    seconds: the flight to all of them takes about so long.
    """
    here = np.array((*START_XYZ_M[:2], 2.0))
    places, used_s = [], 0.0
    while used_s < seconds:
        there = rng.uniform(LOWEST_XYZ_M, HIGHEST_XYZ_M)
        if not is_open(rays, here, there):
            continue
        x, y, z = there.round(2).tolist()
        places.append((x, y, z))
        used_s += float(np.linalg.norm(there - here)) / speed_m_s + TURNS_S
        here = there
    return places


def is_open(rays: RayScene, here: np.ndarray, there: np.ndarray) -> bool:
    """Return whether nothing but the floor is nearer than `ROOM_M` to the way."""
    steps = max(2, math.ceil(float(np.linalg.norm(there - here)) / STEP_M))
    directions = _all_around(300)
    for along in np.linspace(0.0, 1.0, steps):
        place = here + along * (there - here)
        ranges = rays.cast(place, directions, ROOM_M)
        hits = place + directions * np.where(np.isfinite(ranges), ranges, 0.0)[:, None]
        if (np.isfinite(ranges) & (hits[:, 2] > 0.05)).any():
            return False
    return True


def _all_around(number: int) -> np.ndarray:
    """Return unit vectors (number, 3), evenly spread: a spiral from pole to pole."""
    index = np.arange(number) + 0.5
    polar, azimuth = np.arccos(1.0 - 2.0 * index / number), math.pi * (1.0 + math.sqrt(5.0)) * index
    return np.column_stack((np.cos(azimuth) * np.sin(polar), np.sin(azimuth) * np.sin(polar), np.cos(polar)))


def summary(trials: Sequence[dict]) -> dict:
    """Return counts, and median and worst of each metric."""
    counts = {key: sum(trial[key] for trial in trials) for key in ("flown", "contact", "remarks")}
    values = {key: [trial[key] for trial in trials] for key in METRICS}
    spread = {key: {"median": float(np.median(all_)), "worst": max(all_)} for key, all_ in values.items()}
    return {"flights": len(trials), **counts, **spread}
