"""A wrong start on a known map: how soon gridslam says that it is lost, and how soon it finds the UAV.

A flight of Experiment 3 or 4 is flown once in the ROS-free closed loop and mapped. Then it is localised on
that map (`localisation_only`), each time from another moment of the flight and from a start 7 m off, turned
by up to 0.5 rad. Travel is that of odometry, at every eighth scan; CPU time is that of the thread while lost.

Keys: slam.lost.WORLD.LIDAR.{starts, lost_after_m_worst, found_after_m_median, found_after_m_worst, not_found,
false_places, cpu_s_worst}. A place is false if the UAV is more than 0.5 m from it.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Sequence

import numpy as np

from benchmarks.shared.results import Results, table
from benchmarks.shared.trials import run_crossed, trial_options
from flights.mapping.mapping_flight import parameters_of
from flights.mapping.slam_run import SlamParticipant
from gridslam import OccupancyGrid, se2
from gridslam.session import SlamSession
from gridslam.tracking.monitor import LOST, TRACKING
from gridslam.warm_up import warm_up
from master_thesis.experiments_3_4.map_variants import MappedFlight

WORLDS, LIDARS = ("room", "hold"), ("urg", "ust")
STARTS, BRIEF_STARTS = 30, 5
OFF_M, TURNED_RAD = 7.0, 0.5
EVERY = 8
WAY_M = 45.0
"""Travel after which a start counts as not found."""
FALSE_M = 0.5


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, get lost, print and write."""
    given = trial_options(__doc__ or "").parse_args(arguments)
    axes = {"world": WORLDS, "lidar": LIDARS, "starts": (BRIEF_STARTS if given.brief else STARTS,)}
    with Results("slam_lost", given.results, vars(given)) as results:
        found = run_crossed("slam_lost", measure, given, **axes)
        for (world, lidar, _), metrics in found.items():
            results.add(f"slam.lost.{world}.{lidar}", metrics)
        names = list(next(iter(found.values())))
        rows = [(*case[:2], *(_words(metrics[name]) for name in names)) for case, metrics in found.items()]
        print(table(("world", "lidar", *names), rows))


def measure(world: str, lidar: str, starts: int, seed: int = 1) -> dict:
    """Fly and map once, and localise from wrong starts; return the metrics."""
    warm_up()
    flight = MappedFlight.fly(world, lidar, seed, parameters_of(world, lidar, seed))
    grid = flight.map(seed, loop_closure=False).grid
    rng = np.random.default_rng(seed)
    runs = [Start(flight, grid, rng).run(seed) for _ in range(starts)]
    found = [run["found_m"] for run in runs if run["found_m"] is not None]
    return {
        "starts": starts,
        "lost_after_m_worst": max(run["lost_m"] for run in runs),
        "found_after_m_median": float(np.median(found)) if found else None,
        "found_after_m_worst": max(found, default=None),
        "not_found": starts - len(found),
        "false_places": sum(run["error_m"] > FALSE_M for run in runs if run["found_m"] is not None),
        "cpu_s_worst": max(run["cpu_s"] for run in runs),
    }


class Start:
    """A wrong start somewhere on a flight's map, drawn at random."""

    def __init__(self, flight: MappedFlight, grid: OccupancyGrid, rng: np.random.Generator) -> None:
        self._flight, self._grid = flight, grid
        self._scans = list(flight.recording)[::EVERY]
        positions = np.array([odometry.position_m[:2] for _, _, odometry, _ in self._scans])
        steps = np.hypot(*np.diff(positions, axis=0).T)
        self._way_m = np.concatenate([[0.0], np.cumsum(steps)])
        self._first = int(rng.integers(0, np.searchsorted(self._way_m, self._way_m[-1] - 0.5 * WAY_M)))
        low, size = np.array(grid.origin_xy_m), np.array(grid.size_m)
        while True:
            angle, turned = rng.uniform(-math.pi, math.pi), rng.uniform(-TURNED_RAD, TURNED_RAD)
            offset = (OFF_M * math.cos(angle), OFF_M * math.sin(angle), turned)
            self._pose = self._truth(self._first) + offset
            if ((self._pose[:2] > low) & (self._pose[:2] < low + size)).all():
                break

    def _truth(self, index: int) -> np.ndarray:
        truth = self._flight.truth
        nearest = int(np.abs(truth.stamps_s - self._scans[index][0]).argmin())
        return truth.poses_in_map[nearest]

    def run(self, seed: int) -> dict:
        """Return travel until lost and found (None: never), the error when found, and the CPU time."""
        session = SlamSession(
            replace(self._flight.setup.parameters, seed=seed, threads=1),
            starting_map=self._grid,
            starting_pose=tuple(self._pose.tolist()),
            localisation_only=True,
            say=lambda words: None,
        )
        participant = SlamParticipant(session, self._flight.recording.lidar)
        run: dict = {"lost_m": math.inf, "found_m": None, "error_m": math.nan, "cpu_s": 0.0}
        for index in range(self._first, len(self._scans)):
            way_m = float(self._way_m[index] - self._way_m[self._first])
            begun_s = time.thread_time()
            participant.on_scan(*self._scans[index])
            if session.tracking is None or way_m > WAY_M:
                break
            if session.tracking.state == LOST:
                run["cpu_s"] += time.thread_time() - begun_s
                run["lost_m"] = min(run["lost_m"], way_m)
            elif session.tracking.state == TRACKING and run["lost_m"] < math.inf:
                assert session.slam is not None
                error = se2.between(session.slam.base_in_map, self._truth(index))
                return {**run, "found_m": way_m, "error_m": float(np.hypot(*error[:2]))}
        return run


def _words(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


if __name__ == "__main__":
    main()
