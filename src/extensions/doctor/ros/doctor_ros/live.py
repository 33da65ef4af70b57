"""Listens to a running graph for the doctor. It publishes nothing and calls no service of the stack."""

from __future__ import annotations

import contextlib
import math
import os
import threading
import time
from pathlib import Path
from typing import Any, Iterator

import numpy as np
import rosgraph
import roslib.message
import rospy

from doctor import machine
from doctor.snapshot import Graph, Launched, Node
from doctor_ros.recorder import NOT_NEEDED, Recorder
from flights.errors import GraphError
from node_tools.ros_servers import UNREACHABLE, server


def look(listen_s: float) -> Graph:
    """Listen to the graph for this wall time and return a snapshot; raises GraphError."""
    master = rosgraph.Master("/doctor")
    try:
        master.getPid()
    except UNREACHABLE:
        uri = rosgraph.get_master_uri()
        others = " and ".join(f"http://localhost:{port}" for port in machine.masters())
        there = f" On this machine one runs at {others}." if others else ""
        raise GraphError(
            f"No ROS master answers at {uri}: start a launch file, or set ROS_MASTER_URI.{there}"
        ) from None
    rospy.init_node("doctor", anonymous=True, disable_signals=True, disable_rosout=True)
    listener = _Listener()
    use_sim_time = bool(_parameter(master, "/use_sim_time", False))
    began_s, before = time.monotonic(), _ran_and_waited_s()
    end_s = began_s + listen_s
    while time.monotonic() < end_s:
        listener.follow(dict(master.getTopicTypes()), use_sim_time)
        time.sleep(min(0.5, max(0.0, end_s - time.monotonic())))
    wall_s = time.monotonic() - began_s
    ran_s, waited_s = _ran_and_waited_s() - before
    publishers, subscribers, services = (
        {name: {node for node in nodes if node != rospy.get_name()} for name, nodes in part}
        for part in master.getSystemState()
    )
    names = sorted(set().union(*publishers.values(), *subscribers.values(), *services.values()))
    with listener.finished() as recorder:
        types = dict(master.getTopicTypes())
        return Graph(
            recorder.recording(listener.now_s, publishers, subscribers, types),
            tuple(filter(None, (_node(master, name) for name in names))),
            tuple(_launched(master)),
            recorder.parameters(lambda name: _parameter(master, name, None)),
            use_sim_time,
            wall_s,
            waited_s / max(ran_s + waited_s, 1e-9),
            os.getloadavg()[0] / len(os.sched_getaffinity(0)),
            float(_parameter(master, "/gazebo/real_time_factor", 0.0) or 0.0),
        )


def _ran_and_waited_s() -> np.ndarray:
    """Return this process's time on a processor, and its time of waiting for one, of all living threads."""
    times_ns = np.zeros(2)
    for path in Path("/proc/self/task").glob("*/schedstat"):
        with contextlib.suppress(OSError):  # the thread has ended, or the kernel does not tell
            times_ns += [float(word) for word in path.read_text(encoding="ascii").split()[:2]]
    return 1e-9 * times_ns


class _Listener:
    """Subscribes to all topics, and passes their messages to a recorder."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._recorder = Recorder()
        self._subscribers: dict[str, rospy.Subscriber] = {}
        self.now_s = math.nan

    def follow(self, types: dict[str, str], use_sim_time: bool) -> None:
        """Subscribe to new topics. use_sim_time: the clock is /clock."""
        for topic, kind in types.items():
            kind_class = roslib.message.get_message_class(kind) if kind != "*" else None
            if topic in self._subscribers or kind in NOT_NEEDED or kind_class is None:
                continue
            self._subscribers[topic] = rospy.Subscriber(
                topic, kind_class, self._hear, callback_args=(topic, kind, use_sim_time), queue_size=None
            )

    def _hear(self, message: Any, about: tuple[str, str, bool]) -> None:
        topic, kind, use_sim_time = about
        with self._lock:
            if topic == "/clock" and use_sim_time:
                self.now_s = message.clock.to_sec()
            elif not use_sim_time:
                self.now_s = time.time()
            publisher = message._connection_header.get("callerid", "")
            latched = message._connection_header.get("latching", "") == "1"
            self._recorder.hear(topic, kind, publisher, message, self.now_s, latched, time.monotonic())

    @contextlib.contextmanager
    def finished(self) -> Iterator[Recorder]:
        """Unsubscribe. Return the recorder."""
        for subscriber in self._subscribers.values():
            subscriber.unregister()
        with self._lock:
            yield self._recorder


def _node(master: rosgraph.Master, name: str) -> Node | None:
    """Return a node, and whether its server answers; None if it has ended meanwhile."""
    try:
        uri = master.lookupNode(name)
    except UNREACHABLE:
        return None
    try:
        code, _, pid = server(uri).getPid("/doctor")
    except UNREACHABLE:
        return Node(name, False)
    return Node(name, code == 1, _package(pid))


def _package(pid: int) -> str:
    """Return the package of a process on this machine. Its program is in .../lib/PACKAGE/TYPE."""
    try:
        words = Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace").split("\0")
    except OSError:
        return ""
    return next((path.parts[-2] for path in map(Path, words[:2]) if path.parts[-3:-2] == ("lib",)), "")


def _launched(master: rosgraph.Master) -> Iterator[Launched]:
    """Yield the nodes that each roslaunch of this graph has started."""
    for uri in (_parameter(master, "/roslaunch/uris", {}) or {}).values():
        try:
            code, _, (alive, dead) = server(uri).list_processes()
        except (*UNREACHABLE, ValueError):
            continue  # it has ended; its nodes' own silence shows this
        if code == 1:
            yield from (Launched(_name(name), True, int(starts)) for name, starts in alive if _is_node(name))
            yield from (Launched(_name(name), False, int(starts)) for name, starts in dead if _is_node(name))


def _name(process: str) -> str:
    """Return a node's name from its process's name, e.g. cepa-5."""
    return "/" + process.rpartition("-")[0].lstrip("/")


def _is_node(process: str) -> bool:
    return "-" in process and not process.startswith(("rosout-", "master"))


def _parameter(master: rosgraph.Master, name: str, default: Any) -> Any:
    try:
        return master.getParam(name)
    except UNREACHABLE:
        return default
