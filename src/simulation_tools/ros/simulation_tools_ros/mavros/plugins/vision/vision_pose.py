"""MAVROS's plugin `vision_pose_estimate`."""

from __future__ import annotations

from typing import Sequence

import rospy
from geometry_msgs.msg import Pose, PoseStamped, PoseWithCovarianceStamped
from std_msgs.msg import Header

from node_tools.conversions import xyz, xyzw
from simulation_tools.mavros.external_estimates import UNKNOWN_6X6, pose_estimate
from simulation_tools_ros.mavros.uas import Uas


class VisionPosePlugin:
    """Takes vision_pose/{pose,pose_cov}, ENU, of FLU. A second message of one stamp is dropped.

    MAVROS's ~vision_pose/tf/listen does not exist here.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._last_stamp = rospy.Time()
        uas.subscribe("vision_pose/pose", PoseStamped, self._on_pose, queue_size=10)
        uas.subscribe("vision_pose/pose_cov", PoseWithCovarianceStamped, self._on_pose_cov, queue_size=10)

    def _on_pose(self, message: PoseStamped) -> None:
        self._forward("vision_pose/pose", message.header, message.pose, UNKNOWN_6X6)

    def _on_pose_cov(self, message: PoseWithCovarianceStamped) -> None:
        pose = message.pose
        self._forward("vision_pose/pose_cov", message.header, pose.pose, pose.covariance)

    def _forward(self, topic: str, header: Header, pose: Pose, covariance: Sequence[float]) -> None:
        if header.stamp == self._last_stamp:
            return
        self._last_stamp = header.stamp
        time_us = header.stamp.to_nsec() // 1000
        self._uas.send_built(
            f"An estimate on {topic}",
            lambda: pose_estimate(time_us, xyz(pose.position), xyzw(pose.orientation), covariance),
        )
