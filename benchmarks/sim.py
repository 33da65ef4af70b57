"""The simulator's speed: in one process, through the ROS graph, its rays, its start and end; and a long soak.

In-process: Experiment 1's forest flight (physics and flight controller at 250 Hz, UST at 40 Hz, filters,
CEPA) in one thread without ROS; times are the thread's, so that what else the machine does hardly matters.
Peers fly by turns with the flights in-process. Those of `--peers` are installed from the package registry
into .peers/NAME at first, and fly one quadrotor each. `--px4` and `--gazebo` name programs of this machine.
If a peer's installation or flight fails, a sentence tells why, and the rest is measured. Rays: scans of 1081
beams in the forest, through the simulator's own interface and by Embree alone. World size: the time of such a
scan among 100 and among 10,000 trees of one density. Actors: what each walker around the lidar adds to a step
of the physics and to a scan. Graph: experiment_1.launch as its user starts it, in real time, and then in
lockstep as fast as possible; wall times, for an idle machine. The latency from scan to setpoint is that of
the flight in real time, without lockstep.

Keys: sim.inprocess.{rtf, rtf_process, rtf_wall}, medians of five; sim.peers.NAME.{rtf, rtf_process, rtf_wall,
ours_by_it, ours_by_it_process} or .left_out; sim.raycast.{mrays_s, embree_mrays_s, by_embree},
sim.world_size.{scan_us_100, scan_us_10000, ratio}, sim.actors.{step_us, scan_us}, sim.graph.{rtf,
cpu_s_per_s, lockstep_misses, latency_ms, latency_p99_ms}, sim.{launch_s, launch_cpu_s, hover_s, hover_cpu_s,
shutdown_s, cpu_cores_at_rtf1, memory_gb}; with --soak sim.soak, with --soak-graph sim.soak_graph: the same
through the ROS graph, with nodes killed and nonsense sent.
"""

from __future__ import annotations

import argparse
import math
import statistics
import time
from dataclasses import replace
from functools import partial
from typing import Any, Callable, Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.peers import turns as peers
from benchmarks.peers.environments import FOLDER
from benchmarks.shared.results import ROOT, Results, options, table
from benchmarks.simulator import forest, graph, soak, soak_graph
from master_thesis.experiment_1.scenario_flight import scenario_parameters
from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import (
    Collision,
    Cylinder,
    Inertial,
    Link,
    Model,
    Script,
    Trajectory,
    Waypoint,
    World,
)
from simulation_tools.simulation import Simulation
from simulation_tools.world.world import PhysicsWorld

PARTS = ("inprocess", "raycast", "world_size", "actors", "graph", "start")
FLIGHTS, BRIEF_FLIGHTS = 5, 3
SCANS, ROUNDS = 3000, 10
SOAKS = {"soak": (60.0, soak), "soak_graph": (10.0, soak_graph)}
"""By name: simulated minutes, and the function that flies."""
TREES_PER_M2 = 0.06
"""Of Experiment 1's forest."""

LIMITS = {
    "inprocess.rtf": (">=", 45.0),
    "raycast.mrays_s": (">=", 8.0),
    "raycast.by_embree": (">=", 0.92),
    "world_size.ratio": ("<", 4.0),
    "graph.rtf": (">=", 8.0),
    "launch_s": ("<", 5.0),
    "hover_s": ("<", 9.0),
    "shutdown_s": ("<", 2.0),
    "cpu_cores_at_rtf1": ("<", 0.8),
    "memory_gb": ("<", 1.2),
}
"""The limit of each metric."""

THESIS = {"launch_s": "7, until all nodes are good to go", "shutdown_s": "15"}
"""The thesis's own figures, of Gazebo with PX4 on its author's machine: constants, which no run measures."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print and write."""
    parser = options(__doc__)
    parser.add_argument("--parts", nargs="+", default=PARTS, choices=PARTS, help="measure only these parts")
    peers.add_options(parser)
    parser.add_argument("--soak", action="store_true", help="fly an hour of random goals and faults instead")
    parser.add_argument("--soak-graph", action="store_true", help="as --soak, with the whole ROS graph")
    parser.add_argument(
        "--minutes", type=float, help="simulated minutes of --soak (default: 60) or --soak-graph (10)"
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the soak's goals and faults")
    given = parser.parse_args(arguments)
    if given.soak or given.soak_graph:
        _soak("soak_graph" if given.soak_graph else "soak", given)
        return
    if (given.peers or peers.programs_of(given)) and "inprocess" not in given.parts:
        parser.error("peers fly beside the part inprocess; name it in --parts, too.")
    with Results("sim", given.results, vars(given)) as results:
        metrics, told = {}, ""
        for part in tqdm(given.parts, "parts"):
            if part == "inprocess":
                flown, told = _fly_beside(given, results)
                metrics.update(flown)
            else:
                metrics.update(MEASURES[part]())
        for name, value in metrics.items():
            results.add(f"sim.{name}", value)
        print("\n" + "\n\n".join(filter(None, (metrics_table(metrics), told))))


def _fly_beside(given: argparse.Namespace, results: Results) -> tuple[dict[str, float], str]:
    """Fly the forest, and the peers by turns; return our metrics, and the table of the peers."""
    flights = BRIEF_FLIGHTS if given.brief else FLIGHTS
    ours, others = forest.fly_beside(given.peers, flights, ROOT / FOLDER, peers.programs_of(given))
    for name, found in others.items():
        results.add(f"sim.peers.{name}", found)
    told = forest.peers_table(ours, others) if others else peers.HINT
    return {f"inprocess.{name}": value for name, value in ours.items()}, told


def _soak(kind: str, given: argparse.Namespace) -> None:
    """Fly one of the soaks, print and write."""
    minutes, flights = SOAKS[kind]
    with Results(f"sim_{kind}", given.results, vars(given)) as results:
        metrics = flights.soak(given.minutes or minutes, given.seed)
        results.add(f"sim.{kind}", metrics)
        print(flights.summary(metrics))


def measure_raycast() -> dict:
    """Cast scans in the forest; return millions of rays per second of CPU, ours and Embree's own.

    Each is that of the fastest round, so that other load on the machine hardly changes them.
    """
    simulation = Simulation(scenario_parameters("forest").simulation)
    try:
        rays, lidar = simulation.world.rays, simulation.lidar
        assert lidar is not None
        directions = lidar.directions
        origins = np.column_stack((np.linspace(0.0, 40.0, SCANS), np.zeros(SCANS), np.full(SCANS, 2.0)))
        reach_m = lidar.range_max
        scene: Any = rays.static_scene()
        ranges = np.full(len(directions), reach_m, np.float32)

        def ours(places: np.ndarray) -> None:
            for origin in places:
                rays.cast(origin, directions, reach_m, "iris")

        def embree(starts: Sequence[np.ndarray]) -> None:
            for start in starts:  # each with fresh ranges: the query shortens them
                scene.run(start, directions, ranges.copy(), query="DISTANCE")

        ours_s = embree_s = math.inf
        for number in range(ROUNDS):
            places = origins[number::ROUNDS]
            starts = [np.ascontiguousarray(np.broadcast_to(p, directions.shape), np.float32) for p in places]
            ours_s = min(ours_s, _thread_s(partial(ours, places)))
            embree_s = min(embree_s, _thread_s(partial(embree, starts)))
        rays_a_round = 1e-6 * len(directions) * SCANS / ROUNDS
        return {
            "raycast.mrays_s": rays_a_round / ours_s,
            "raycast.embree_mrays_s": rays_a_round / embree_s,
            "raycast.by_embree": embree_s / ours_s,
        }
    finally:
        simulation.close()


def measure_world_size() -> dict:
    """Scan among 100 and among 10,000 trees of the same density; return both times and their ratio."""
    times_us = {count: _scan_us(count) for count in (100, 10_000)}
    return {
        "world_size.scan_us_100": times_us[100],
        "world_size.scan_us_10000": times_us[10_000],
        "world_size.ratio": times_us[10_000] / times_us[100],
    }


def measure_actors() -> dict:
    """Return what each of ten walkers adds to a step of the physics and to a scan that meets all of them."""
    none, ten = (_step_and_scan_us(count) for count in (0, 10))
    return {"actors.step_us": (ten[0] - none[0]) / 10, "actors.scan_us": (ten[1] - none[1]) / 10}


def _step_and_scan_us(walkers: int) -> tuple[float, float]:
    """Median times of a step and of a scan with walkers around the lidar."""
    angles = np.linspace(-2.0, 2.0, walkers)
    world = PhysicsWorld(
        World("walkers", tuple(_walker(n, angle) for n, angle in enumerate(angles.tolist())))
    )
    try:
        lidar = Simulation(scenario_parameters("empty").simulation).lidar
        assert lidar is not None
        here = Pose((0.0, 0.0, 1.5))
        steps = [_thread_s(world.step) for _ in range(SCANS)]
        scans = [_thread_s(partial(lidar.scan, world.rays, here)) for _ in range(SCANS)]
        return 1e6 * statistics.median(steps), 1e6 * statistics.median(scans)
    finally:
        world.close()


def _walker(number: int, angle_rad: float) -> Model:
    """Return an actor that goes away from the lidar, from 4 m on."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    waypoints = tuple(
        Waypoint(float(t), Pose(((4.0 + t / 20) * c, (4.0 + t / 20) * s, 0.0))) for t in range(100)
    )
    return replace(_tree(number, np.zeros(2)), script=Script((Trajectory(waypoints),)))


def _scan_us(trees: int) -> float:
    """Median time of a scan from 300 places among this many trees."""
    half_m = 0.5 * (trees / TREES_PER_M2) ** 0.5
    rng = np.random.default_rng(1)
    world = PhysicsWorld(
        World("trees", tuple(_tree(n, rng.uniform(-half_m, half_m, 2)) for n in range(trees)))
    )
    try:
        lidar = Simulation(scenario_parameters("empty").simulation).lidar
        assert lidar is not None
        middle = 0.5 * min(half_m, 20.0)
        places = [(*rng.uniform(-middle, middle, 2), 2.0) for _ in range(300)]
        times = [_thread_s(partial(lidar.scan, world.rays, Pose(place))) for place in places]
        return 1e6 * statistics.median(times)
    finally:
        world.close()


def _tree(number: int, xy_m: np.ndarray) -> Model:
    trunk = Collision("trunk", Pose((0.0, 0.0, 1.5)), Cylinder(0.2, 3.0))
    inertial = Inertial(1.0, Pose(), (1.0, 1.0, 1.0, 0.0, 0.0, 0.0))
    link = Link("link", Pose(), inertial, (trunk,))
    return Model(f"tree_{number}", Pose((*xy_m.tolist(), 0.0)), True, (link,))


def measure_graph() -> dict:
    """Fly the graph in lockstep as fast as possible."""
    return {f"graph.{name}": value for name, value in graph.measure_speed().items()}


MEASURES = {
    "raycast": measure_raycast,
    "world_size": measure_world_size,
    "actors": measure_actors,
    "graph": measure_graph,
    "start": graph.measure_start,
}


def metrics_table(metrics: dict) -> str:
    """Return the metrics beside their limits and the thesis's own figures."""
    rows = []
    for name, value in metrics.items():
        sign, limit = LIMITS.get(name, ("", None))
        asked = "" if limit is None else f"{sign} {limit:g}"
        rows.append((f"sim.{name}", f"{value:.3g}", asked, THESIS.get(name, "")))
    return table(("metric", "ours", "asked", "the thesis's own (constants)"), rows)


def _thread_s(action: Callable[[], object]) -> float:
    """CPU time of this thread that an action takes."""
    began = time.thread_time()
    action()
    return time.thread_time() - began


if __name__ == "__main__":
    main()
