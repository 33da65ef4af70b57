"""The CPU time and memory of a ROS node."""

from __future__ import annotations

import time

import rosgraph
import rospy

from flights.graph import processes
from node_tools.ros_servers import UNREACHABLE, server


class NodeProcess:
    """CPU time of a node between `begin` and `end` (cpu_share: of one core), and its peak memory.

    Everything stays None for a node that is not found or runs on another machine.
    """

    def __init__(self, node: str) -> None:
        self._node = node
        self._pid: int | None = None
        self._began: tuple[float, float] | None = None
        self.cpu_s: float | None = None
        self.cpu_share: float | None = None
        self.peak_mb: float | None = None

    def begin(self) -> None:
        """Begin to count."""
        self._pid = self._find()
        used_s = None if self._pid is None else processes.cpu_s(self._pid)
        if used_s is not None:
            self._began = (time.perf_counter(), used_s)

    def end(self) -> None:
        """Stop counting."""
        if self._pid is None or self._began is None:
            return
        used_s = processes.cpu_s(self._pid)
        if used_s is None:
            return
        began_s, before_s = self._began
        self.cpu_s = used_s - before_s
        self.cpu_share = self.cpu_s / max(time.perf_counter() - began_s, 1e-9)
        self.peak_mb = processes.peak_memory_mb(self._pid)

    def _find(self) -> int | None:
        try:
            address = rosgraph.Master(rospy.get_name()).lookupNode(self._node)
            return int(server(address).getPid(rospy.get_name())[2])
        except (*UNREACHABLE, ValueError):
            return None
