"""Experiments 3 and 4 without GNSS: the UAV flies by its lidar, IMU and range finder, with every lidar.

The whole chain without ROS: the flight controller's stand-in with its Kalman filter, odometry from the lidar,
SLAM with loop closure beside it, and the mission in `map`, followed as slowly as the nodes do. A flight
depends on its seed alone. The table has medians and the worst of the seeds.

`landed_off_m` is the distance from the last waypoint, in the hold its start. The flight in the room ends
after a time, wherever the UAV is, and has none.

Keys: gnss_denied.WORLD.LIDAR.{flown, contacts, landed_off_m, ate_m, odometry_ate_m, path_p95_m, height_p95_m,
cpu_ms}, each but the first two with .median and .worst.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Sequence

import numpy as np

from benchmarks.shared.results import Results, table
from benchmarks.shared.trials import run_all, trial_options
from gridslam.odometry.warm_up import warm_up_odometry
from gridslam.warm_up import warm_up
from inspection_tools.correction import SlowCorrection
from master_thesis.experiments_3_4.mapping_flight import SCENARIOS, parameters_of
from master_thesis.experiments_3_4.slam_run import SlamParticipant
from master_thesis.experiments_3_4.slam_setup import read_setup
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.flight_recording import LidarGeometry
from master_thesis.trials.trial import Trial
from master_thesis.worlds.scenario import LIDARS
from simulation_tools.geometry import Pose, Vector3

WORLDS = ("room", "hold")
SEEDS = (1, 2, 3, 4, 5)
BRIEF_SEEDS = (1,)
METRICS = {
    "landed_off_m": "landed off the last waypoint [m]",
    "ate_m": "ATE of the pose flown by [m]",
    "odometry_ate_m": "ATE of odometry [m]",
    "path_p95_m": "off the path, 95 % [m]",
    "height_p95_m": "height, 95 % [m]",
    "cpu_ms": "odometry's CPU/scan [ms]",
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    parser = trial_options(__doc__ or "")
    parser.add_argument("--seeds", nargs="+", type=int, default=None)
    parser.add_argument("--worlds", nargs="+", default=WORLDS, choices=WORLDS)
    parser.add_argument("--lidars", nargs="+", default=LIDARS, choices=LIDARS)
    given = parser.parse_args(arguments)
    seeds = given.seeds or (BRIEF_SEEDS if given.brief else SEEDS)
    cases = list(itertools.product(given.worlds, given.lidars))
    flights = [(*case, seed) for case in cases for seed in seeds]
    trials = [
        Trial(" ".join(map(str, flight)), fly, dict(zip(("world", "lidar", "seed"), flight)))
        for flight in flights
    ]
    with Results("gnss_denied", given.results, vars(given)) as results:
        found = list(run_all("gnss_denied", trials, given))
        rows = []
        for i, (world, lidar) in enumerate(cases):
            numbers = summary(found[i * len(seeds) : (i + 1) * len(seeds)])
            results.add(f"gnss_denied.{world}.{lidar}", numbers)
            rows.append((world, lidar, *_cells(numbers, len(seeds))))
        print(table(("world", "lidar", "flown", "contacts", *METRICS.values()), rows))


def fly(world: str, lidar: str, seed: int) -> dict:
    """Fly once and return the metrics."""
    warm_up()
    warm_up_odometry()
    parameters = parameters_of(world, lidar, seed)
    parameters = replace(
        parameters,
        simulation=replace(parameters.simulation, sensors=("range_finder",), gnss=False),
        pose_source="odometry",
        publisher=replace(parameters.publisher, needs_home=False),
    )
    with ClosedLoop(parameters) as loop:
        own = loop.own_odometry
        assert own is not None  # there is no GNSS
        session = read_setup(world).session(seed, loop_closure=True)
        slam = SlamParticipant(session, LidarGeometry.of(loop.lidar))
        loop.listeners.append(slam)
        pose = SlamPose(slam)
        loop.correct = pose.of
        outcome = loop.run()
        truth = np.array(loop.log.truth.rows)
        estimates = np.array([(e.stamp_s, *e.position_xyz) for e in own.estimates])
        cpu_ms = float(np.mean(own.cpu_ms))
    way = np.array([SCENARIOS[world].start_xyz_yaw[:2], *(w.position_m[:2] for w in parameters.mission)])
    in_air = truth[:, 3] > 0.8 * SCENARIOS[world].flight_height_m
    off, flown_by = _errors(estimates, truth), _errors(np.array(pose.rows), truth)
    return {
        "flown": outcome.reached_goal and outcome.landed,
        "contact": outcome.collision,
        "failure": outcome.failure,
        "landed_off_m": None if math.isfinite(parameters.duration_s) else math.dist(truth[-1, 1:3], way[-1]),
        "ate_m": _rms(np.hypot(*flown_by[:, :2].T)),
        "odometry_ate_m": _rms(np.hypot(*off[:, :2].T)),
        "path_p95_m": float(np.percentile(distances(truth[in_air, 1:3], way), 95)),
        "height_p95_m": float(np.percentile(np.abs(off[:, 2]), 95)),
        "cpu_ms": cpu_ms,
    }


class SlamPose:
    """The pose in `map` that the mission is flown by. rows: time in s and position, of every odometry."""

    def __init__(self, slam: SlamParticipant) -> None:
        self._slam, self._slow = slam, SlowCorrection()
        self.rows: list[tuple[float, ...]] = []

    def of(self, t_s: float, pose: Pose) -> tuple[Vector3, float]:
        """Return position and heading in `map` of a pose in `odom`."""
        x, y, yaw = self._slam.session.map_to_odom or (0.0, 0.0, 0.0)
        turn = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
        position_m, yaw_rad = self._slow.apply(t_s, (pose.position_m, pose.yaw_rad), (x, y, 0.0), turn)
        self.rows.append((t_s, *position_m))
        return position_m, yaw_rad


def distances(points_xy: np.ndarray, way_xy: np.ndarray) -> np.ndarray:
    """Return (n,) distances of points (n, 2) from a way of straight lines (k, 2)."""
    begin, along = way_xy[:-1], np.diff(way_xy, axis=0)
    length2 = np.maximum((along**2).sum(axis=1), 1e-12)
    to_points = points_xy[:, None] - begin
    share = np.clip((to_points * along).sum(axis=2) / length2, 0.0, 1.0)
    return np.hypot(*np.moveaxis(to_points - share[..., None] * along, 2, 0)).min(axis=1)


def summary(trials: Sequence[dict]) -> dict:
    """Return how many flights were flown and had a contact, and median and worst of each metric."""
    return {
        "flown": sum(trial["flown"] for trial in trials),
        "contacts": sum(trial["contact"] for trial in trials),
        "seeds": len(trials),
        **{key: _spread([trial[key] for trial in trials]) for key in METRICS},
    }


def _spread(values: Sequence[float | None]) -> dict[str, float] | None:
    known = [value for value in values if value is not None]
    return {"median": float(np.median(known)), "worst": max(known)} if known else None


def _cells(numbers: dict, seeds: int) -> tuple:
    spread = ("{median:.3f} ({worst:.3f})".format(**numbers[key]) if numbers[key] else "-" for key in METRICS)
    return f"{numbers['flown']} of {seeds}", numbers["contacts"], *spread


def _errors(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Return (n, 3) found less true positions; both rows begin with the time."""
    return found[:, 1:4] - np.column_stack(
        [np.interp(found[:, 0], truth[:, 0], truth[:, i]) for i in (1, 2, 3)]
    )


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


if __name__ == "__main__":
    main()
