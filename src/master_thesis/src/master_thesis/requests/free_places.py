"""Checks that the start and the goals of a flight are free."""

from __future__ import annotations

from functools import partial
from typing import Callable, Sequence

from master_thesis.errors import ScenarioError
from master_thesis.worlds.scenario import Scenario
from simulation_tools.geometry import Pose

PENETRATION_M, LIFT_M = 0.02, 0.06
"""Greatest overlap that still counts as a touch; height over the ground for checking the UAV, because
physics puts a margin of 4 cm around terrain.
"""

_PROBE_RADIUS_M = 0.001
_PROBE = (
    '<sdf version="1.6"><model name="place"><static>true</static><link name="link"><collision name="point">'
    f"<geometry><sphere><radius>{_PROBE_RADIUS_M}</radius></sphere></geometry></collision></link></model></sdf>"
)


def check_course(
    scenario: Scenario, model: str, lidar: str, places_xyz_m: Sequence[tuple], keep_m: float
) -> None:
    """Check that the UAV does not start inside an obstacle, and that no place is too close to one.

    places_xyz_m: in `world`. keep_m: the avoidance's distance from obstacles (CEPA's r_LB), 0 if unknown.
    The UAV would never reach a nearer place. The ground plane is not an obstacle.

    Raises:
        ScenarioError: one sentence that names the obstacle.
        SimulationToolsError: the world or the UAV cannot be loaded.
    """
    # Physics takes a third of a second to import
    from simulation_tools.sdf.parser import load_world, parse_model
    from simulation_tools.vehicle.uav import load_uav
    from simulation_tools.world.shapes.meshes import standing_height_m
    from simulation_tools.world.world import PhysicsWorld

    world = PhysicsWorld(load_world(str(scenario.world_path)))
    try:
        obstacles = world.model_names()
        x, y, z, yaw = scenario.start_xyz_yaw
        uav = load_uav(model, lidar).model
        world.spawn(uav, "the UAV", Pose.identity())
        world.spawn(parse_model(_PROBE, "the place"), "place", Pose.identity())
        others = {"the UAV", "place", "ground_plane"}

        def distance_m(who: str, pose: Pose, within_m: float, but: frozenset[str] = frozenset()) -> float:
            return world.clearance(who, pose, within_m, ignore=others | but)

        lifted_m = z + standing_height_m(uav) + LIFT_M
        start = Pose.from_xyz_rpy(x, y, lifted_m, yaw=yaw) @ uav.pose
        if distance_m("the UAV", start, 0.1) < -PENETRATION_M:
            name = _nearest(obstacles, partial(distance_m, "the UAV", start, 0.1))
            raise ScenarioError(
                f"At ({x:g}, {y:g}, {z:g}) the UAV would start inside of {name}; move start:=."
            )
        for place in places_xyz_m:
            pose = Pose(tuple(place))
            found_m = distance_m("place", pose, keep_m + 1.0)
            if found_m < max(keep_m, _PROBE_RADIUS_M):
                name = _nearest(obstacles, partial(distance_m, "place", pose, keep_m + 1.0))
                raise ScenarioError(_too_close(place, found_m + _PROBE_RADIUS_M, name, keep_m))
    finally:
        world.close()


def _nearest(models: Sequence[str], distance_m: Callable[[frozenset], float]) -> str:
    everyone = frozenset(models)
    return min(models, key=lambda name: distance_m(everyone - {name}))


def _too_close(place: Sequence[float], distance_m: float, name: str, keep_m: float) -> str:
    at = ", ".join(f"{value:g}" for value in place)
    if distance_m <= 2.0 * _PROBE_RADIUS_M:
        return f"({at}), where the UAV is to fly, lies inside of {name}; choose another place."
    return (
        f"({at}), where the UAV is to fly, is {distance_m:.2f} m from {name}, and CEPA keeps {keep_m:g} m "
        "(r_lb) away; choose a place farther from it."
    )
