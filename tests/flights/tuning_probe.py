#!/usr/bin/env python3
"""Stop time when the UAV of a running flight passes a place, run a command, and let time go on.

usage: tuning_probe.py X COMMAND [ARGUMENT ...]        (X: metres along x in `world`; ends as COMMAND does)

Time stands still, so that it does not matter how slowly the machine starts the command.
"""

from __future__ import annotations

import subprocess
import sys
import threading

import rospy
from nav_msgs.msg import Odometry
from std_srvs.srv import Empty

PATIENCE_S = 120.0


def main(x_m: float, command: list[str]) -> int:
    """Wait, stop, run, go on."""
    rospy.init_node("tuning_probe", disable_signals=True)
    passed = threading.Event()

    def on_truth(message: Odometry) -> None:
        if message.pose.pose.position.x > x_m:
            passed.set()

    subscriber = rospy.Subscriber("/UAV/ground_truth", Odometry, on_truth, queue_size=1, tcp_nodelay=True)
    if not passed.wait(PATIENCE_S):
        print(f"the UAV did not get to x = {x_m} m within {PATIENCE_S} s")
        return 1
    subscriber.unregister()
    rospy.ServiceProxy("/gazebo/pause_physics", Empty)()
    try:
        return subprocess.run(command, check=False, timeout=PATIENCE_S).returncode
    finally:
        rospy.ServiceProxy("/gazebo/unpause_physics", Empty)()


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]), sys.argv[2:]))
