#!/usr/bin/env python3
"""A UAV on the bench that is turned by hand: publishes /scan, /UAV/odometry and TF as its drivers would.

usage: turning_uav.py TURN_DEG [mirrored]

It stands in a rectangular room, and is turned whenever someone has begun to listen to /scan. The lidar is
mounted with a yaw of 30 degrees. mirrored: its beams come in the wrong order, as of a lidar upside down.
"""

from __future__ import annotations

import math
import sys

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

HALF_SIZES_M, PLACE_M = (2.0, 5.0), (0.7, -1.5)
MOUNT_RAD = math.radians(30.0)
FIRST_RAD, STEP_RAD, BEAMS = math.radians(-135.0), math.radians(0.5), 541
BEGINS_S, LASTS_S, RATE_HZ = 0.5, 1.0, 20.0


def ranges_m(heading_rad: float, mirrored: bool) -> np.ndarray:
    """Return the distances to the walls along the beams, in closed form."""
    angles = heading_rad + MOUNT_RAD + FIRST_RAD + STEP_RAD * np.arange(BEAMS)
    with np.errstate(divide="ignore"):
        to_walls = [
            np.where(along > 0.0, (size - at) / along, (-size - at) / along)
            for along, size, at in zip((np.cos(angles), np.sin(angles)), HALF_SIZES_M, PLACE_M)
        ]
    ranges = np.minimum(*to_walls)
    return ranges[::-1] if mirrored else ranges


def main(turn_rad: float, mirrored: bool) -> None:
    """Publish until ROS ends."""
    rospy.init_node("turning_uav")
    scans = rospy.Publisher("/scan", LaserScan, queue_size=1)
    odometry = rospy.Publisher("/UAV/odometry", Odometry, queue_size=1)
    frames = tf2_ros.StaticTransformBroadcaster()
    mount = TransformStamped()
    mount.header.frame_id, mount.child_frame_id = "base_frame", "hokuyo"
    mount.transform.rotation.z, mount.transform.rotation.w = math.sin(MOUNT_RAD / 2), math.cos(MOUNT_RAD / 2)
    frames.sendTransform(mount)
    rate, ticks = rospy.Rate(RATE_HZ), 0
    while not rospy.is_shutdown():
        ticks = ticks + 1 if scans.get_num_connections() else 0
        heading_rad = turn_rad * min(max((ticks / RATE_HZ - BEGINS_S) / LASTS_S, 0.0), 1.0)
        told = Odometry()
        told.pose.pose.orientation.z, told.pose.pose.orientation.w = (
            math.sin(heading_rad / 2),
            math.cos(heading_rad / 2),
        )
        odometry.publish(told)
        scan = LaserScan(angle_min=FIRST_RAD, angle_increment=STEP_RAD, range_min=0.05, range_max=30.0)
        scan.header.stamp, scan.header.frame_id = rospy.Time.now(), "hokuyo"
        scan.ranges = ranges_m(heading_rad, mirrored).tolist()
        scans.publish(scan)
        rate.sleep()


if __name__ == "__main__":
    main(math.radians(float(sys.argv[1])), "mirrored" in sys.argv)
