"""CPU time and memory of a process of this machine, from Linux; None if unknown."""

from __future__ import annotations

import os
from pathlib import Path

_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
# Places in /proc/PID/stat behind the name of the program
_STATE, _USER, _SYSTEM, _OF_CHILDREN, _STARTED = 0, 11, 12, (13, 14), 19


def cpu_s(pid: int) -> float | None:
    """Return the processor time so far."""
    fields = _stat(pid)
    return (int(fields[_USER]) + int(fields[_SYSTEM])) / _TICKS_PER_S if fields else None


def ended_children_cpu_s(pid: int) -> float | None:
    """Return the processor time of its children that have ended, with theirs."""
    fields = _stat(pid)
    return sum(int(fields[place]) for place in _OF_CHILDREN) / _TICKS_PER_S if fields else None


def age_s(pid: int) -> float:
    """Return the age of a process, s; 0 if it is unknown."""
    fields = _stat(pid)
    if not fields:
        return 0.0
    up_s = float(Path("/proc/uptime").read_text(encoding="utf-8").split()[0])
    return up_s - int(fields[_STARTED]) / _TICKS_PER_S


def has_ended(pid: int) -> bool:
    """Return whether a process is gone, or a zombie."""
    fields = _stat(pid)
    return not fields or fields[_STATE] == "Z"


def peak_memory_mb(pid: int) -> float | None:
    """Return its peak memory."""
    kilobytes = _kilobytes(pid, "status", "VmHWM")
    return None if kilobytes is None else kilobytes / 1024


def shared_out_memory_gb(pid: int) -> float:
    """Return its present memory; shared memory counts once (proportional set size)."""
    return (_kilobytes(pid, "smaps_rollup", "Pss") or 0) / 2**20


def _stat(pid: int) -> list[str] | None:
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except OSError:
        return None


def _kilobytes(pid: int, file: str, key: str) -> int | None:
    try:
        lines = Path(f"/proc/{pid}/{file}").read_text(encoding="utf-8").splitlines()
    except OSError:
        return None
    return next((int(line.split()[1]) for line in lines if line.startswith(f"{key}:")), None)
