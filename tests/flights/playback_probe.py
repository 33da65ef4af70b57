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

HEARD = ("/scan/padded", "/UAV/vel_setpoint/raw/body", "/UAV/odometry", "/tf_static")
ANSWER = "/UAV/vel_setpoint/safe/body"
RATE = 3.0
PLAY = ("rosbag", "play", "--quiet", "--clock", "--delay", "6", "--queue", "0", "--rate", f"{RATE:g}")
UNTIL_READ = ("--wait-for-subscribers", "--keep-alive")
"""Nothing is played before CEPA listens, and the player stays until CEPA has read its last message."""
SPARE_S = 90.0  # wall time beside that of the bag: a busy machine begins late, and plays slower


def main(bag: str) -> int:
    """Play, listen, compare."""
    rospy.init_node("playback_probe", disable_signals=True)
    rospy.set_param("/use_sim_time", True)
    answers = {}

    def on_answer(message: TwistStamped) -> None:
        answers[message.header.stamp.to_nsec()] = velocity(message)

    rospy.Subscriber(ANSWER, TwistStamped, on_answer, queue_size=None)
    Client("/cepa", timeout=120)  # it is there, and ready
    with rosbag.Bag(bag) as recorded:
        flown = {m.header.stamp.to_nsec(): velocity(m) for _, m, _ in recorded.read_messages([ANSWER])}
        length_s = recorded.get_end_time() - recorded.get_start_time()
    player = subprocess.Popen([*PLAY, *UNTIL_READ, bag, "--topics", *HEARD])
    waited_s = 0.0
    while not flown.keys() <= answers.keys() and waited_s < length_s / RATE + SPARE_S:
        assert player.poll() is None, f"rosbag play ended with {player.returncode}"
        rospy.rostime.wallsleep(0.1)
        waited_s += 0.1
    player.terminate()
    player.wait()
    differing = [stamp for stamp, answer in flown.items() if answers.get(stamp, answer) != answer]
    figures = {
        "recorded": len(flown),
        "unanswered_at_s": [1e-9 * stamp for stamp in flown if stamp not in answers],
        "moving": sum(any(answer) for answer in flown.values()),
        "different_at_s": [1e-9 * stamp for stamp in differing],
    }
    print(json.dumps(figures), flush=True)
    return 0


def velocity(message: TwistStamped) -> tuple:
    """Return what is commanded."""
    linear = message.twist.linear
    return (linear.x, linear.y, linear.z)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
