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
from tf2_msgs.msg import TFMessage

HEARD = ("/scan/padded", "/UAV/vel_setpoint/raw/body", "/UAV/odometry", "/tf", "/tf_static")
ANSWER = "/UAV/vel_setpoint/safe/body"
START_S, DURATION_S, RATE = "8", "7", "0.5"  # from the hover into the flight; slowly, for a slow machine
NEAR_M_S = 0.05


def main(bag: str) -> int:
    """Play, listen, compare."""
    rospy.init_node("playback_probe", disable_signals=True)
    rospy.set_param("/use_sim_time", True)
    answers = {}

    def on_answer(message: TwistStamped) -> None:
        answers[message.header.stamp.to_nsec()] = velocity(message)

    rospy.Subscriber(ANSWER, TwistStamped, on_answer, queue_size=1000)
    rospy.Subscriber("/tf", TFMessage)  # CEPA looks for frames only when it needs one
    rospy.Subscriber("/tf_static", TFMessage)
    Client("/cepa", timeout=30)  # it is there, and ready
    when = ("--delay", "1", "--start", START_S, "--duration", DURATION_S, "--rate", RATE)
    play = ("rosbag", "play", "--quiet", "--clock", "--wait-for-subscribers")
    subprocess.run([*play, *when, bag, "--topics", *HEARD], check=True)
    with rosbag.Bag(bag) as recorded:
        flown = {m.header.stamp.to_nsec(): velocity(m) for _, m, _ in recorded.read_messages([ANSWER])}
    expected = {stamp: v for stamp, v in flown.items() if min(answers) <= stamp <= max(answers)}
    apart = [
        max(abs(a - b) for a, b in zip(answers[stamp], expected[stamp]))
        for stamp in expected
        if stamp in answers
    ]
    figures = {
        "expected": len(expected),
        "answered": len(apart),
        "equal": apart.count(0.0),
        "near": sum(distance < NEAR_M_S for distance in apart),
    }
    print(json.dumps(figures), flush=True)
    return 0


def velocity(message: TwistStamped) -> tuple:
    """Return what is commanded."""
    linear = message.twist.linear
    return (linear.x, linear.y, linear.z)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
