"""Checks that the start and the goals of a flight are free, and above the ground."""

from __future__ import annotations

import math
from functools import partial
from typing import Callable, NamedTuple, Sequence

import numpy as np

from flights.errors import ScenarioError
from flights.flight.take_off import LEAST_HOVER_M, SPARE_M, USUAL_HOVER_M, first_hover_m
from flights.worlds.scenario import Scenario
from simulation_tools.geometry import Pose

PENETRATION_M, LIFT_M = 0.02, 0.06
"""Greatest overlap that still counts as a touch; height over the ground for checking the UAV, because
physics puts a margin of 4 cm around terrain.
"""

HOVER_M, OVERSHOOT_M, CLIMB_STEP_M = USUAL_HOVER_M, 0.15, 0.1
"""Height over the ground to which the UAV takes off; how far it may climb beyond; steps of the check."""
FARTHEST_GROUND_M = 10_000.0
FALL_M = 0.5
"""The UAV stands at its start. From here it would hit the ground at 3 m/s, faster than any landing."""
FEET_M, RAYS_DOWN = 0.2, 200
"""So far around its middle, with so many rays, it is looked for what carries the UAV: a grating does, too."""
GOLDEN_RAD = math.pi * (3.0 - math.sqrt(5.0))
RAYS_UP, LOOK_FARTHER_M = 4000, 1.0
"""Rays that look for what is above the start, and how far beyond the height that is wanted."""
BODY_SHARE = 0.7
"""The UAV's radius, as a share of r_lb: what it keeps at least beside a wall."""

PROBE = "the place"
"""As "the UAV" no name that a world is likely to hold."""
_PROBE_RADIUS_M = 0.001
_PROBE = (
    '<sdf version="1.6"><model name="place"><static>true</static><link name="link"><collision name="point">'
    f"<geometry><sphere><radius>{_PROBE_RADIUS_M}</radius></sphere></geometry></collision></link></model></sdf>"
)


def check_course(
    scenario: Scenario,
    model: str,
    lidar: str,
    places_xyz_m: Sequence[tuple],
    keep_m: float,
    hover_m: float | None = HOVER_M,
) -> float:
    """Check that the UAV does not start inside or below an obstacle, and that no place is too close to one.

    No place may lie below the ground, or so near above it that the UAV would stand on it. places_xyz_m: in
    `world`. keep_m: the avoidance's distance from obstacles (CEPA's r_LB), 0 if unknown. The UAV would never
    reach a nearer place. The ground plane is not an obstacle. hover_m: height over the ground to which the
    UAV takes off; None: what the room above allows, with keep_m. Returns that height.

    Raises:
        ScenarioError: one sentence that names the obstacle.
        SimulationToolsError: the world or the UAV cannot be loaded.
    """
    # Physics takes a third of a second to import, scipy as long
    from flights.launch_arguments.solid_bodies import solid_around
    from simulation_tools.sdf.parser import load_world, parse_model
    from simulation_tools.vehicle.uav import load_uav
    from simulation_tools.world.shapes.meshes import standing_height_m
    from simulation_tools.world.world import PhysicsWorld

    world = PhysicsWorld(load_world(str(scenario.world_path)))
    try:
        obstacles = world.model_names()
        x, y, z, yaw = scenario.start_xyz_yaw
        uav = load_uav(model, lidar).model
        stands_m = standing_height_m(uav)
        lifted_m = z + stands_m + LIFT_M
        under_start, *under = (
            vertical_m(world.rays.cast, place) for place in ((x, y, lifted_m), *places_xyz_m)
        )  # before the UAV is among the shapes
        falls_m = _down_m(world.rays.cast, (x, y, lifted_m)) - stands_m - LIFT_M
        solid = solid_around(
            {name: mesh for name, mesh in world.rays.standing.items() if name != "ground_plane"},
            np.array((x, y, lifted_m)),
        )
        highest_m = math.inf if hover_m else highest_hover_m(world.rays.cast, (x, y, z), stands_m, keep_m)
        world.spawn(uav, "the UAV", Pose.identity())
        world.spawn(parse_model(_PROBE, "the place"), PROBE, Pose.identity())
        others = {"the UAV", PROBE, "ground_plane"}

        def distance_m(who: str, pose: Pose, within_m: float, but: frozenset[str] = frozenset()) -> float:
            return world.clearance(who, pose, within_m, ignore=others | but)

        start = Pose.from_xyz_rpy(x, y, lifted_m, yaw=yaw) @ uav.pose
        if distance_m("the UAV", start, 0.1) < -PENETRATION_M:
            solid = _nearest(obstacles, partial(distance_m, "the UAV", start, 0.1))
        if solid is not None:
            raise ScenarioError(
                f"At ({x:g}, {y:g}, {z:g}) the UAV would start inside of {solid}; move start:=."
            )
        if under_start.is_below_ground:
            raise ScenarioError(
                f"At ({x:g}, {y:g}, {z:g}) the UAV would start below the ground; move start:=."
            )
        if under_start.down_m == math.inf:
            raise ScenarioError(
                f"At ({x:g}, {y:g}, {z:g}) nothing is below the UAV, so it would fall; move start:=, or "
                "give the world a floor: <include><uri>model://ground_plane</uri></include>."
            )
        if falls_m > FALL_M:
            raise ScenarioError(
                f"At ({x:g}, {y:g}, {z:g}) the UAV would start {falls_m:.1f} m above what is below it, and "
                f"fall; move start:=, for example to the height {z - falls_m:.2f}."
            )
        if hover_m is None:
            hover_m = _hover_m((x, y, z), highest_m, keep_m)
        for up_m in np.arange(CLIMB_STEP_M, z + hover_m + OVERSHOOT_M - lifted_m, CLIMB_STEP_M).tolist():
            climbed = Pose((0.0, 0.0, up_m)) @ start
            if distance_m("the UAV", climbed, 0.1) < -PENETRATION_M:
                name = _nearest(obstacles, partial(distance_m, "the UAV", climbed, 0.1))
                raise ScenarioError(_climbs_into((x, y, z), name, up_m + stands_m, hover_m))
        for place, room in zip(places_xyz_m, under):
            pose = Pose(tuple(place))
            found_m = distance_m(PROBE, pose, keep_m + 1.0)
            if found_m < max(keep_m, _PROBE_RADIUS_M):
                name = _nearest(obstacles, partial(distance_m, PROBE, pose, keep_m + 1.0))
                raise ScenarioError(_too_close(place, found_m + _PROBE_RADIUS_M, name, keep_m))
            if room.is_below_ground or room.down_m < stands_m:
                raise ScenarioError(_too_low(place, room, stands_m))
    finally:
        world.close()
    return hover_m


Cast = Callable[[np.ndarray, np.ndarray, float], np.ndarray]
"""Returns the distance to the nearest surface along rays, see `simulation_tools.world.rays.RayScene.cast`."""


def _hover_m(start: Sequence[float], highest_m: float, keep_m: float) -> float:
    """Return the height over the ground to take off to; raises ScenarioError if nothing fits."""
    height_m = first_hover_m(highest_m, keep_m)
    if height_m is None:
        raise ScenarioError(
            f"Over ({_xyz(start)}) there is room for {max(highest_m, 0.0) + keep_m:.2f} m only. CEPA keeps "
            f"{keep_m:g} m (r_lb) to each side, so the UAV needs {2.0 * max(keep_m, LEAST_HOVER_M):.2f} m; "
            "move start:=, or take a smaller UAV."
        )
    return height_m


def highest_hover_m(cast: Cast, start: Sequence[float], stands_m: float, keep_m: float) -> float:
    """Return up to which height over the ground a UAV may rise; at most HOVER_M and a little more.

    start: x, y, z of the ground. stands_m: height of the UAV's origin while it stands. keep_m: that it keeps
    from what is above it.
    """
    from exploration.planning.room_above import rise_m  # numba takes half a second

    wanted_m = HOVER_M + SPARE_M - stands_m
    origin = np.array((start[0], start[1], start[2] + stands_m))
    up = np.linspace(0.0, 1.0, RAYS_UP)  # evenly over the half sphere
    azimuth = np.arange(RAYS_UP) * GOLDEN_RAD
    level = np.sqrt(1.0 - up**2)
    rays = np.stack((level * np.cos(azimuth), level * np.sin(azimuth), up), axis=1)
    far_m = cast(origin, rays, wanted_m + 2.0 * keep_m + LOOK_FARTHER_M)
    is_hit = np.isfinite(far_m)
    away_m, above_m = far_m[is_hit] * level[is_hit], far_m[is_hit] * up[is_hit]
    return stands_m + rise_m(away_m, above_m, wanted_m, BODY_SHARE * keep_m, keep_m)


class Vertical(NamedTuple):
    """Distances from a place to the nearest surfaces below and above it, m; inf: there is none."""

    down_m: float
    up_m: float

    @property
    def is_below_ground(self) -> bool:
        """Whether the world has something above the place, but nothing below it."""
        return self.down_m == math.inf and self.up_m < math.inf


def vertical_m(cast: Cast, place_xyz_m: Sequence[float]) -> Vertical:
    """Look down and up from a place."""
    down_and_up = np.array(((0.0, 0.0, -1.0), (0.0, 0.0, 1.0)))
    return Vertical(*cast(np.array(place_xyz_m), down_and_up, FARTHEST_GROUND_M).tolist())


def _down_m(cast: Cast, place_xyz_m: Sequence[float]) -> float:
    """Return the distance from a place to the highest surface below the UAV there, m."""
    number = np.arange(RAYS_DOWN)
    away_m, azimuth = FEET_M * np.sqrt(number / RAYS_DOWN), number * GOLDEN_RAD  # evenly over a disk
    feet_m = np.stack((away_m * np.cos(azimuth), away_m * np.sin(azimuth), 0.0 * away_m), axis=1)
    feet_m += np.array(place_xyz_m)
    down = np.broadcast_to((0.0, 0.0, -1.0), feet_m.shape)
    return float(cast(feet_m, down, FARTHEST_GROUND_M).min())


def _nearest(models: Sequence[str], distance_m: Callable[[frozenset], float]) -> str:
    everyone = frozenset(models)
    return min(models, key=lambda name: distance_m(everyone - {name}))


def _climbs_into(start: Sequence[float], name: str, height_m: float, hover_m: float) -> str:
    return (
        f"Over ({_xyz(start)}) the UAV would climb into {name}, {height_m:.1f} m high. It takes off to "
        f"{hover_m:g} m; move start:=."
    )


def _too_close(place: Sequence[float], distance_m: float, name: str, keep_m: float) -> str:
    at = _xyz(place)
    if distance_m <= 2.0 * _PROBE_RADIUS_M:
        return f"({at}), where the UAV is to fly, lies inside of {name}; choose another place."
    return (
        f"({at}), where the UAV is to fly, is {distance_m:.2f} m from {name}, and CEPA keeps {keep_m:g} m "
        "(r_lb) away; choose a place farther from it."
    )


def _too_low(place: Sequence[float], room: Vertical, stands_m: float) -> str:
    if room.is_below_ground:
        return f"({_xyz(place)}), where the UAV is to fly, lies below the ground; choose a height above it."
    height_m = abs(room.down_m)
    return (
        f"({_xyz(place)}), where the UAV is to fly, is {height_m:.2f} m above the ground. The UAV stands "
        f"{stands_m:.2f} m high, so it would touch the ground; choose a greater height."
    )


def _xyz(place: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in place)
