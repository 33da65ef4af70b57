"""The whole ROS graph of Experiment 1 as its user sees it: start, hover, load, memory, end, and top speed."""

from __future__ import annotations

import json
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

from flights.graph.free_ports import free_ports
from flights.graph.launched_graph import GraphError, LaunchedGraph

HOVER_PATIENCE_S = 90.0
END_PATIENCE_S = 240.0
LOAD_S = 15.0


def measure_start() -> dict:
    """Fly in real time, without lockstep; return how long start, hover and end took, CPU, memory, latency.

    launch_cpu_s, hover_cpu_s: CPU time of all processes, from roslaunch's start on. Other load changes it
    less than the wall time.
    graph.latency_ms, graph.latency_p99_ms: wall time from a scan's sending to its setpoint's arrival at the
    flight controller, until the flight is interrupted.
    """
    with _experiment("real_time_factor:=1.0", "lockstep:=false") as (graph, results):
        launch_s = graph.wait_for("first_scan_through", HOVER_PATIENCE_S)
        launch_cpu_s = graph.cpu_s()
        hover_s = graph.wait_for("hovering", HOVER_PATIENCE_S)
        hover_cpu_s, began_s = graph.cpu_s(), time.monotonic()
        time.sleep(LOAD_S)
        cores = (graph.cpu_s() - hover_cpu_s) / (time.monotonic() - began_s)
        memory_gb = graph.memory_gb()
        shutdown_s = graph.interrupt()
        latency_ms = _result(graph, results)["latency_ms"]
        if not latency_ms:
            raise GraphError(f"The flight in real time measured no latency; it said:\n{graph.said()}")
        return {
            "launch_s": launch_s,
            "launch_cpu_s": launch_cpu_s,
            "hover_s": hover_s,
            "hover_cpu_s": hover_cpu_s,
            "cpu_cores_at_rtf1": cores,
            "memory_gb": memory_gb,
            "shutdown_s": shutdown_s,
            "graph.latency_ms": latency_ms["median"],
            "graph.latency_p99_ms": latency_ms["p99"],
        }


def measure_speed() -> dict:
    """Fly in lockstep, as fast as possible; return the real-time factor from goal sent to goal reached.

    cpu_s_per_s: CPU time of the whole graph for a simulated second, which other load changes less.
    """
    with _experiment("lockstep:=true", "real_time_factor:=0") as (graph, results):
        graph.wait_for("hovering", END_PATIENCE_S)
        cpu_s = -graph.cpu_s()
        graph.wait_for("goal_reached", END_PATIENCE_S)
        cpu_s += graph.cpu_s()
        graph.wait_for_end(END_PATIENCE_S)
        result = _result(graph, results)
        if not result["success"]:
            raise GraphError(f"The flight in lockstep failed: {result['failure']}")
        return {
            "rtf": result["real_time_factor"],
            "cpu_s_per_s": cpu_s / result["flight_time_s"],
            "lockstep_misses": result["lockstep_misses"],
        }


def _result(graph: LaunchedGraph, results: Path) -> dict:
    found = sorted(results.glob("experiment_1/*/result.json"))
    if not found:
        raise GraphError(f"The flight left no result; it said:\n{graph.said()}")
    return json.loads(found[-1].read_text())


@contextmanager
def _experiment(*arguments: str) -> Iterator[tuple[LaunchedGraph, Path]]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ports = (f"{name}:={port}" for name, port in zip(("offboard_port", "gcs_port"), free_ports(2)))
        graph = LaunchedGraph(
            folder,
            *("master_thesis", "experiment_1.launch", "scenario:=forest", "headless:=true"),
            *(f"results:={folder / 'results'}", *ports, *arguments),
        )
        try:
            yield graph, folder / "results"
        finally:
            graph.close()
