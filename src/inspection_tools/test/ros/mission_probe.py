"""Flies a mission for a test: sends a latched goal, is where standard input says, prints setpoints.

Places are "x y z", a line each; so are the setpoints. It ends with its standard input.
"""

from __future__ import annotations

import sys
import threading
import time

import rospy
from geometry_msgs.msg import Point, Pose
from nav_msgs.msg import Odometry

from inspection_tools.msg import MissionActionGoal

PERIOD_S = 0.05


def main() -> None:
    """Publish where the UAV is, again and again."""
    rospy.init_node("mission_probe")
    rospy.Subscriber("pos_setpoint", Pose, show)
    goals = rospy.Publisher("mission/fly/goal", MissionActionGoal, queue_size=1, latch=True)
    goal = MissionActionGoal()
    goal.goal_id.id = "one"
    goals.publish(goal)
    poses = rospy.Publisher("odometry", Odometry, queue_size=1)
    place = [0.0, 0.0, 2.0]
    threading.Thread(target=move, args=(place,), daemon=True).start()
    while place and not rospy.is_shutdown():
        message = Odometry()
        message.header.stamp = rospy.Time.now()
        message.header.frame_id, message.child_frame_id = "odom", "base_frame"
        message.pose.pose.position = Point(*place)
        message.pose.pose.orientation.w = 1.0
        poses.publish(message)
        time.sleep(PERIOD_S)


def show(setpoint: Pose) -> None:
    """Print a setpoint."""
    p = setpoint.position
    print(f"{p.x:g} {p.y:g} {p.z:g}", flush=True)


def move(place: list) -> None:
    """Be where standard input says; nowhere at its end."""
    for line in sys.stdin:
        place[:] = map(float, line.split())
    place.clear()


if __name__ == "__main__":
    main()
