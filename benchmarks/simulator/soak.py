"""A long flight without ROS, with random goals in the forest and random faults.

Every 20 s on average something fails for a while: setpoints stop, scans get lost, a third of the beams
measures nothing, or a gust of wind blows. Goals change in mid-flight. The UAV must touch nothing but the
ground.
"""

from __future__ import annotations

import math
import os
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Callable, Sequence

import numpy as np
from tqdm import tqdm

from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Action, Phase, PhaseLimits
from flights.flight.flight_log import FlightLog
from flights.flight.parameters import ClosedLoopParameters
from master_thesis.experiment_1.scenario_flight import scenario_parameters
from simulation_tools.geometry import Pose, Vector3
from simulation_tools.sdf.parser import parse_model
from simulation_tools.simulation import Simulation, StepOutput
from simulation_tools.world.world import BodyState

PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")
AREA_X_M, AREA_Y_M = (-2.0, 42.0), (-12.0, 12.0)
"""The area of the goals: the forest."""

GOAL_CLEARANCE_M = 1.0
GOAL_PATIENCE_S = (10.0, 40.0)
FAULT_PAUSE_S = (5.0, 35.0)
FAULTS = {
    "setpoints stop": (0.2, 0.8),
    "scans get lost": (0.1, 1.0),
    "beams are blind": (0.5, 5.0),
    "gust": (0.5, 3.0),
}
"""Least and greatest length in seconds. Setpoints that stop for a second or more make PX4 land."""

LANDING_S = (1.5, 2.5)
"""When the UAV hovers at its goal, setpoints stop for this time: a failsafe begins and ends."""

GUST_M_S = 3.0
NO_LIMITS = PhaseLimits(flight_timeout_s=999_999.0)
BLIND_SHARE = 1 / 3
CLOCK_M_S = 0.01
CLOCK_HAND = (
    '<sdf version="1.6"><model name="clock_hand"><link name="link"><gravity>0</gravity></link></model></sdf>'
)
"""A body without weight, far above, with constant speed. Its place shows how long the physics has run."""


@dataclass
class SoakMetrics:
    """Metrics of any soak. contacts: without the ground."""

    simulated_s: float = 0.0
    way_m: float = 0.0
    goals: int = 0
    goals_reached: int = 0
    contacts: int = 0
    touched: list[str] = field(default_factory=list)


@dataclass
class Soak(SoakMetrics):
    """Metrics of a soak without ROS. Memory: resident, after a tenth and at the end."""

    wall_s: float = 0.0
    failsafes: int = 0
    faults: dict[str, int] = field(default_factory=dict)
    clock_drift_ms: float = 0.0
    memory_early_mb: float = 0.0
    memory_end_mb: float = 0.0


class Goals:
    """Sends one random goal in the forest after the other. place_m: of the newest one."""

    def __init__(
        self, simulation: Simulation, rng: np.random.Generator, metrics: SoakMetrics, ends_s: float
    ) -> None:
        """simulation: knows which places are free. ends_s: when the first goal is due."""
        self._simulation, self._rng, self._metrics, self._ends_s = simulation, rng, metrics, ends_s
        self.place_m: Vector3 = (0.0, 0.0, 2.0)

    def lead(self, now_s: float, here: Sequence[float], send: Callable[[Vector3], None]) -> None:
        """Send the next goal if the last one is reached or takes too long."""
        if math.dist(here[:2], self.place_m[:2]) < 0.3 and self._ends_s > now_s + 5.0:
            self._metrics.goals_reached += 1
            self._ends_s = now_s + 4.0
        if now_s >= self._ends_s:
            self.place_m = self._free_place()
            self._ends_s = now_s + self._rng.uniform(*GOAL_PATIENCE_S)
            self._metrics.goals += 1
            send(self.place_m)

    def _free_place(self) -> Vector3:
        """Draw a place with nothing near it."""
        world, uav = self._simulation.world, self._simulation.uav_name
        while True:
            x, y = self._rng.uniform(*AREA_X_M), self._rng.uniform(*AREA_Y_M)
            if world.clearance(uav, Pose((x, y, 2.0)), GOAL_CLEARANCE_M) > GOAL_CLEARANCE_M:
                return float(x), float(y), 2.0


class FaultyLoop(ClosedLoop):
    """The closed loop with faults. `fault` is the present one, "" for none. soaking: it never lands."""

    def __init__(self, parameters: ClosedLoopParameters, rng: np.random.Generator) -> None:
        super().__init__(parameters)
        self.rng = rng
        self.fault = ""
        self.soaking = False

    def begin(self, fault: str) -> None:
        """Begin a fault; "": end the present one."""
        self.fault = fault
        self.publisher.silent = fault == "setpoints stop"
        angle = self.rng.uniform(-math.pi, math.pi)
        strength = GUST_M_S if fault == "gust" else 0.0
        self.simulation.wind_m_s = (strength * math.cos(angle), strength * math.sin(angle), 0.0)

    def go(self, goal_m: Vector3) -> None:
        """Send another goal."""
        self.position_controller.set_setpoint(goal_m)

    def _carry_out(self, actions: Sequence[Action]) -> None:
        if not self.soaking:
            super()._carry_out(actions)

    def _on_scan(self, output: StepOutput, ranges: np.ndarray) -> None:
        if self.fault == "scans get lost":
            return
        if self.fault == "beams are blind":
            ranges[self.rng.random(len(ranges)) < BLIND_SHARE] = np.nan
        super()._on_scan(output, ranges)


def soak(minutes: float, seed: int) -> dict:
    """Fly for that long in simulated time; return the metrics."""
    rng = np.random.default_rng(seed)
    parameters = replace(scenario_parameters("forest", seed=seed), goal_xyz_m=None, limits=NO_LIMITS)
    loop = FaultyLoop(parameters, rng)
    with loop:
        loop.run_to(Phase.FLYING)
        loop.soaking = True
        return vars(_Flight(loop, 60.0 * minutes).fly())


class _Flight:
    """One soak under way."""

    def __init__(self, loop: FaultyLoop, length_s: float) -> None:
        self._loop, self._rng, self._length_s = loop, loop.rng, length_s
        self._metrics = Soak()
        self._start_s = loop.time_s
        self._fault_changes_s = loop.time_s
        self._goals = Goals(loop.simulation, loop.rng, self._metrics, loop.time_s)
        self._place = self._goals.place_m
        self._was_failsafe = False
        world = loop.simulation.world
        world.spawn(parse_model(CLOCK_HAND, "clock hand"), "clock_hand", Pose((0.0, 0.0, 500.0)))
        hand = BodyState(Pose((0.0, 0.0, 500.0)), (CLOCK_M_S, 0.0, 0.0))
        world.set_state("clock_hand", hand)

    def fly(self) -> Soak:
        """Fly to the end; return the metrics."""
        began_s, metrics, loop = time.perf_counter(), self._metrics, self._loop
        with tqdm(total=round(self._length_s), unit=" s", desc="simulated") as bar:
            for _ in range(round(self._length_s)):
                end_us = loop.simulation.time_us + 1_000_000
                while loop.simulation.time_us < end_us:
                    self._watch(loop.step())
                self._each_second()
                bar.update()
        metrics.simulated_s = loop.time_s - self._start_s
        metrics.wall_s = time.perf_counter() - began_s
        metrics.memory_end_mb = _resident_mb()
        hand_m = loop.simulation.world.get_state("clock_hand").pose.position_m[0]
        metrics.clock_drift_ms = 1e3 * (hand_m / CLOCK_M_S - metrics.simulated_s)
        return metrics

    def _watch(self, output: StepOutput) -> None:
        metrics, loop = self._metrics, self._loop
        for contact in output.contacts:
            if not contact.collision_2.startswith("ground_plane::"):
                metrics.contacts += 1
                metrics.touched = sorted({*metrics.touched, contact.collision_2})
        assert loop.simulation.px4 is not None
        failsafe = loop.simulation.px4.status.failsafe
        metrics.failsafes += failsafe and not self._was_failsafe
        self._was_failsafe = failsafe
        if loop.time_s >= self._fault_changes_s:
            self._change_fault()

    def _change_fault(self) -> None:
        """End the present fault, or begin one."""
        loop, rng = self._loop, self._rng
        if loop.fault:
            loop.begin("")
            self._fault_changes_s = loop.time_s + rng.uniform(*FAULT_PAUSE_S)
            return
        fault = str(rng.choice(list(FAULTS)))
        waits = fault == "setpoints stop" and math.dist(self._place, self._goals.place_m) < 0.3
        length = LANDING_S if waits else FAULTS[fault]
        loop.begin(fault)
        self._metrics.faults[fault] = self._metrics.faults.get(fault, 0) + 1
        self._fault_changes_s = loop.time_s + rng.uniform(*length)

    def _each_second(self) -> None:
        loop, metrics = self._loop, self._metrics
        place = loop.simulation.world.get_state(loop.simulation.uav_name).pose.position_m
        metrics.way_m += math.dist(place, self._place)
        self._place = place
        loop.monitor.log = FlightLog()  # an hour takes a gigabyte
        self._goals.lead(loop.time_s, place, loop.go)
        if not metrics.memory_early_mb and loop.time_s - self._start_s >= 0.1 * self._length_s:
            metrics.memory_early_mb = _resident_mb()


def summary(metrics: dict) -> str:
    """Return the metrics as text."""
    faults = ", ".join(f"{name} {count}" for name, count in sorted(metrics["faults"].items()))
    growth_mb = metrics["memory_end_mb"] - metrics["memory_early_mb"]
    touched = f" ({', '.join(metrics['touched'])})" if metrics["touched"] else ""
    return (
        f"{metrics['simulated_s'] / 60.0:.1f} simulated minutes in {metrics['wall_s']:.0f} s, "
        f"{metrics['way_m'] / 1e3:.2f} km, {metrics['goals_reached']} of {metrics['goals']} goals reached\n"
        f"faults: {faults}; failsafes: {metrics['failsafes']}\n"
        f"contacts: {metrics['contacts']}{touched}\n"
        f"memory: {metrics['memory_end_mb']:.0f} MB at the end, {growth_mb:+.1f} MB since a tenth of it\n"
        f"drift between clock and physics: {metrics['clock_drift_ms']:.3g} ms"
    )


def _resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * PAGE_BYTES / 2**20
