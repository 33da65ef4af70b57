"""MAVROS's plugin `vision_speed_estimate`."""

from __future__ import annotations

from typing import Sequence

import rospy
from geometry_msgs.msg import TwistStamped, TwistWithCovarianceStamped, Vector3, Vector3Stamped
from std_msgs.msg import Header

from node_tools.conversions import xyz
from simulation_tools.mavros.external_estimates import UNKNOWN_3X3, speed_estimate
from simulation_tools_ros.mavros.uas import Uas


class VisionSpeedPlugin:
    """Takes one of vision_speed/{speed_twist_cov,speed_twist,speed_vector}, ENU, as MAVROS does.

    Parameters: ~vision_speed/listen_twist (else the vector), ~vision_speed/twist_cov (else without
    covariance).
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        if not rospy.get_param("~vision_speed/listen_twist", True):
            uas.subscribe("vision_speed/speed_vector", Vector3Stamped, self._on_vector, queue_size=10)
        elif rospy.get_param("~vision_speed/twist_cov", True):
            uas.subscribe(
                "vision_speed/speed_twist_cov", TwistWithCovarianceStamped, self._on_cov, queue_size=10
            )
        else:
            uas.subscribe("vision_speed/speed_twist", TwistStamped, self._on_twist, queue_size=10)

    def _on_vector(self, message: Vector3Stamped) -> None:
        self._forward("vision_speed/speed_vector", message.header, message.vector, UNKNOWN_3X3)

    def _on_cov(self, message: TwistWithCovarianceStamped) -> None:
        c = message.twist.covariance
        linear = (*c[0:3], *c[6:9], *c[12:15])
        self._forward("vision_speed/speed_twist_cov", message.header, message.twist.twist.linear, linear)

    def _on_twist(self, message: TwistStamped) -> None:
        self._forward("vision_speed/speed_twist", message.header, message.twist.linear, UNKNOWN_3X3)

    def _forward(self, topic: str, header: Header, velocity: Vector3, covariance: Sequence[float]) -> None:
        time_us = header.stamp.to_nsec() // 1000
        self._uas.send_built(
            f"An estimate on {topic}", lambda: speed_estimate(time_us, xyz(velocity), covariance)
        )
