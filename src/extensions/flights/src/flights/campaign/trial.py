"""Flies one case of a campaign, and returns what came of it."""

from __future__ import annotations

import math
import tempfile
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Callable, Mapping, Sequence

import numpy as np

from cepa import ALGORITHMS, CepaParameters, KeepOut, KeepOutBox
from cepa.algorithm import Algorithm
from cepa.keep_out import MapPose
from cepa.steering.answering import RANGE_FINDERS
from flights.baselines import BASELINES
from flights.campaign.axes import CEPA_PREFIX, parameters_in
from flights.campaign.campaign import PATIENCE, Case
from flights.campaign.flying import Flight, fly_to_goal
from flights.campaign.mapping import MAP_METRICS, fly_and_map
from flights.campaign.places import place_of
from flights.campaign.sinking_load import could_be_avoided, load_in, uav_of
from flights.flight.conditions import BOUNDS, Conditions
from flights.flight.course import PhaseLimits
from flights.flight.parameters import CEPA, ClosedLoopParameters
from flights.worlds.drawn.movers import SINKING
from inspection_tools import PositionControllerParameters
from simulation_tools.geometry import Pose, rotation_matrix
from simulation_tools.sdf.elements import Model, RaySensor
from simulation_tools.simulation import SimulationParameters
from simulation_tools.vehicle.energy.battery_plugins import power_load_w
from simulation_tools.vehicle.uav import load_uav

_OF_WAY = ("path_length_m", "min_clearance_m", "emergencies", "mass_kg")
COLUMNS = {
    "flight": (
        "reached",
        "collision",
        "unavoidable",
        "stuck",
        "flight_time_s",
        "time_over_straight",
        *_OF_WAY,
    ),
    "mapping": ("mapped", "collision", "stuck", "flight_time_s", *_OF_WAY, *MAP_METRICS),
}
"""What came of a trial, by the campaign's kind."""


@dataclass(frozen=True)
class LidarData:
    """What a lidar's data sheet says."""

    lidar_range_m: float
    lidar_rate_hz: float
    lidar_weight_kg: float
    lidar_power_w: float


def run_case(case: Case) -> dict[str, Any]:
    """Fly a case; return the columns of its row that the settings do not hold.

    Raises:
        FlightsError, CepaError, SlamError, SimulationToolsError: it cannot be flown or judged.
    """
    data = lidar_data(case.settings["lidar"], case.settings["lidar_range_m"])
    return {**asdict(data), **(_flown(case) if case.kind == "flight" else _mapped(case))}


def _flown(case: Case) -> dict[str, Any]:
    settings = case.settings
    place = place_of(settings, case.place_seed)
    cepa = replace(CEPA, **parameters_in(settings, CEPA_PREFIX))
    speed_m_s = settings["speed_m_s"]
    straight_s = place.distance_m / speed_m_s
    with tempfile.TemporaryDirectory() as folder:
        world = place.world_file(Path(folder))
        parameters = ClosedLoopParameters(
            _simulation(case, world),
            goal_xyz_m=(place.distance_m, 0.0, settings["height_m"]),
            position_controller=PositionControllerParameters(max_speed=speed_m_s),
            limits=PhaseLimits(flight_timeout_s=PATIENCE * straight_s),
            conditions=Conditions(**{name: settings[name] for name in BOUNDS}),
            range_finders=settings["range_finders"],
        )
        algorithm = steering(settings["algorithm"], cepa)
        keep_out = KeepOut(place.keep_out)
        algorithm.take_keep_out(keep_out)
        listeners = [ExactMap(keep_out)] if place.keep_out else []
        flight = fly_to_goal(parameters, algorithm, place.stuck_s, listeners)
        unavoidable = flight.end == "collision" and _is_unavoidable(flight, settings, world, cepa)
    if entered(flight.poses, place.keep_out, cepa.body_radius):
        flight = replace(flight, end="collision")
    return {**outcome_of(flight, straight_s), "unavoidable": unavoidable}


def _is_unavoidable(flight: Flight, settings: Mapping[str, Any], world: Path, cepa: CepaParameters) -> bool:
    """Return whether no command could have avoided a load that came down; False where none did."""
    load = load_in(world) if settings["world"] == SINKING else None
    if load is None:
        return False
    model = settings.get("model", "iris")
    uav = uav_of(model, settings["lidar"], settings["range_finders"], cepa.response)
    return not could_be_avoided(flight.poses, load, uav)


class ExactMap:
    """Places keep-out boxes in the odometry's frame as a SLAM without error does.

    Without it the odometry's drift, and not CEPA, would decide how far the UAV stays away from them.
    """

    def __init__(self, keep_out: KeepOut) -> None:
        self._keep_out = keep_out

    def on_scan(self, t_s: float, ranges: np.ndarray, odometry: Pose, truth: Pose) -> None:
        """Take the poses of an instant in `odom` and in `world`, which is the map."""
        told, true = (rotation_matrix(pose.orientation_xyzw) for pose in (odometry, truth))
        turn = true @ told.T
        self._keep_out.map_pose = MapPose(turn, truth.position_m - turn @ odometry.position_m)


def entered(poses: np.ndarray, boxes: Sequence[KeepOutBox], radius_m: float) -> bool:
    """Return whether a body on poses (n, 8: t, position, quaternion) was in a box in the plan."""
    for box in boxes:
        low, high = np.array(box.low_m[:2]), np.array(box.high_m[:2])
        apart_m = np.maximum(0.0, np.maximum(low - poses[:, 1:3], poses[:, 1:3] - high))
        if np.hypot(*apart_m.T).min() < radius_m:
            return True
    return False


def _mapped(case: Case) -> dict[str, Any]:
    place = place_of(case.settings, case.place_seed)
    with tempfile.TemporaryDirectory() as folder:
        return fly_and_map(case, _simulation(case, place.world_file(Path(folder))))


def _simulation(case: Case, world: Path) -> SimulationParameters:
    settings = case.settings
    return SimulationParameters(
        world=str(world),
        lidar=settings["lidar"],
        model=settings.get("model", "iris"),
        lidar_range_max_m=settings["lidar_range_m"] or 0.0,
        sensors=RANGE_FINDERS if settings.get("range_finders") else (),
        seed=case.noise_seed,
    )


def steering(name: str, cepa: CepaParameters) -> Algorithm:
    """Return an algorithm or baseline by its name in campaigns."""
    known: dict[str, Callable[[CepaParameters], Algorithm]] = {**ALGORITHMS, **BASELINES}
    return known[name](cepa)


def outcome_of(flight: Flight, straight_s: float) -> dict[str, Any]:
    """Return what came of a flight. straight_s: time of the straight way at full speed.

    computation_ms is every tenth of the algorithm's computation times in ascending order. It is not a column,
    because it differs from run to run.
    """
    return {
        "reached": flight.end == "goal",
        **flight.columns(),
        "time_over_straight": flight.time_s / straight_s,
        "computation_ms": thinned_times(flight.computation_ms),
    }


def thinned_times(times_ms: np.ndarray | Sequence[float]) -> list[float]:
    """Return every tenth of some computation times in ascending order."""
    return [float(value) for value in np.sort(times_ms)[5::10]]


def lidar_data(lidar: str, range_m: float | None = None) -> LidarData:
    """Return what the lidar's SDF says. range_m: replaces its own range."""
    data = _lidar_data(lidar)
    return data if range_m is None else replace(data, lidar_range_m=range_m)


@cache
def _lidar_data(lidar: str) -> LidarData:
    carried, bare = (load_uav("iris", name) for name in (lidar, None))
    assert carried.lidar is not None
    sensor = carried.lidar.sensor
    assert isinstance(sensor, RaySensor)
    weight_kg = _mass_kg(carried.model) - _mass_kg(bare.model)
    load_w = power_load_w(carried.model) - power_load_w(bare.model)
    data = sensor.range_max_m, sensor.update_rate_hz, round(weight_kg, 6), round(load_w, 6)
    return LidarData(*map(float, data))


def _mass_kg(model: Model) -> float:
    return math.fsum(link.inertial.mass_kg for link in model.links)
