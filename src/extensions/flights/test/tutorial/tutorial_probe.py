"""Sends scans and references until somebody answers, and prints the answer: stamp, x, y."""

from __future__ import annotations

import math

import rospy
from geometry_msgs.msg import TwistStamped
from sensor_msgs.msg import LaserScan


def main() -> None:
    rospy.init_node("probe")
    answers: list[TwistStamped] = []
    rospy.Subscriber("vel_setpoint_out", TwistStamped, answers.append)
    scans = rospy.Publisher("scan_in", LaserScan, queue_size=1)
    references = rospy.Publisher("vel_setpoint_in", TwistStamped, queue_size=1)
    scan = LaserScan(angle_min=-math.pi / 2, angle_increment=math.pi / 2, range_min=0.1, range_max=10.0)
    scan.ranges = [math.inf, 1.0, 0.5, math.nan]
    reference = TwistStamped()
    reference.twist.linear.x = reference.twist.linear.z = 1.0
    reference.header.stamp = scan.header.stamp = rospy.Time(100)
    while not any(answer.twist.linear.z == 1.0 for answer in answers):  # else to a scan without the reference
        references.publish(reference)
        rospy.sleep(0.1)
        scans.publish(scan)
    answer = next(answer for answer in answers if answer.twist.linear.z == 1.0)
    print(answer.header.stamp.to_sec(), answer.twist.linear.x, answer.twist.linear.y)


if __name__ == "__main__":
    main()
