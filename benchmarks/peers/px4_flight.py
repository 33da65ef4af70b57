"""Real PX4 SITL flies our physics. It hovers, as the peers from the registry do."""

from __future__ import annotations

import math
import tempfile
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

from benchmarks.peers.environments import PeerError
from benchmarks.shared.speed import Speed, timed
from benchmarks.simulator.px4_process import PROGRAM
from benchmarks.simulator.real_px4 import RealPx4
from benchmarks.simulator.reference_quad import standing, stepped
from benchmarks.simulator.step_response import Pilot
from flights.graph import processes
from simulation_tools.errors import SimulationToolsError
from simulation_tools.simulation import Simulation

CONNECTS_S = 60.0
"""Patience, wall time."""
ESTIMATES_S = 15.0
"""Simulated time until PX4's estimate has settled on the ground."""
RISE_M, SETTLES_S = 2.0, 10.0
SIMULATED_S = 30.0
NEAR_M = 0.3
INSTANCE = 7
"""PX4's option -i. Its ports are then free beside a PX4 that somebody flies."""


def fly(build: Path, simulated_s: float = SIMULATED_S) -> Speed:
    """Let PX4 hover. Its CPU time counts with ours.

    build: PX4's folder build/px4_sitl_default.

    Raises:
        PeerError: there is no PX4, or it does not fly.
    """
    if not (build / PROGRAM).is_file():
        raise PeerError(
            f"px4 is not there: {build} has no {PROGRAM}; give its folder build/px4_sitl_default."
        )
    with tempfile.TemporaryDirectory() as folder:
        try:
            return _hover(build, Path(folder), simulated_s)
        except (OSError, RuntimeError, SimulationToolsError) as error:
            raise PeerError(f"px4 does not fly: {str(error).rstrip('.')}.") from None


def _hover(build: Path, folder: Path, simulated_s: float) -> Speed:
    px4 = RealPx4(build, INSTANCE, folder, {"COM_RC_IN_MODE": 1}, 1, lambda state: (), gnss=True)
    simulation = Simulation(replace(standing(1), gnss=True), px4)
    try:
        end_s = time.monotonic() + CONNECTS_S
        while not px4.is_ready():
            if time.monotonic() > end_s:
                raise PeerError(f"px4 has not connected to the simulator within {CONNECTS_S:g} s.")
            time.sleep(0.05)
        pilot = Pilot(px4, partial(stepped, simulation))
        pilot.fly(ESTIMATES_S)
        ground_m = pilot.state.pose.position_m
        pilot.take_off(RISE_M, SETTLES_S)
        own_s = -_cpu_s(px4.pid)
        speed = timed(lambda: simulated_s if len(pilot.fly(simulated_s)) else math.nan)
        own_s += _cpu_s(px4.pid)
        off_m = math.dist(pilot.state.pose.position_m, (*ground_m[:2], ground_m[2] + RISE_M))
    finally:
        simulation.close()
        px4.close()
    if not off_m < NEAR_M:
        raise PeerError(f"px4 ended {off_m:.2f} m from its hover point, so its speed does not count.")
    return replace(speed, thread_s=speed.thread_s + own_s, process_s=speed.process_s + own_s)


def _cpu_s(pid: int) -> float:
    """Return the CPU time of a process so far; PeerError if it has ended."""
    used_s = processes.cpu_s(pid)
    if used_s is None:
        raise PeerError("px4 ended before its flight was over.")
    return used_s
