"""A graph with faults that the test knows: runs until it is ended.

A frame with two parents, a scan that sees nothing, a command, and a parameter out of what is described of it.
"""

from __future__ import annotations

import contextlib
import math

import rospy
from dynamic_reconfigure.msg import Config, ConfigDescription, DoubleParameter, Group, ParamDescription
from geometry_msgs.msg import TransformStamped, Twist
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage


def edge(parent: str, child: str) -> TransformStamped:
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id, transform.header.stamp = parent, rospy.Time.now()
    transform.transform.rotation.w = 1.0
    return transform


def main() -> None:
    rospy.init_node("probe")
    tf = rospy.Publisher("/tf", TFMessage, queue_size=10)
    scans = rospy.Publisher("/scan", LaserScan, queue_size=10)
    rospy.Publisher("/cmd_vel", Twist, queue_size=10)
    described = rospy.Publisher("~parameter_descriptions", ConfigDescription, queue_size=1, latch=True)
    low, high = (Config(doubles=[DoubleParameter("gain", value)]) for value in (0.0, 1.0))
    enum = str({"enum": [{"name": name, "value": name} for name in ("improved", "original")]})
    algorithm = ParamDescription(name="algorithm", type="str", edit_method=enum)
    group = Group(name="Default", parameters=[algorithm])
    described.publish(ConfigDescription(groups=[group], min=low, max=high))
    rospy.set_param("~gain", 7.0)
    rospy.set_param("~algorithm", "banana")
    rate = rospy.Rate(20)
    while not rospy.is_shutdown():
        edges = (("odom", "base_frame"), ("map", "base_frame"), ("base_frame", "hokuyo"))
        tf.publish(TFMessage([edge(parent, child) for parent, child in edges]))
        scan = LaserScan(angle_max=1.0, angle_increment=0.5, range_min=0.1, range_max=10.0)
        scan.ranges = [math.nan] * 3
        scan.header.frame_id, scan.header.stamp = "hokuyo", rospy.Time.now()
        scans.publish(scan)
        rate.sleep()


if __name__ == "__main__":
    with contextlib.suppress(rospy.ROSInterruptException):
        main()
