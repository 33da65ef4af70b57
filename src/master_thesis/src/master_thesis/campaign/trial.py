"""Runs one trial and returns its row of the table: what was flown, and what came of it."""

from __future__ import annotations

import math
import tempfile
import time
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from cepa import ALGORITHMS, CepaParameters
from cepa.algorithm import Algorithm
from inspection_tools import PositionControllerParameters
from master_thesis.baselines import BASELINES
from master_thesis.campaign.axes import CEPA_PREFIX, Value, parameters_in
from master_thesis.campaign.campaign import Trial
from master_thesis.campaign.flying import Flight, fly_to_goal
from master_thesis.campaign.mapping import Mapped, fly_and_map
from master_thesis.campaign.places import place_of
from master_thesis.flight.closed_loop import CEPA, ClosedLoopParameters
from master_thesis.flight.course import PhaseLimits
from simulation_tools.simulation import SimulationParameters
from simulation_tools.vehicle.uav import load_uav

PATIENCE = 10.0
"""A flight is given up after this many times what its straight way takes at full speed."""
LIDAR_POWER_W = {"urg": 2.5, "ust": 3.6, "utm": 8.0, "puck": 8.0, "tim": 4.0, "m8": 15.0}
"""Thesis, table D.1; range, rate and weight stand in the lidars' SDF files."""
SENTENCE_MAX = 300


@dataclass(frozen=True)
class LidarFigures:
    """What a lidar's data sheet says."""

    lidar_range_m: float
    lidar_rate_hz: float
    lidar_weight_kg: float
    lidar_power_w: float


@dataclass(frozen=True)
class FlightOutcome:
    """The figures of a flight to a goal, as columns of the table."""

    reached: bool
    collision: bool
    stuck: bool
    flight_time_s: float
    time_over_straight: float
    path_length_m: float
    min_clearance_m: float
    emergencies: int
    mass_kg: float

    def columns(self) -> dict:
        """Return all figures by column."""
        return asdict(self)


@dataclass(frozen=True)
class Cost:
    """What a trial took of the machine that ran it, which differs from run to run."""

    index: int
    wall_s: float
    cpu_s: float


def run_trial(trial: Trial) -> tuple[dict[str, Any], Cost]:
    """Return a trial's row and its cost; a trial that fails is a row too, with the sentence in `error`."""
    wall, cpu = time.perf_counter(), time.process_time()
    row: dict[str, Any] = {"index": trial.index, "replicate": trial.replicate, **trial.settings}
    try:
        row.update(asdict(lidar_figures(trial.settings["lidar"], trial.settings["lidar_range_m"])))
        row.update((_flown(trial) if trial.kind == "flight" else _mapped(trial)).columns())
    except Exception as error:
        said = " ".join(str(error).split())[:SENTENCE_MAX]
        row["error"] = said if said.endswith(".") else f"{type(error).__name__}: {said}"
    cost = Cost(trial.index, time.perf_counter() - wall, time.process_time() - cpu)
    return row, cost


def _flown(trial: Trial) -> FlightOutcome:
    settings = trial.settings
    place = place_of(settings, trial.place_seed)
    cepa = replace(CEPA, **parameters_in(settings, CEPA_PREFIX))
    speed_m_s = settings["speed_m_s"]
    straight_s = place.distance_m / speed_m_s
    with tempfile.TemporaryDirectory() as folder:
        parameters = ClosedLoopParameters(
            _simulation(trial, place.world_file(Path(folder))),
            goal_xyz_m=(place.distance_m, 0.0, settings["height_m"]),
            position_controller=PositionControllerParameters(max_speed=speed_m_s),
            limits=PhaseLimits(flight_timeout_s=PATIENCE * straight_s),
        )
        flight = fly_to_goal(parameters, steering(settings["algorithm"], cepa))
    return outcome_of(flight, straight_s)


def _mapped(trial: Trial) -> Mapped:
    place = place_of(trial.settings, trial.place_seed)
    with tempfile.TemporaryDirectory() as folder:
        return fly_and_map(trial, _simulation(trial, place.world_file(Path(folder))))


def _simulation(trial: Trial, world: Path) -> SimulationParameters:
    settings = trial.settings
    return SimulationParameters(
        world=str(world),
        lidar=settings["lidar"],
        lidar_range_max_m=settings["lidar_range_m"] or 0.0,
        seed=trial.noise_seed,
    )


def steering(name: str, cepa: CepaParameters) -> Algorithm:
    """Return an algorithm or baseline by its name in campaigns."""
    return {**ALGORITHMS, **BASELINES}[name](cepa)


def outcome_of(flight: Flight, straight_s: float) -> FlightOutcome:
    """Return a flight's figures; straight_s: the time that its straight way takes at full speed."""
    return FlightOutcome(
        reached=flight.end == "goal",
        collision=flight.end == "collision",
        stuck=flight.end == "stuck",
        flight_time_s=flight.time_s,
        time_over_straight=flight.time_s / straight_s,
        path_length_m=flight.path_length_m,
        min_clearance_m=flight.clearance_m,
        emergencies=flight.emergencies,
        mass_kg=flight.mass_kg,
    )


def lidar_figures(lidar: str, range_m: Value | None = None) -> LidarFigures:
    """Return what the lidar's SDF and data sheet say; range_m: in place of its own."""
    figures = _lidar_figures(lidar)
    return figures if range_m is None else replace(figures, lidar_range_m=float(range_m))


@lru_cache(maxsize=None)
def _lidar_figures(lidar: str) -> LidarFigures:
    carried, bare = (load_uav("iris", name) for name in (lidar, None))
    sensor = carried.lidar.sensor
    weight_kg = _mass_kg(carried.model) - _mass_kg(bare.model)
    figures = sensor.range_max_m, sensor.update_rate_hz, round(weight_kg, 6), LIDAR_POWER_W[lidar]
    return LidarFigures(*map(float, figures))


def _mass_kg(model) -> float:
    return math.fsum(link.inertial.mass_kg for link in model.links)
