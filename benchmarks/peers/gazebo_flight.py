"""Gazebo classic steps our forest with a lidar in it, as fast as it can, and without a window."""

from __future__ import annotations

import os
import re
import resource
import subprocess
import tempfile
import time
from pathlib import Path

from benchmarks.peers.environments import PeerError
from benchmarks.shared.results import ROOT
from benchmarks.shared.speed import Speed

WORLD = ROOT / "src/extensions/flights/worlds/forest.world"
MODELS = ROOT / "src/simulation_tools/models"
STEP_S = 0.004
SIMULATED_S = 30.0
PATIENCE_S = 600.0
LIDAR = "<include><uri>model://lidar_ust</uri><static>true</static><pose>0 0 0 0 0 0</pose></include>"


def fly(gzserver: Path, simulated_s: float = SIMULATED_S) -> Speed:
    """Let Gazebo simulate, and measure what it takes beyond its start.

    gzserver: the program. It runs once for one step, which is its start, and once for all steps.

    Raises:
        PeerError: there is no such program, or it fails.
    """
    if not os.access(gzserver, os.X_OK) or gzserver.is_dir():
        raise PeerError(f"gazebo is not there: {gzserver} is no program; give the path of gzserver.")
    with tempfile.TemporaryDirectory() as folder:
        world = Path(folder, "forest.world")
        world.write_text(unpaced(WORLD.read_text(encoding="utf-8")), encoding="utf-8")
        start = _run(gzserver, world, 1)
        whole = _run(gzserver, world, 1 + round(simulated_s / STEP_S))
    cpu_s, wall_s = whole[0] - start[0], whole[1] - start[1]
    if min(cpu_s, wall_s) <= 0.0:
        raise PeerError("gazebo left no figures: all steps took it no longer than one.")
    return Speed(simulated_s, cpu_s, cpu_s, wall_s)


def unpaced(world: str) -> str:
    """Return a world file that Gazebo does not slow down to real time, with a lidar on its ground."""
    fast = re.sub(
        r"<real_time_update_rate>.*?</real_time_update_rate>",
        "<real_time_update_rate>0</real_time_update_rate>",
        world,
    )
    return fast.replace("</world>", f"{LIDAR}</world>")


def _run(gzserver: Path, world: Path, steps: int) -> tuple[float, float]:
    """Return CPU time and wall time of a run."""
    before, began_s = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    try:
        done = subprocess.run(
            (str(gzserver), "--iters", str(steps), str(world)),
            env={**os.environ, "GAZEBO_MODEL_PATH": str(MODELS), "HOME": str(world.parent)},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            timeout=PATIENCE_S,
        )
    except subprocess.TimeoutExpired:
        raise PeerError(f"gazebo did not end within {PATIENCE_S:g} s.") from None
    except OSError as error:
        raise PeerError(f"gazebo cannot be started: {error}.") from None
    if done.returncode != 0:
        said = [line.strip() for line in done.stdout.splitlines() if line.strip()]
        why = said[-1].rstrip(".") if said else f"it ended with code {done.returncode} and said nothing"
        raise PeerError(f"gazebo does not run: {why}.")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return cpu_s, time.perf_counter() - began_s
