"""Which roslaunch started a process: a ROS master cannot tell, for it may outlive many launches."""

from __future__ import annotations

import os
from pathlib import Path

BOOT = Path("/proc/sys/kernel/random/boot_id")
PARENT, START = 1, 19
"""In /proc/PID/stat, behind the process's name: number of its parent, and when it began (proc(5): 4, 22)."""


def launch_of_this_process() -> str:
    """Return which roslaunch started this process; the same again if it starts a node that died.

    roslaunch gives each node a session of its own, also behind a launch-prefix. So it is the parent of the
    session's leader. Its number may come again, on another day or in another container, but not with the
    same start and boot.
    """
    leader = _status_of(os.getsid(0))
    launch = int(leader[PARENT]) if leader else os.getppid()
    began = _status_of(launch)[START:]
    return f"{launch} {began[0] if began else 'unseen'} {BOOT.read_text(encoding='utf-8').strip()}"


def _status_of(process: int) -> list[str]:
    """Return what Linux tells of a process, behind its name; empty: it has ended, or is not to be seen."""
    try:
        told = Path(f"/proc/{process}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []
    return told.rpartition(")")[2].split()
