"""What the node `inspect` publishes while it flies: where to go, where to look, and what RViz shows."""

from __future__ import annotations

import math
from typing import Callable

import numpy as np
import rospy
from flight_basics_ros.setpoints import SetpointSender
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3, Vector3Stamped
from std_msgs.msg import Header, String
from visualization_msgs.msg import MarkerArray

from inspection.flight import Inspection
from inspection.flight.motion import Motion
from inspection.flight.second_look import SearchState
from inspection_ros import messages

TELL_S = 0.5
"""Between two feedbacks."""


class SurveyOutputs:
    """Publishes pos_setpoint, front, ~markers and ~search.

    Args:
        goal_frame, base_frame: of the setpoints, and of the UAV. tilt: tilts the camera.
    """

    def __init__(self, goal_frame: str, base_frame: str, tilt: Callable[[float], None]) -> None:
        self._goal_frame, self._base_frame, self._tilt = goal_frame, base_frame, tilt
        self._sent_m: np.ndarray | None = None
        self._sent_tilt: float | None = None
        self._told_s = -math.inf
        self._setpoints = SetpointSender()
        self._fronts = rospy.Publisher("front", Vector3Stamped, queue_size=1, tcp_nodelay=True)
        self._search = rospy.Publisher("~search", String, queue_size=1, latch=True)
        self._told_search: SearchState | None = None
        self.tell_search(SearchState.IDLE)
        self._markers = rospy.Publisher("~markers", MarkerArray, queue_size=1, latch=True)

    def send(self, inspection: Inspection, motion: Motion, stamp_s: float) -> None:
        """Publish where to fly and to tilt, if that is new, and where the front is to point.

        stamp_s: of the motion's message.
        """
        setpoint_m = inspection.setpoint_m
        if setpoint_m is not None and setpoint_m is not self._sent_m:
            self._sent_m = setpoint_m
            self._setpoints.send(Pose(Point(*setpoint_m), Quaternion(0.0, 0.0, 0.0, 1.0)))
        if inspection.front_rad is not None:
            turn = inspection.front_rad - motion.yaw_rad
            header = Header(stamp=rospy.Time(stamp_s), frame_id=self._base_frame)
            self._fronts.publish(Vector3Stamped(header, Vector3(math.cos(turn), math.sin(turn), 0.0)))
        if inspection.tilt_rad != self._sent_tilt:
            self._sent_tilt = inspection.tilt_rad
            self._tilt(inspection.tilt_rad)

    def tell_search(self, state: SearchState) -> None:
        """Publish whether photographs are searched for what to photograph next, if that is new."""
        if state is not self._told_search:
            self._told_search = state
            self._search.publish(state.value)

    def is_time_to_tell(self, motion: Motion) -> bool:
        """Return whether the last markers and feedback are old, once."""
        if motion.time_s - self._told_s < TELL_S:
            return False
        self._told_s = motion.time_s
        return True

    def show(self, inspection: Inspection, motion: Motion, stamp_s: float) -> None:
        """Publish the markers. stamp_s: of the motion's message."""
        header = Header(stamp=rospy.Time(stamp_s), frame_id=self._goal_frame)
        self._markers.publish(messages.markers_of(inspection, motion.place_m, header))
