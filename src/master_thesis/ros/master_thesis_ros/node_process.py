"""What the process of a ROS node takes of the machine."""

from __future__ import annotations

import os
import time
from pathlib import Path
from xmlrpc.client import ServerProxy

import rosgraph
import rospy

_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


class NodeProcess:
    """Processor time between `begin` and `end`, and peak memory, of a node on this machine.

    Everything stays None for a node that cannot be found, or that runs elsewhere.
    """

    def __init__(self, node: str) -> None:
        self._node = node
        self._pid: int | None = None
        self._began: tuple[float, float] | None = None
        self.cpu_s: float | None = None
        self.cpu_share: float | None = None
        self.peak_mb: float | None = None

    def begin(self) -> None:
        """Count from here."""
        self._pid = self._find()
        used_s = self._used_s()
        if used_s is not None:
            self._began = (time.perf_counter(), used_s)

    def end(self) -> None:
        """Count to here; share: of one core."""
        used_s = self._used_s()
        if self._began is None or used_s is None:
            return
        began_s, before_s = self._began
        self.cpu_s = used_s - before_s
        self.cpu_share = self.cpu_s / max(time.perf_counter() - began_s, 1e-9)
        self.peak_mb = self._peak_mb()

    def _find(self) -> int | None:
        try:
            address = rosgraph.Master(rospy.get_name()).lookupNode(self._node)
            return int(ServerProxy(address).getPid(rospy.get_name())[2])
        except (OSError, rosgraph.MasterException, ValueError):
            return None

    def _used_s(self) -> float | None:
        try:
            fields = Path(f"/proc/{self._pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
            return (int(fields[11]) + int(fields[12])) / _TICKS_PER_S
        except (OSError, IndexError, ValueError):
            return None

    def _peak_mb(self) -> float | None:
        try:
            lines = Path(f"/proc/{self._pid}/status").read_text(encoding="utf-8").splitlines()
            return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM"))
        except (OSError, StopIteration, ValueError):
            return None
