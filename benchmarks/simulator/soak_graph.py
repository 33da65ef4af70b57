"""A long flight of the whole ROS graph: random goals in the forest, killed nodes, messages without sense.

Every 10 s on average there is a fault. Either a node is killed with SIGKILL; node and UAV must recover before
the next fault. Or something without sense is published, called or sent. The flight is in real time, without
lockstep, as a user flies. The UAV must touch nothing but the ground. MAVROS and its publisher are killed only
while the UAV is slow, because PX4 flies its last setpoint for a second before it lands (COM_OF_LOSS_T).
"""

from __future__ import annotations

import math
import os
import signal
import socket
import tempfile
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Callable

import numpy as np
from tqdm import tqdm

from benchmarks.simulator.soak import Goals, SoakMetrics
from flights.graph.free_ports import free_ports
from flights.graph.launched_graph import LaunchedGraph
from master_thesis.experiment_1.scenario_flight import scenario_parameters
from simulation_tools.px4_ports import own_ports
from simulation_tools.simulation import Simulation

LAUNCH = """<launch>
  <include file="$(find simulation_tools)/launch/sitl.launch">
    <arg name="world" value="{world}"/>
    <arg name="seed" value="{seed}"/>
    <arg name="offboard_port" value="{offboard_port}"/>
    <arg name="gcs_port" value="{gcs_port}"/>
  </include>
  <include file="$(find simulation_tools)/launch/tools.launch"/>
  <include file="$(find inspection_tools)/launch/tools.launch">
    <arg name="pose_source" value="ground_truth"/>
  </include>
  <include file="$(find cepa)/launch/cepa.launch">
    <arg name="algorithm" value="improved"/>
    <arg name="visualiser" value="false"/>
  </include>
</launch>
"""
LINK = ("/mavros", "/mavros_publisher")
NODES = (
    *LINK,
    "/tf_publisher",
    "/lidar_median_filter",
    "/lidar_padding",
    "/cepa",
    "/yaw_regulator",
    "/position_controller",
)
"""All except the simulator, because its end is the launch's end."""

START_S = 90.0
FAULT_PAUSE_S = (5.0, 15.0)
RECOVERY_S = 40.0
SLOW_M = 0.03
"""In a round of 0.1 s."""

SILENCE_S = 20.0
"""After this wall time without a pose the graph counts as stuck."""


@dataclass
class GraphSoak(SoakMetrics):
    """Metrics of a soak. recovery_s: from a kill until setpoints come again and the UAV is ready for them."""

    kills: dict[str, int] = field(default_factory=dict)
    nonsense: dict[str, int] = field(default_factory=dict)
    never_recovered: list[str] = field(default_factory=list)
    recovery_s_mean: float = 0.0
    recovery_s_max: float = 0.0
    tracebacks: list[str] = field(default_factory=list)
    memory_early_gb: float = 0.0
    memory_end_gb: float = 0.0
    shutdown_s: float = 0.0


def soak(minutes: float, seed: int) -> dict:
    """Fly for that long in simulated time; return the metrics. Needs ROS and the workspace's environment."""
    rng = np.random.default_rng(seed)
    parameters = scenario_parameters("forest", seed=seed).simulation
    ports = dict(zip(("offboard_port", "gcs_port"), free_ports(2)))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        launch = folder / "soak.launch"
        launch.write_text(LAUNCH.format(world=parameters.world, seed=seed, **ports))
        graph = LaunchedGraph(folder, str(launch))
        try:
            graph.wait_for("hovering", START_S)
            os.environ["ROS_MASTER_URI"] = graph.master_uri
            simulation = Simulation(parameters)  # finds free places for goals
            metrics = _Soak(graph, simulation, rng, [*ports.values()]).fly(60.0 * minutes)
            metrics.memory_end_gb = graph.memory_gb()
            metrics.shutdown_s = graph.interrupt()
            metrics.tracebacks = _ends_of_tracebacks((folder / "roslaunch.txt").read_text(errors="replace"))
            return asdict(metrics)
        finally:
            graph.close()


class _Soak:
    """One soak under way."""

    def __init__(
        self, graph: LaunchedGraph, simulation: Simulation, rng: np.random.Generator, ports: list[int]
    ):
        # Imported here, because the other benchmarks need no ROS
        from benchmarks.simulator.soak_talk import Talk

        self._graph, self._rng = graph, rng
        self._metrics = GraphSoak()
        self._talk = Talk(rng)
        fcu_ports = (*own_ports(*ports[:2]), ports[0])
        self._nonsense: dict[str, Callable[[], None]] = {
            **self._talk.nonsense,
            "garbage over UDP": lambda: _send_garbage(rng, fcu_ports),
        }
        self._recoveries_s: list[float] = []
        self._faults: list[tuple[float, str]] = []
        self._goals = Goals(simulation, rng, self._metrics, 0.0)

    def fly(self, length_s: float) -> GraphSoak:
        """Fly to the end; return the metrics."""
        talk, metrics, rng = self._talk, self._metrics, self._rng
        start_s = talk.wait_for_pose(SILENCE_S)[0]
        fault_due_s, place = start_s + 10.0, None
        with tqdm(total=round(length_s), unit=" s", desc="simulated") as bar:
            while talk.now_s - start_s < length_s:
                now_s, here = talk.wait_for_pose(SILENCE_S)
                way_m = math.dist(here, place or here)
                metrics.way_m += way_m
                place = here
                self._goals.lead(now_s, here, talk.go)
                if now_s >= fault_due_s:
                    self._fault(is_slow=way_m < SLOW_M)
                    fault_due_s = talk.now_s + rng.uniform(*FAULT_PAUSE_S)
                if not metrics.memory_early_gb and now_s - start_s > 0.1 * length_s:
                    metrics.memory_early_gb = self._graph.memory_gb()
                bar.update(round(now_s - start_s) - bar.n)
                time.sleep(0.1)
        metrics.simulated_s = talk.now_s - start_s
        metrics.touched = [self._with_its_fault(what, when_s) for what, when_s in talk.touched.items()]
        metrics.contacts = talk.contacts
        metrics.recovery_s_mean = float(np.mean(self._recoveries_s or [0.0]))
        metrics.recovery_s_max = max(self._recoveries_s, default=0.0)
        return metrics

    def _with_its_fault(self, what: str, when_s: float) -> str:
        """Return a contact with the last fault before it."""
        before = [(at_s, fault) for at_s, fault in self._faults if at_s <= when_s]
        at_s, fault = before[-1] if before else (when_s, "nothing")
        return f"{what} {when_s - at_s:.1f} s after {fault}"

    def _fault(self, is_slow: bool) -> None:
        if self._rng.random() < 0.5:
            node = str(self._rng.choice(NODES))
            if is_slow or node not in LINK:
                self._kill(node)
        else:
            what = str(self._rng.choice(list(self._nonsense)))
            self._faults.append((self._talk.now_s, what))
            self._metrics.nonsense[what] = self._metrics.nonsense.get(what, 0) + 1
            self._nonsense[what]()

    def _kill(self, node: str) -> None:
        """Kill a node. Wait until it is back and the UAV takes setpoints again."""
        metrics, talk = self._metrics, self._talk
        metrics.kills[node] = metrics.kills.get(node, 0) + 1
        pid, killed_s = talk.pid_of(node), talk.now_s
        self._faults.append((killed_s, f"{node} was killed"))
        if pid is not None:
            os.kill(pid, signal.SIGKILL)
        while talk.now_s - killed_s < RECOVERY_S:
            talk.wait_for_pose(SILENCE_S)
            if talk.pid_of(node) not in (None, pid) and talk.is_led(since_s=killed_s + 1.0):
                self._recoveries_s.append(talk.now_s - killed_s)
                return
            time.sleep(0.1)
        metrics.never_recovered.append(f"{node} at {killed_s:.0f} s")


def _ends_of_tracebacks(said: str) -> list[str]:
    """Return the last line of each traceback, which names the error."""
    ends = []
    for rest in said.split("Traceback (most recent call last):")[1:]:
        ends.append(next((line for line in rest.splitlines()[1:] if line[:1].strip()), ""))
    return ends


def _send_garbage(rng: np.random.Generator, ports: tuple[int, ...]) -> None:
    """Send bytes that are no MAVLink, some of them with a magic byte in front."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for port in ports:
            for magic in (b"", b"\xfd", b"\xfe"):
                sender.sendto(magic + rng.bytes(int(rng.integers(0, 400))), ("127.0.0.1", port))


def summary(metrics: dict) -> str:
    """Return the metrics as text."""
    counts = {
        name: ", ".join(f"{what} {count}" for what, count in sorted(metrics[name].items()))
        for name in ("kills", "nonsense")
    }
    touched = f" ({', '.join(metrics['touched'])})" if metrics["touched"] else ""
    never, tracebacks = (", ".join(metrics[name]) or "none" for name in ("never_recovered", "tracebacks"))
    return (
        f"{metrics['simulated_s'] / 60.0:.1f} simulated minutes, {metrics['way_m'] / 1e3:.2f} km, "
        f"{metrics['goals_reached']} of {metrics['goals']} goals reached\n"
        f"killed: {counts['kills']}; in the air again after {metrics['recovery_s_mean']:.1f} s, "
        f"{metrics['recovery_s_max']:.1f} s at most; never: {never}\n"
        f"nonsense: {counts['nonsense']}\n"
        f"contacts: {metrics['contacts']}{touched}; tracebacks: {tracebacks}\n"
        f"memory: {metrics['memory_end_gb']:.2f} GB at the end, {metrics['memory_early_gb']:.2f} GB after a "
        f"tenth of it; Ctrl-C took {metrics['shutdown_s']:.1f} s"
    )
