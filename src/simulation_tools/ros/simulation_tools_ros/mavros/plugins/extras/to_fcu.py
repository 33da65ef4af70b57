"""MAVROS's plugins that only pass messages on: obstacle_distance, mocap_pose_estimate, statustext, ..."""

from __future__ import annotations

import rospy
from geometry_msgs.msg import Pose, PoseStamped, TransformStamped
from mavros_msgs.msg import ManualControl, StatusText
from pymavlink.dialects.v20 import common
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from node_tools.conversions import xyz, xyzw
from simulation_tools.errors import SimulationToolsError
from simulation_tools.mavros.told import (
    FRAMES,
    Scan,
    manual_control,
    mocap_estimate,
    obstacle_distance,
    status_text,
)
from simulation_tools_ros.mavros.uas import Uas


class ObstacleDistancePlugin:
    """Takes obstacle/send (sensor_msgs/LaserScan, clockwise as FRD). Parameter: ~obstacle/mav_frame."""

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        name = str(rospy.get_param("~obstacle/mav_frame", "GLOBAL"))
        if name not in FRAMES:
            raise SimulationToolsError(
                f"~obstacle/mav_frame must be one of {', '.join(FRAMES)}, not {name!r}."
            )
        self._frame = FRAMES[name]
        uas.subscribe("obstacle/send", LaserScan, self._on_scan, queue_size=10)

    def _on_scan(self, message: LaserScan) -> None:
        scan = Scan(
            message.ranges,
            message.angle_min,
            message.angle_increment,
            message.range_min,
            message.range_max,
        )
        time_us = message.header.stamp.to_nsec() // 1000
        self._uas.send_built("A scan on obstacle/send", lambda: obstacle_distance(time_us, scan, self._frame))


class MocapPlugin:
    """Takes mocap/pose, or mocap/tf, ENU, of FLU. Parameters: ~mocap/{use_pose,use_tf}, one of both."""

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        use_pose, use_tf = (
            rospy.get_param(f"~mocap/{one}", one == "use_pose") for one in ("use_pose", "use_tf")
        )
        if use_pose == use_tf:
            rospy.logerr("Use one motion capture source: mocap/use_pose or mocap/use_tf.")
        elif use_pose:
            uas.subscribe("mocap/pose", PoseStamped, lambda m: self._on_pose("mocap/pose", m.header, m.pose))
        else:
            uas.subscribe("mocap/tf", TransformStamped, self._on_transform)

    def _on_transform(self, message: TransformStamped) -> None:
        move = message.transform
        self._on_pose("mocap/tf", message.header, Pose(move.translation, move.rotation))

    def _on_pose(self, topic: str, header: Header, pose: Pose) -> None:
        time_us = header.stamp.to_nsec() // 1000
        self._uas.send_built(
            f"An estimate on {topic}",
            lambda: mocap_estimate(time_us, xyz(pose.position), xyzw(pose.orientation)),
        )


class StatusTextPlugin:
    """Takes statustext/send (mavros_msgs/StatusText) for ground stations and the flight controller's log."""

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        uas.subscribe("statustext/send", StatusText, self._on_text, queue_size=10)

    def _on_text(self, message: StatusText) -> None:
        self._uas.send_built("A text on statustext/send", lambda: status_text(message.severity, message.text))


class ManualControlPlugin:
    """Takes manual_control/send; publishes manual_control/control: what another pilot sends, -1 to 1.

    As in MAVROS, only x, y, z, r and buttons are passed on.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._control = uas.advertise("manual_control/control", ManualControl)
        uas.subscribe("manual_control/send", ManualControl, self._on_sticks)
        uas.client.on("MANUAL_CONTROL", self._on_control)

    def _on_sticks(self, m: ManualControl) -> None:
        self._uas.send_built(
            "A message on manual_control/send",
            lambda: manual_control(self._uas.client.target, (m.x, m.y, m.z, m.r), m.buttons),
        )

    def _on_control(self, m: common.MAVLink_message) -> None:
        self._control.publish(
            lambda: ManualControl(
                header=Header(stamp=self._uas.now),
                x=1e-3 * m.x,
                y=1e-3 * m.y,
                z=1e-3 * m.z,
                r=1e-3 * m.r,
                buttons=m.buttons,
            )
        )
