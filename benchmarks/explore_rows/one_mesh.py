"""Nine places of one mesh, explored without GNSS and without ROS: known share, height, clearance, end."""

from __future__ import annotations

import math
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.explore_rows.batteries import ENERGY
from benchmarks.explore_rows.meshes import PLACES, MeshPlace
from exploration.energy import EnergyWatch
from flights.exploring.agreement import home_height_off_m
from flights.exploring.flight import ExploringFlight
from flights.exploring.judge import judge_map
from flights.exploring.places import EXPLORER, TANK_ARRIVED_M, TANK_EXPLORER, TANK_PLANNER, TANK_UAV, Place
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Outcome, Phase
from flights.results.clearance import SPACING_M, clearances_along, least
from gridslam.cloud_odometry.cloud_odometry import FIRST_HEIGHT_S
from gridslam.evaluation.volume.doubled_surfaces import doubled_share
from gridslam.evaluation.volume.lidars import VIEWS
from gridslam.volume import FLAT_MISS, VolumeParameters
from simulation_tools.vehicle.energy.battery import BatteryStart

ROW = "one_mesh"
TIME_S = {"hall": 120.0, "double_bottom": 120.0}
LONGEST_S = 400.0
USUAL_S = 200.0
"""Of simulation; then the UAV flies home."""
JUDGED_MOST_M3 = 20_000.0
"""Of a larger box, the judge's voxels do not fit into the memory."""
HOME_M = 1.0


def place_of(name: str, drawn: MeshPlace, world: Path) -> Place:
    """Return how a place is explored: the double bottom by the small airframe, all else by the iris."""
    fine = VolumeParameters(resolution_m=0.1, max_range_m=20.0, miss=FLAT_MISS)
    box_m = drawn.low_m, drawn.high_m
    if name == "double_bottom":
        low = (TANK_PLANNER, TANK_EXPLORER, TANK_PLANNER.clearance_m, TANK_UAV, TANK_ARRIVED_M)
        return Place(world, (0.0, 0.0, 0.0), box_m, fine, *low)
    volume = replace(fine, resolution_m=0.2) if name == "hall" else fine
    return Place(world, (0.0, 0.0, 0.0), box_m, volume, explorer=EXPLORER)


def fly(name: str, seed: int) -> dict:
    """Explore a place once; return how it ended and what it knows."""
    drawn, time_s = PLACES[name](), TIME_S.get(name, USUAL_S)
    with tempfile.TemporaryDirectory() as folder:
        world = drawn.written_to(Path(folder))
        place = place_of(name, drawn, world)
        given, began_cpu_s = place.loop_parameters(world, seed, LONGEST_S), time.process_time()
        # Without a battery of the model the stand-in drains to 50 % within a minute, as PX4 SITL does.
        given = replace(given, simulation=replace(given.simulation, battery=BatteryStart()))
        with ClosedLoop(given) as loop:
            flight = ExploringFlight(
                loop, place.planner, place.explorer, place.volume, place.asked(time_s), EnergyWatch(ENERGY)
            )
            explored, outcome, log = flight.run(), loop.outcome, loop.log
            flown = {
                "name": name,
                "seed": seed,
                "ended": explored.end.value if explored.end else "",
                "reason": explored.reason,
                "end_s": explored.ended_s - outcome.times_s.get(Phase.FLYING, math.nan),
                "home_s": outcome.times_s.get(Phase.HOVERING, math.nan) - explored.ended_s,
                "home_reckoned_s": explored.way_home.time_s if explored.way_home else math.nan,
                "home_reckoned_m": explored.way_home.length_m if explored.way_home else math.nan,
                "contact": outcome.collision,
                "failure": outcome.failure or "",
                "known_m3": explored.known_m3[-1][1] if explored.known_m3 else 0.0,
                "views": explored.views,
                "decision_ms": float(1e3 * np.median(explored.cpu_s)) if explored.cpu_s else math.nan,
                "decision_max_ms": float(1e3 * max(explored.cpu_s)) if explored.cpu_s else math.nan,
                "flight_cpu_s": time.process_time() - began_cpu_s,
            }
            truth = log.truth.array("t_s", "x_m", "y_m", "z_m")
            odometry = log.odometry.array("t_s", "x_m", "y_m", "z_m")
            poses = log.between(*_flight_s(outcome, truth))
        home_s = outcome.times_s.get(Phase.HOVERING, explored.ended_s)
        flown["home_m"] = _way_m(truth, explored.ended_s, home_s)
        flown["height_error_m"] = height_error_m(odometry[:, (0, 3)], truth[:, (0, 3)])
        flown["height_uncertain_m"] = explored.height_uncertain_m
        flown["home_height_off_m"] = home_height_off_m(odometry) if outcome.landed else math.nan
        flown["doubled_share"] = doubled_share(flight.volume.corrected.voxels)
        is_home = outcome.landed and math.hypot(*truth[-1, 1:3]) < HOME_M
        box_m3 = float(np.prod(np.subtract(drawn.high_m, drawn.low_m)))
        uav = place.uav.model, place.uav.lidar
        clearances = clearances_along(poses, world, uav, outcome.ground, spacing_m=5.0 * SPACING_M)
        flown |= {"landed_home": bool(is_home), "clearance_m": least(clearances)}
        if box_m3 <= JUDGED_MOST_M3:
            rng = np.random.default_rng(seed)
            view = replace(VIEWS[place.uav.lidar], range_max_m=place.volume.max_range_m)
            hover_m = np.array((0.0, 0.0, min(1.5, given.publisher.hover_height_m)))
            judged = judge_map(flight.volume.shown, world, place.box_m, hover_m, place.clearance_m, view, rng)
            flown |= {"known_share": judged.known_share, "reachable_m3": judged.reachable_m3}
    return flown


def height_error_m(odometry: np.ndarray, truth: np.ndarray) -> float:
    """Return the greatest error of the height over the floor of the start, m.

    odometry, truth: (n, 2) time in s and height in m. That floor is 0 in all places. Odometry's first pose
    may come before the first range, and tells no height then.
    """
    known = odometry[odometry[:, 0] - odometry[0, 0] >= FIRST_HEIGHT_S]
    return float(np.abs(known[:, 1] - np.interp(known[:, 0], truth[:, 0], truth[:, 1])).max())


def _way_m(truth: np.ndarray, begin_s: float, end_s: float) -> float:
    """Return the length of the way of the UAV between two times, m, without its trembling."""
    times_s = np.append(np.arange(begin_s, end_s, 0.5), end_s)
    places_m = np.stack([np.interp(times_s, truth[:, 0], truth[:, axis]) for axis in (1, 2, 3)], axis=1)
    return float(np.linalg.norm(np.diff(places_m, axis=0), axis=1).sum())


def _flight_s(outcome: Outcome, truth: np.ndarray) -> tuple[float, float]:
    """Return when the UAV was flying, s."""
    begin_s = outcome.times_s.get(Phase.FLYING, float(truth[0, 0]))
    return begin_s, outcome.times_s.get(Phase.LANDING, float(truth[-1, 0]))
