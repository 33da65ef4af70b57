"""Measures the clearance after a flight: the distance from the UAV to the nearest obstacle.

The world is built again from its file, and physics measures at the flown poses.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Callable, Sequence

import numpy as np

from flights.flight.course import Outcome, Phase
from flights.flight.description import RunDescription
from flights.flight.flight_log import FlightLog
from flights.results.metrics import flight_interval_s
from flights.worlds.placements import Obstacle
from simulation_tools.geometry import Pose

if TYPE_CHECKING:
    from simulation_tools.sdf.elements import Model
    from simulation_tools.world.world import PhysicsWorld

FARTHEST_M = 5.0
"""Obstacles farther away than this are ignored."""
FLOOR_HEIGHT_M = 0.5
"""A shape that is higher is more than a floor."""
SPACING_M = 0.02
ACTOR_PERIOD_S = 0.02
"""Between two poses at which the distance to things that move is measured."""
Progress = Callable[[int, int], None]


def no_progress(done: int, of: int) -> None:
    """Do not report progress."""


def clearances_of_flight(
    description: RunDescription, log: FlightLog, outcome: Outcome, progress: Progress = no_progress
) -> np.ndarray:
    """Return (n, 2): time, and distance in m from the UAV to the nearest shape except level ground.

    It is measured along the true path, from sending the goal to landing, in the world of its file. A landing
    between two parts of the flight does not count: the UAV stands on the ground then.

    Raises:
        SimulationToolsError: the world or the UAV cannot be loaded.
    """
    start_s, end_s = flight_interval_s(log, outcome)
    poses = log.between(start_s, outcome.times_s.get(Phase.LANDING, end_s))
    for landed_s, hovers_s in outcome.between_s:
        poses = poses[(poses[:, 0] < landed_s) | (poses[:, 0] > hovers_s)]
    world, uav = description.scenario.world_path, (description.model, description.lidar)
    return clearances_along(poses, world, uav, ignore=outcome.ground, progress=progress, spacing_m=SPACING_M)


def clearances_along(
    poses: np.ndarray,
    world_file: Path | str,
    uav: tuple[str, str],
    ignore: Sequence[str] = (),
    placed: Sequence[tuple[Obstacle, Pose]] = (),
    progress: Progress = no_progress,
    spacing_m: float = 0.0,
) -> np.ndarray:
    """Return (n, 2): time, and distance in m from the UAV to the nearest shape, at poses (n, 8).

    uav: its model and its lidar. ignore: models that do not count. placed: obstacles that are not in the
    world's file, with their poses in `world`. spacing_m: of the thinned poses.

    Raises:
        SimulationToolsError: the world or the UAV cannot be loaded.
    """
    # Physics takes a third of a second to import: only here, when the flight is over
    from simulation_tools.sdf.parser import load_world
    from simulation_tools.vehicle.uav import load_uav
    from simulation_tools.world.world import PhysicsWorld

    world = PhysicsWorld(load_world(str(world_file)))
    try:
        for obstacle, pose in placed:
            world.spawn(obstacle.model(), obstacle.name, pose)
        model = load_uav(*uav).model
        name = f"{model.name}_measured"
        world.spawn(model, name, Pose.identity())
        return distances_in(world, name, poses, spacing_m, ignore, progress)
    finally:
        world.close()


def distances_in(
    world: PhysicsWorld,
    uav: str,
    poses: np.ndarray,
    spacing_m: float,
    ignore: Sequence[str],
    progress: Progress = no_progress,
) -> np.ndarray:
    """Return (n, 2): time, and distance in m from a UAV's shapes to the nearest others, along poses (n, 8).

    What a script moves stands where it was at the time of each pose. ignore: models that do not count. One
    that is more than a floor counts all the same: a world may be one mesh, with its walls.
    """
    ignore = [name for name in ignore if name not in world.model_names() or _is_floor(world.model(name))]

    def clearance(time_s: float, pose: Pose) -> float:
        world.place_actors(time_s)
        return world.clearance(uav, pose, FARTHEST_M, ignore)

    kept = thinned(poses, spacing_m, ACTOR_PERIOD_S if world.has_actors else math.inf)
    return np.column_stack((kept[:, 0], measured(clearance, kept, progress)))


def _is_floor(model: Model) -> bool:
    """Whether a model has nothing but level ground: planes, hills, and shapes that are not high."""
    from simulation_tools.sdf.elements import Heightmap, Plane
    from simulation_tools.world.shapes.meshes import mesh_of

    heights_m = [
        np.ptp(mesh_of(shape.geometry).transformed(model.pose @ link.pose @ shape.pose).vertices[:, 2])
        for link in model.links
        for shape in link.collisions
        if not isinstance(shape.geometry, (Plane, Heightmap))
    ]
    return max(heights_m, default=0.0) <= FLOOR_HEIGHT_M


def measured(
    clearance: Callable[[float, Pose], float], poses: np.ndarray, progress: Progress = no_progress
) -> np.ndarray:
    """Return the distance in m to the nearest obstacle at each of the poses (n, 8).

    clearance: distance at a time and a pose from the UAV's collision shapes to the nearest other shape.
    progress: is called from time to time with the number of done and of all poses.
    """
    distances = np.empty(len(poses))
    for index, (time_s, x, y, z, *quaternion) in enumerate(poses.tolist()):
        distances[index] = clearance(time_s, Pose((x, y, z), tuple(quaternion)))
        if index % 200 == 0:
            progress(index, len(poses))
    return distances


def thinned(poses: np.ndarray, spacing_m: float, period_s: float = math.inf) -> np.ndarray:
    """Thin out poses (n, 8: t, position, quaternion) to a spacing of `spacing_m`, both ends included.

    Between two kept poses the UAV moves by less than `spacing_m` in less than period_s. So its distance from
    any fixed obstacle changes by less than `spacing_m`.
    """
    if len(poses) < 2:
        return poses
    kept, last = [0], poses[0]
    for index in range(1, len(poses) - 1):
        pose = poses[index]
        if np.linalg.norm(pose[1:4] - last[1:4]) >= spacing_m or pose[0] - last[0] >= period_s:
            kept.append(index)
            last = pose
    return poses[[*kept, len(poses) - 1]]


def least(clearances: np.ndarray) -> float | None:
    """Return the least of the clearances (n, 2), or None if no obstacle came within `FARTHEST_M`."""
    finite = clearances[np.isfinite(clearances[:, 1]), 1] if len(clearances) else []
    return float(np.min(finite)) if len(finite) else None
