"""Carries out the actions of `mavros_publisher`'s state machine."""

from __future__ import annotations

import math
import time
from typing import Any, Callable

import rospy
from geographic_msgs.msg import GeoPointStamped
from geometry_msgs.msg import Point, PoseStamped, Quaternion
from geometry_msgs.msg import Vector3 as Vector3Message
from mavros_msgs.msg import AttitudeTarget, PositionTarget
from mavros_msgs.srv import CommandBool, CommandTOL, SetMode
from std_msgs.msg import Bool, Header, String

from node_tools.conversions import time_of
from node_tools.direct_publisher import DirectPublisher
from node_tools.services import ServiceCall
from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.geometry import quaternion_from_rpy
from simulation_tools.publisher import (
    Action,
    AnnounceReady,
    AnnounceStatus,
    Log,
    RequestArm,
    RequestMode,
    RequestTakeoff,
    SendLevel,
    SendPosition,
    SendVelocity,
    SetOrigin,
)
from simulation_tools_ros.mavros_publisher.request_thread import RequestThread

PLACE = GeodeticOrigin()
"""Where the flight controller is told to be, if nobody says where."""
REQUEST_PATIENCE_S = 0.5  # wall time; the flight controller misses setpoints after 1 s

ANSWER_S = 6.0
"""Wall time after which a request counts as lost. MAVROS itself waits 5 s for the flight controller."""

VELOCITY_AND_YAW_RATE = (
    PositionTarget.IGNORE_PX
    | PositionTarget.IGNORE_PY
    | PositionTarget.IGNORE_PZ
    | PositionTarget.IGNORE_AFX
    | PositionTarget.IGNORE_AFY
    | PositionTarget.IGNORE_AFZ
    | PositionTarget.IGNORE_YAW
)
ATTITUDE_ALONE = (
    AttitudeTarget.IGNORE_ROLL_RATE | AttitudeTarget.IGNORE_PITCH_RATE | AttitudeTarget.IGNORE_YAW_RATE
)


class Actions:
    """Publishes setpoints, asks MAVROS for modes and arming, and publishes the status.

    Publishes: mavros/setpoint_raw/local (velocities, frame BODY_NED), mavros/setpoint_position/local;
    mavros/setpoint_raw/attitude, from the first level descent on; ready (Bool, latched); waiting_for
    (std_msgs/String, latched): the reason for waiting; empty if it does not wait.
    Calls: mavros/set_mode, mavros/cmd/arming, mavros/cmd/takeoff.
    """

    def __init__(self, base_frame: str) -> None:
        """base_frame: the frame that velocity setpoints name."""
        self._base_frame = base_frame
        self._said: dict[str, float] = {}  # wall time of each repeated sentence's last log message
        self._requests = RequestThread()
        self._do: dict[type, Callable[[Any], None]] = {
            SendVelocity: self._send_velocity,
            SendPosition: self._send_position,
            SendLevel: self._send_level,
            RequestMode: self._request_mode,
            RequestArm: self._request_arm,
            RequestTakeoff: self._request_takeoff,
            SetOrigin: self._set_origin,
            AnnounceReady: lambda action: self._ready.publish(action.ready),
            AnnounceStatus: lambda action: self._waiting_for.publish(action.text),
            Log: self._log,
        }
        self._raw = DirectPublisher("mavros/setpoint_raw/local", PositionTarget, queue_size=10)
        self._position = DirectPublisher("mavros/setpoint_position/local", PoseStamped, queue_size=10)
        self._attitude: DirectPublisher | None = None
        self._origin = rospy.Publisher("mavros/global_position/set_gp_origin", GeoPointStamped, queue_size=1)
        self._ready = rospy.Publisher("ready", Bool, queue_size=1, latch=True)
        self._ready.publish(False)
        self._waiting_for = rospy.Publisher("waiting_for", String, queue_size=1, latch=True)
        self._set_mode = ServiceCall("mavros/set_mode", SetMode, ANSWER_S)
        self._arm = ServiceCall("mavros/cmd/arming", CommandBool, ANSWER_S)
        self._take_off = ServiceCall("mavros/cmd/takeoff", CommandTOL, ANSWER_S)

    def do(self, action: Action) -> None:
        """Carry out one action."""
        self._do[type(action)](action)

    def _send_velocity(self, action: SendVelocity) -> None:
        self._raw.publish(
            PositionTarget(
                header=Header(stamp=time_of(action.stamp_ns), frame_id=self._base_frame),
                coordinate_frame=PositionTarget.FRAME_BODY_NED,
                type_mask=VELOCITY_AND_YAW_RATE,
                velocity=Vector3Message(*action.linear),
                yaw_rate=action.yaw_rate,
            )
        )

    def _send_position(self, action: SendPosition) -> None:
        message = PoseStamped(header=Header(stamp=time_of(action.stamp_ns), frame_id="map"))
        message.pose.position = Point(*action.position)
        message.pose.orientation = Quaternion(*quaternion_from_rpy(0.0, 0.0, action.yaw))
        self._position.publish(message)

    def _send_level(self, action: SendLevel) -> None:
        if self._attitude is None:
            self._attitude = DirectPublisher("mavros/setpoint_raw/attitude", AttitudeTarget, queue_size=10)
        message = AttitudeTarget(header=Header(stamp=time_of(action.stamp_ns), frame_id=self._base_frame))
        message.type_mask, message.thrust = ATTITUDE_ALONE, action.thrust
        message.orientation = Quaternion(*quaternion_from_rpy(0.0, 0.0, action.yaw))
        self._attitude.publish(message)

    # In lockstep, simulated time waits for the setpoint after the request. So the request takes effect at
    # the same instant in every flight. If MAVROS hangs, the node waits once and then sends setpoints without
    # an answer.

    def _request_mode(self, action: RequestMode) -> None:
        self._requests.ask(
            lambda: self._call(self._set_mode, f"the mode {action.mode}", 0, action.mode), REQUEST_PATIENCE_S
        )

    def _request_takeoff(self, action: RequestTakeoff) -> None:
        arguments = (0.0, 0.0, 0.0, 0.0, action.height_m)
        self._requests.ask(lambda: self._call(self._take_off, "the take-off", *arguments), REQUEST_PATIENCE_S)

    def _set_origin(self, _action: SetOrigin) -> None:
        origin = GeoPointStamped(header=Header(stamp=rospy.get_rostime()))
        origin.position.latitude = float(rospy.get_param("/gazebo/latitude", PLACE.latitude_deg))
        origin.position.longitude = float(rospy.get_param("/gazebo/longitude", PLACE.longitude_deg))
        origin.position.altitude = PLACE.altitude_m
        self._origin.publish(origin)

    def _request_arm(self, _action: RequestArm) -> None:
        self._requests.ask(self._arm_now, REQUEST_PATIENCE_S)

    def _arm_now(self) -> None:
        response = self._call(self._arm, "arming", True)
        if response is not None and not response.success:
            rospy.logwarn_throttle(2.0, f"The flight controller refuses to arm (result {response.result}).")

    @staticmethod
    def _call(service: ServiceCall, what: str, *arguments: Any) -> Any:
        try:
            return service(*arguments)
        except (rospy.ServiceException, rospy.ROSException) as error:
            rospy.logwarn_throttle(2.0, f"MAVROS could not be asked for {what}: {error}.")
            return None

    def _log(self, action: Log) -> None:
        text = f"mavros_publisher: {action.text}"
        if action.repeated:
            # rospy throttles by the line of code, so one sentence would silence all others.
            if time.monotonic() - self._said.get(text, -math.inf) > 1.0:
                self._said[text] = time.monotonic()
                rospy.logwarn(text)
        elif action.is_warning:
            rospy.logwarn(text)
        else:
            rospy.loginfo(text)
