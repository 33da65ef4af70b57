#!/usr/bin/env python3
"""Play a recorded flight into a running CEPA and compare its answers with the recorded ones.

usage: playback_probe.py BAG        (needs a ROS master and the node cepa; prints the counts as one JSON line)
"""

from __future__ import annotations

import json
import subprocess
import sys

import rosbag
import rospy
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import TwistStamped

HEARD = ("/scan/padded", "/UAV/vel_setpoint/raw/body", "/UAV/odometry", "/tf", "/tf_static")
ANSWER = "/UAV/vel_setpoint/safe/body"
SPEED = "4"


def main(bag: str) -> int:
    """Play, listen, compare."""
    rospy.init_node("playback_probe", disable_signals=True)
    rospy.set_param("/use_sim_time", True)
    answers = {}

    def on_answer(message: TwistStamped) -> None:
        answers[message.header.stamp.to_nsec()] = velocity(message)

    rospy.Subscriber(ANSWER, TwistStamped, on_answer, queue_size=1000)
    Client("/cepa", timeout=30)  # it is there, and ready
    topics = ("--topics", *HEARD)
    subprocess.run(["rosbag", "play", "--quiet", "--clock", "-r", SPEED, "-d", "1", bag, *topics], check=True)
    with rosbag.Bag(bag) as recorded:
        expected = {m.header.stamp.to_nsec(): velocity(m) for _, m, _ in recorded.read_messages([ANSWER])}
    both = [stamp for stamp in expected if stamp in answers]
    different = [stamp for stamp in both if answers[stamp] != expected[stamp]]
    figures = {"recorded": len(expected), "answered": len(both), "different": len(different)}
    print(json.dumps(figures), flush=True)
    return 0


def velocity(message: TwistStamped) -> tuple:
    """Return what is commanded."""
    linear = message.twist.linear
    return (linear.x, linear.y, linear.z)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
