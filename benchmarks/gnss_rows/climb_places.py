"""Places to fly to one by one, drawn in worlds where a lidar sees other things at each height."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Callable, Iterator

import numpy as np

from cepa import CepaParameters
from flights.exploring.places import HOLD_START_M, TANK_CEPA, TANK_START_M, WORLDS
from flights.flight.parameters import CEPA
from flights.worlds.ballast_tank import BallastTankParameters
from inspection_tools import Waypoint
from simulation_tools.world.rays import RayScene

LOWEST_XYZ_M, HIGHEST_XYZ_M = (-12.5, -7.5, 0.6), (12.5, 7.5, 8.6)
STEP_M = 0.4
"""The way is looked at every so far."""
TURNS_S = 4.0
"""At each place, for the turn and the braking."""
BEFORE_MANHOLE_M = 0.8
MANHOLE_TOLERANCE_M = 0.12
STAYS = 0.5
"""Chance that the next place in the tank is in the same compartment."""
Xyz = tuple[float, float, float]


@dataclass(frozen=True)
class Climb:
    """A world, and how a UAV flies in it.

    start_m: on the floor. room_m: nothing but the floor is nearer to a way between two places. drawn: yields
    endless places, by rays and a generator.
    """

    world: Path
    start_m: Xyz
    room_m: float
    speed_m_s: float
    drawn: Callable[[RayScene, np.random.Generator], Iterator[Waypoint]]
    model: str = "iris"
    cepa: CepaParameters = CEPA
    sensors: tuple[str, ...] = ("range_finder",)
    lidars: tuple[tuple[str, str], ...] = ()
    """What a lidar is called on this UAV, where that is another name."""

    def lidar(self, name: str) -> str:
        """Return the model of a lidar of this name."""
        return dict(self.lidars).get(name, name)

    def mission(self, rays: RayScene, rng: np.random.Generator, seconds: float) -> tuple[Waypoint, ...]:
        """Return places; the flight to all of them takes about so many seconds."""
        here, used_s, mission = np.array(self.start_m), 0.0, []
        for waypoint in self.drawn(rays, rng):
            if used_s >= seconds:
                break
            there = np.array(waypoint.position_m)
            used_s += float(np.linalg.norm(there - here)) / self.speed_m_s + TURNS_S
            mission.append(waypoint)
            here = there
        return tuple(mission)


def places_in_hold(rays: RayScene, rng: np.random.Generator) -> Iterator[Waypoint]:
    """Yield places of `hold_3d`, each seen from the one before it with room around the way."""
    here = np.array((*HOLD_START_M[:2], 2.0))
    while True:
        there = rng.uniform(LOWEST_XYZ_M, HIGHEST_XYZ_M)
        if is_open(rays, here, there, HOLD.room_m):
            yield Waypoint(_rounded(there))
            here = there


def places_in_tank(rays: RayScene, rng: np.random.Generator) -> Iterator[Waypoint]:
    """Yield places of `ballast_tank`, and the ways through its manholes."""
    tank, number = BallastTankParameters(), BallastTankParameters().compartments // 2
    here = np.array((*TANK_START_M[:2], 1.2))
    while True:
        if rng.random() > STAYS:
            bulkhead = int(
                rng.choice([each for each in (number - 1, number) if 0 <= each < tank.compartments - 1])
            )
            for waypoint in _through(tank, bulkhead, forward=bulkhead == number):
                yield waypoint
                here = np.array(waypoint.position_m)
            number += 1 if bulkhead == number else -1
        low, high = _inside(tank, number, TANK.room_m)
        for _ in range(1000):
            there = rng.uniform(low, high)
            if is_open(rays, here, there, TANK.room_m - 0.1):
                yield Waypoint(_rounded(there))
                here = there
                break


def _through(tank: BallastTankParameters, bulkhead: int, forward: bool) -> Iterator[Waypoint]:
    """Yield the places before, in and behind a manhole."""
    opening, x_m = tank.manhole(bulkhead), tank.bulkheads_x_m[bulkhead]
    y_m, z_m = 0.5 * sum(opening.across_m), 0.5 * sum(opening.height_m)
    side = 1.0 if forward else -1.0
    for along in (-BEFORE_MANHOLE_M, 0.0, BEFORE_MANHOLE_M):
        place = np.array((x_m + side * along, y_m, z_m))
        yield replace(Waypoint(_rounded(place)), tolerance_m=MANHOLE_TOLERANCE_M)


def _inside(tank: BallastTankParameters, number: int, room_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest place in a compartment, so far from its plates and stiffeners."""
    x_m = number * tank.compartment_m - tank.length_m / 2
    margin, stiff = np.array((room_m, room_m, room_m)), np.array((0.0, tank.stiffener_m, tank.stiffener_m))
    low = np.array((x_m, -tank.breadth_m / 2, 0.0)) + margin + stiff
    high = np.array((x_m + tank.compartment_m, tank.breadth_m / 2, tank.height_m)) - margin - stiff
    return low, high


def is_open(rays: RayScene, here: np.ndarray, there: np.ndarray, room_m: float) -> bool:
    """Return whether nothing but the floor is nearer than so much to the way."""
    steps = max(2, math.ceil(float(np.linalg.norm(there - here)) / STEP_M))
    directions = _all_around(300)
    for along in np.linspace(0.0, 1.0, steps):
        place = here + along * (there - here)
        ranges = rays.cast(place, directions, room_m)
        hits = place + directions * np.where(np.isfinite(ranges), ranges, 0.0)[:, None]
        if (np.isfinite(ranges) & (hits[:, 2] > 0.05)).any():
            return False
    return True


def _rounded(place: np.ndarray) -> Xyz:
    x, y, z = place.round(2).tolist()
    return x, y, z


def _all_around(number: int) -> np.ndarray:
    """Return unit vectors (number, 3), evenly spread: a spiral from pole to pole."""
    index = np.arange(number) + 0.5
    polar, azimuth = np.arccos(1.0 - 2.0 * index / number), math.pi * (1.0 + math.sqrt(5.0)) * index
    return np.column_stack((np.cos(azimuth) * np.sin(polar), np.sin(azimuth) * np.sin(polar), np.cos(polar)))


HOLD = Climb(WORLDS / "hold_3d.world", HOLD_START_M, 1.3, 2.0, places_in_hold)
TANK = Climb(
    WORLDS / "ballast_tank.world",
    TANK_START_M,
    0.45,
    0.8,
    places_in_tank,
    "small_quad",
    TANK_CEPA,
    ("range_finder", "range_finder_up"),
    (("puck", "near_puck"),),
)
CLIMBS = {"hold_3d": HOLD, "ballast_tank": TANK}
