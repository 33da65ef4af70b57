#!/usr/bin/env python3
"""Kill nodes of a running flight, one after the other, and print what the UAV then did, one JSON line each.

usage: fault_probe.py X HEIGHT NODE ...      (needs a flight that is under way; ROS_MASTER_URI leads to it)

Nothing is killed before the UAV is past X, m along x in `world`, and at HEIGHT, m.

Times are seconds of simulation time after the kill, speeds m/s over the ground, heights m over it.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
from geometry_msgs.msg import PoseStamped
from mavros_msgs.msg import PositionTarget, State
from nav_msgs.msg import Odometry

CRUISE_M_S = 1.8
SLOWED_M_S = 1.7  # a publisher that is back after 0.8 s has lost no more
PATIENCE_S = 25.0  # a respawn takes 1 s, its start-up up to 3 s, getting up to speed 2 s


class FlightWatch:
    """Keeps what was seen of the flight since `begin`."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self.begin()
        topics = (
            ("/UAV/ground_truth", Odometry, self._on_truth),
            ("/mavros/setpoint_raw/local", PositionTarget, self._on_velocity),
            ("/mavros/setpoint_position/local", PoseStamped, self._on_position),
            ("/mavros/state", State, self._on_state),
        )
        self._subscribers = [rospy.Subscriber(*topic, queue_size=100) for topic in topics]

    def begin(self) -> None:
        """Forget what was seen."""
        self.truth: list[tuple[float, float, float]] = []  # time, speed, height
        self.x_m = 0.0
        self.holds: list[float] = []  # times of setpoints that mean hover
        self.modes: list[str] = []

    def wait(self, condition, patience_s: float) -> bool:
        """Wait until a condition holds, at most so long of simulation time from the newest pose on."""
        with self._changed:
            end_s = self.truth[-1][0] + patience_s if self.truth else float("inf")
            while not condition():
                if (self.truth and self.truth[-1][0] > end_s) or not self._changed.wait(60.0):
                    return False
            return True

    def _on_truth(self, message: Odometry) -> None:
        v = message.twist.twist.linear
        row = (message.header.stamp.to_sec(), (v.x**2 + v.y**2) ** 0.5, message.pose.pose.position.z)
        with self._changed:
            self.x_m = message.pose.pose.position.x
            self.truth.append(row)
            self._changed.notify()

    def _on_velocity(self, message: PositionTarget) -> None:
        if (message.velocity.x, message.velocity.y) == (0.0, 0.0):
            self.holds.append(message.header.stamp.to_sec())

    def _on_position(self, message: PoseStamped) -> None:
        self.holds.append(message.header.stamp.to_sec())

    def _on_state(self, message: State) -> None:
        self.modes.append(message.mode)


def pid_of(node: str) -> int:
    """Return the process of a node."""
    uri = rosgraph.Master("/fault_probe").lookupNode(node)
    return ServerProxy(uri).getPid("/fault_probe")[2]


def kill(node: str, height_m: float, watch: FlightWatch) -> dict:
    """Kill a node at cruising speed; return what the UAV did until it flew on."""

    def cruises() -> bool:
        _, speed, height = watch.truth[-1] if watch.truth else (0.0, 0.0, 0.0)
        return speed > CRUISE_M_S and abs(height - height_m) < 0.1

    cruised = watch.wait(cruises, PATIENCE_S)
    watch.begin()
    watch.wait(lambda: len(watch.truth) > 0, PATIENCE_S)
    killed_s = watch.truth[-1][0]
    os.kill(pid_of(node), signal.SIGKILL)
    watch.wait(lambda: watch.truth[-1][1] < SLOWED_M_S, PATIENCE_S)  # it may be back before that
    back = watch.wait(cruises, PATIENCE_S)
    truth, holds = list(watch.truth), list(watch.holds)
    return {
        "node": node,
        "cruised": cruised,
        "hold_commanded_after_s": next((t - killed_s for t in holds if t > killed_s), None),
        "slowest": min(speed for _, speed, _ in truth),
        "lowest": min(height for _, _, height in truth),
        "flew_on": back,
        "flew_on_after_s": truth[-1][0] - killed_s,
        "modes": sorted(set(watch.modes)),
    }


def main(x_m: float, height_m: float, nodes: list[str]) -> int:
    """Kill each of the nodes."""
    rospy.init_node("fault_probe")
    watch = FlightWatch()
    watch.wait(lambda: watch.x_m > x_m, PATIENCE_S)
    for node in nodes:
        print(json.dumps(kill(node, height_m, watch)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]), float(sys.argv[2]), sys.argv[3:]))
