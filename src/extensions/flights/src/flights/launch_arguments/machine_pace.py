"""What this machine can compute now, and which real-time factor a simulated flight can keep on it."""

from __future__ import annotations

import os
import struct
import time
from typing import Any, Callable, Mapping

MEASURED_S = 0.3
"""Wall time of the measurement."""
REFERENCE_LOOPS_PER_S = 4.5e7
"""Of `_spin`, per second of CPU time, on the machine on which `NEEDS_S` was measured."""
NEEDS_S: Mapping[str, float] = {"explore.launch": 2.5, "inspection.launch": 2.5}
"""CPU time of a launch file's graph per second of simulated time: explore took 20.0 s for 8.05 s (two cores
that other work kept busy, 2026-11-29, commit 93f5e297). inspection runs the same nodes."""
NEED_S = 1.1
"""Of the other launch files: Experiment 3 took 12.2 s for 11.0 s, on the same day."""
_LOOPS = 2000


def free_cores(lasts_s: float = MEASURED_S) -> float:
    """Return how many cores of the reference machine a new program with many processes would get."""
    return _loops_per_s(lasts_s) / REFERENCE_LOOPS_PER_S


def own_free_cores(lasts_s: float = MEASURED_S) -> float:
    """Return how many of this machine's own cores such a program would get."""
    loops_per_cpu_s = _LOOPS * 200 / max(_count(200), 1e-9)
    return min(_loops_per_s(lasts_s) / loops_per_cpu_s, float(len(os.sched_getaffinity(0))))


def _count(times: int) -> float:
    """Return the CPU time of counting so often, s."""
    began_s, loops = time.thread_time(), 0
    for _ in range(times):
        for _ in range(_LOOPS):
            loops += 1
    return time.thread_time() - began_s


def _loops_per_s(lasts_s: float) -> float:
    """For a moment one process on each core does nothing but count. Return loops per second of all."""
    cores = len(os.sched_getaffinity(0))
    readers = []
    for _ in range(cores):
        reader, writer = os.pipe()
        pid = os.fork()
        if pid == 0:
            try:
                os.write(writer, struct.pack("d", _spin(lasts_s)))
            finally:
                os._exit(0)
        os.close(writer)
        readers.append((pid, reader))
    loops_per_s = 0.0
    for pid, reader in readers:
        told = os.read(reader, 8)
        os.close(reader)
        os.waitpid(pid, 0)
        loops_per_s += struct.unpack("d", told)[0] if len(told) == 8 else 0.0
    return loops_per_s


def _spin(lasts_s: float) -> float:
    """Count for so long; return loops per second of wall time."""
    began_s, loops = time.perf_counter(), 0
    while (now_s := time.perf_counter()) - began_s < lasts_s:
        for _ in range(_LOOPS):
            loops += 1
    return loops / (now_s - began_s)


def warning(name: str, asked: Mapping[str, Any], measure: Callable[[], float] = free_cores) -> str:
    """Return a sentence if a flight cannot keep its real-time factor, else nothing.

    Nothing is measured in lockstep, where the simulator waits for every node, nor without a factor.

    name: of the launch file. asked: its arguments. measure: returns the free cores.
    """
    factor = float(asked.get("real_time_factor", 0.0))
    is_foreign = str(asked.get("autopilot", "standin")) != "standin"
    if factor <= 0.0 or not (is_foreign or name in NEEDS_S):
        return ""
    if str(asked.get("lockstep", "false")).lower() in ("true", "1"):
        return ""
    cores, need_s = measure(), NEEDS_S.get(name, NEED_S)
    keeps = cores / need_s
    if keeps >= factor:
        return ""
    return (
        f"This machine can keep a real-time factor of about {keeps:.2f} now, and {factor:g} is asked for: "
        f"{cores:.1f} cores are free, and {name} needs {need_s:g} s of CPU time for each simulated second. "
        "A flight that is late loses its pose. End other programs, or add "
        f"real_time_factor:={rounded(keeps):g}."
    )


def rounded(factor: float) -> float:
    """Return a factor, rounded down to what one would type: 0.45 is 0.4, and no less than 0.05."""
    return max(int(10.0 * factor) / 10.0, 0.05)
