"""Flights through random forests: how each is drawn, flown and judged.

A trial's forest and noise are fixed by its number alone, so that it does not matter which process flies it,
and every algorithm and variant meets the same forests.
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.stats import chi2

from cepa import CepaParameters
from inspection_tools import PositionControllerParameters
from master_thesis.campaign.axes import DRAWN_DISTANCE_M
from master_thesis.campaign.flying import fly_to_goal
from master_thesis.campaign.places import forest_sdf, plant
from master_thesis.flight.closed_loop import CEPA, ClosedLoopParameters
from master_thesis.flight.course import PhaseLimits
from simulation_tools.simulation import SimulationParameters

SEED = 20
SPEEDS_M_S = (2.0, 1.0, 3.0, 4.0)
"""In the order in which the forests take turns."""
GOAL_X_M = DRAWN_DISTANCE_M
SPACINGS_M = (2.0, 4.0)
"""Least distance between trunks' middles, drawn for each forest: from 2 to 4 m, 0.16 to 0.04 trees per m2."""
VARIANTS = {
    "": CEPA,
    "velocity_aware": replace(CEPA, velocity_aware_emergency=True),
    "levelling": replace(CEPA, levelling=True),
}
"""What is flown besides the defaults: each extension that is off by default, on."""


@dataclass(frozen=True)
class Trial:
    """One flight to be flown. number: of its forest. variant: of `VARIANTS`. height_m: of the goal."""

    number: int
    algorithm: str
    speed_m_s: float
    variant: str = ""
    height_m: float = 2.0

    @property
    def name(self) -> str:
        """What flies: the algorithm, with its variant if it is one."""
        return f"{self.algorithm}_{self.variant}" if self.variant else self.algorithm

    @property
    def forest(self) -> np.ndarray:
        """The trunks (n, 3): x, y, radius in m."""
        return draw_forest(np.random.default_rng(np.random.SeedSequence((SEED, self.number))))


@dataclass(frozen=True)
class Flown:
    """What came of a trial. distance_m: true way from the goal's sending to goal, contact or giving up."""

    trial: Trial
    end: str
    """"goal", "collision" or "stuck"."""
    distance_m: float
    time_s: float
    clearance_m: float
    """Least distance between the UAV's middle and a trunk's surface."""
    emergencies: int
    """Scans that were answered by the emergency avoidance."""
    path_xy: np.ndarray
    """(k, 2) m, ten times a second."""


def draw_forest(rng: np.random.Generator) -> np.ndarray:
    """Return trunks (n, 3: x, y, radius): as many as their spacing, drawn too, leaves room for."""
    return plant(rng, rng.uniform(*SPACINGS_M))


def fly(trial: Trial, cepa: CepaParameters | None = None) -> Flown:
    """Fly a trial to its end. cepa: other parameters than the variant's."""
    trunks = trial.forest
    with tempfile.TemporaryDirectory() as folder:
        world = Path(folder) / "forest.world"
        world.write_text(forest_sdf(trunks), encoding="utf-8")
        flight = fly_to_goal(_parameters(trial, world, cepa or VARIANTS[trial.variant]))
    xy = flight.poses[:, 1:3]
    gaps = np.hypot(*(xy[:, None, :] - trunks[None, :, :2]).transpose(2, 0, 1)) - trunks[:, 2]
    return Flown(
        trial,
        flight.end,
        distance_m=flight.path_length_m,
        time_s=flight.time_s,
        clearance_m=float(gaps.min(initial=math.inf)),
        emergencies=flight.emergencies,
        path_xy=xy[::12],
    )


def _parameters(trial: Trial, world: Path, cepa: CepaParameters) -> ClosedLoopParameters:
    return ClosedLoopParameters(
        SimulationParameters(world=str(world), seed=trial.number),
        goal_xyz_m=(GOAL_X_M, 0.0, trial.height_m),
        algorithm=trial.algorithm,
        cepa=cepa,
        position_controller=PositionControllerParameters(max_speed=trial.speed_m_s),
        limits=PhaseLimits(flight_timeout_s=10.0 * GOAL_X_M / trial.speed_m_s),
    )


def rate_interval(events: int, exposure: float, confidence: float = 0.95) -> tuple[float, float]:
    """Return the exact (Garwood 1936) confidence interval of a Poisson rate: events per unit of exposure."""
    tail = (1.0 - confidence) / 2.0
    low = chi2.ppf(tail, 2 * events) / 2.0 if events else 0.0
    return float(low / exposure), float(chi2.ppf(1.0 - tail, 2 * events + 2) / 2.0 / exposure)


def figures(flown: list[Flown]) -> dict:
    """Return what a set of flights amounts to."""
    kilometres = 1e-3 * sum(flight.distance_m for flight in flown)
    collisions = sum(flight.end == "collision" for flight in flown)
    arrived = [flight for flight in flown if flight.end == "goal"]
    times = [flight.time_s for flight in arrived]
    straight = [flight.time_s * flight.trial.speed_m_s / GOAL_X_M for flight in arrived]
    return {
        "flights": len(flown),
        "distance_km": kilometres,
        "collisions": collisions,
        "collisions_per_km": collisions / kilometres,
        "collisions_per_km_95": rate_interval(collisions, kilometres),
        "stuck": sum(flight.end == "stuck" for flight in flown) / len(flown),
        "reached": len(arrived) / len(flown),
        "time_to_goal_s": {"mean": np.mean(times), "std": np.std(times)} if times else None,
        "time_over_straight": float(np.median(straight)) if straight else None,
        "clearance_m": {
            "least": min(flight.clearance_m for flight in flown),
            "median": float(np.median([flight.clearance_m for flight in flown])),
        },
        "flights_with_emergency": sum(flight.emergencies > 0 for flight in flown) / len(flown),
    }
