"""Climbs without GNSS in worlds whose slices change with the height: drawn places are flown to one by one.

In `hold_3d` deck beams, coaming, frames and stanchions change what a level lidar sees; in `ballast_tank`
stiffeners and manholes do. Odometry is compared with the truth as it is: both begin at the same place, and
nothing is aligned. The flight does not use SLAM, which follows it with other libraries that may do so. All
figures end where the landing begins: a drawn place may be over a stiffener, on which a UAV falls over.
"""

from __future__ import annotations

from typing import Sequence

import numpy as np

from benchmarks.gnss_rows.beside import Beside
from benchmarks.gnss_rows.climb_places import CLIMBS, Climb
from benchmarks.gnss_rows.slam_beside import SlamBeside
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.parameters import ClosedLoopParameters
from gridslam.cloud_odometry.warm_up import warm_up_cloud_odometry
from gridslam.odometry.warm_up import warm_up_odometry
from inspection_tools import PositionControllerParameters, Waypoint
from simulation_tools.geometry import Pose
from simulation_tools.sensors.cloud import Cloud, CloudLidar
from simulation_tools.simulation import SimulationParameters, StepOutput

METRICS = (
    "ate_m",
    "worst_m",
    "height_p95_m",
    "cpu_ms",
    "cpu_p99_ms",
    "slam_ate_m",
    "slam_worst_m",
    "slam_height_p95_m",
    "closures",
)
BESIDE_METRICS = ("ate_m", "worst_m", "aligned_m", "cpu_ms")


def fly(
    lidar: str, seed: int, minutes: float = 10.0, world: str = "hold_3d", beside: Sequence[str] = ()
) -> dict:
    """Fly about so many minutes; return the errors of the odometry in m, and its CPU time for each cloud.

    ate_m: root mean square. worst_m: the greatest. height_p95_m: of the height, 95 %. remarks: estimates
    that told a doubt. silent_m: the greatest error without a remark in the second before. slam_ate_m,
    slam_worst_m: of SLAM's poses, level. slam_height_p95_m: of its height. closures: loops that it closed.
    beside: names of `beside.NAMES`.
    """
    warm_up_odometry()
    warm_up_cloud_odometry()
    climb, libraries = CLIMBS[world], [Beside(name) for name in beside]
    with ClosedLoop(parameters_of(climb, lidar, seed)) as empty:
        rays = empty.simulation.world.rays
        mission = climb.mission(rays, np.random.default_rng(seed), 60.0 * minutes)
    with ClosedLoop(parameters_of(climb, lidar, seed, mission)) as loop:
        slam = SlamBeside(loop, seed)
        loop.listeners.append(slam)
        while not loop.is_over:
            output = loop.step()
            if loop.monitor.course.has_begun(Phase.LANDING):
                loop.listeners.clear()
            else:
                _tell(libraries, output)
        outcome, known = loop.outcome, loop.log.truth.array("t_s", "x_m", "y_m", "z_m")
        assert loop.own_odometry is not None  # there is no GNSS
        until_s = outcome.times_s.get(Phase.LANDING, np.inf)
        estimates = [each for each in loop.own_odometry.estimates[1:] if each.stamp_s < until_s]
        cpu_ms = loop.own_odometry.cpu_ms[: len(estimates)]
    times_s = np.array([estimate.stamp_s for estimate in estimates])
    found = np.array([estimate.position_xyz for estimate in estimates])
    off = found - np.column_stack([np.interp(times_s, known[:, 0], known[:, axis]) for axis in (1, 2, 3)])
    off_m = np.linalg.norm(off, axis=1)
    told = np.array([bool(estimate.remark) for estimate in estimates])
    return {
        "flown": outcome.reached_goal and outcome.landed,
        "contact": outcome.collision,
        "failure": outcome.failure,
        "places": len(mission),
        "minutes": float(times_s[-1] / 60.0),
        "remarks": int(told.sum()),
        "ate_m": float(np.sqrt(np.square(off_m).mean())),
        "worst_m": float(off_m.max()),
        "silent_m": silent_m(times_s, off_m, told),
        "height_p95_m": float(np.percentile(np.abs(off[:, 2]), 95)),
        "cpu_ms": float(np.median(cpu_ms)),
        "cpu_p99_ms": float(np.percentile(cpu_ms, 99)),
        **slam.figures(),
        **{each.name: each.figures() for each in libraries},
    }


def _tell(libraries: Sequence[Beside], output: StepOutput) -> None:
    """Hand the cloud of an instant to libraries, if there is one."""
    for sensor in output.payload if libraries and output.ground_truth else ():
        if isinstance(sensor.device, CloudLidar):
            cloud, truth = sensor.shared(), output.ground_truth
            assert isinstance(cloud, Cloud)
            assert truth is not None
            lidar = truth.pose @ sensor.mount.pose
            in_world = np.eye(4)
            in_world[:3, :3], in_world[:3, 3] = lidar.rotation, lidar.position_m
            for library in libraries:
                library.take(cloud.points_m, in_world)


def parameters_of(
    climb: Climb, lidar: str, seed: int, mission: Sequence[Waypoint] = ()
) -> ClosedLoopParameters:
    """Return the parameters of a flight through places without GNSS."""
    simulation = SimulationParameters(
        str(climb.world),
        model=climb.model,
        lidar=climb.lidar(lidar),
        sensors=climb.sensors,
        gnss=False,
        seed=seed,
        spawn_pose=Pose(climb.start_m),
    )
    controller = PositionControllerParameters(max_speed=climb.speed_m_s)
    return ClosedLoopParameters(
        simulation,
        goal_xyz_m=None,
        mission=tuple(mission),
        pose_source="odometry",
        cepa=climb.cepa,
        position_controller=controller,
        range_finders=len(climb.sensors) > 1,
    )


def silent_m(times_s: np.ndarray, off_m: np.ndarray, told: np.ndarray, within_s: float = 1.0) -> float:
    """Return the greatest error (of n) at a time (n,) in whose last second no estimate told a doubt."""
    told_s = times_s[told]
    newest = np.searchsorted(told_s, times_s, side="right") - 1
    ages_s = np.where(newest >= 0, times_s - told_s[newest] if len(told_s) else np.inf, np.inf)
    silent = off_m[ages_s > within_s]
    return float(silent.max()) if len(silent) else 0.0


def summary(trials: Sequence[dict]) -> dict:
    """Return counts, and median and worst of each metric."""
    counts = {key: sum(trial[key] for trial in trials) for key in ("flown", "contact", "remarks")}
    spread = _spread(trials, (*METRICS, "silent_m"))
    libraries = [key for key, value in trials[0].items() if isinstance(value, dict)]
    beside = {key: _spread([trial[key] for trial in trials], BESIDE_METRICS) for key in libraries}
    return {"flights": len(trials), **counts, **spread, **beside}


def _spread(trials: Sequence[dict], keys: Sequence[str]) -> dict:
    values = {key: [trial[key] for trial in trials] for key in keys}
    return {key: {"median": float(np.median(all_)), "worst": max(all_)} for key, all_ in values.items()}
