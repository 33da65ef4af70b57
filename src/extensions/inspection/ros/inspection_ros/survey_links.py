"""What the node `inspect` publishes: where to go, where to look, feedback, result, and what RViz shows."""

from __future__ import annotations

import math

import numpy as np
import rospy
from flight_basics_ros.setpoints import SetpointSender
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3, Vector3Stamped
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Header, String
from visualization_msgs.msg import MarkerArray

from flight_basics.errand.leader import Here
from inspection.flight.leader import SurveyLeader
from inspection.flight.second_look import SearchState
from inspection.msg import SurveyFeedback, SurveyResult
from inspection_ros import messages
from inspection_ros.photographer import Photographer


class SurveyLinks:
    """Publishes pos_setpoint, front, ~markers and ~search; see `flight_basics_ros.errand_server.Links`.

    Args:
        leader: of what is flown. photographer: tilts the camera. goal_frame, base_frame: of the setpoints,
            and of the UAV.
    """

    def __init__(
        self, leader: SurveyLeader, photographer: Photographer, goal_frame: str, base_frame: str
    ) -> None:
        self._leader, self._photographer = leader, photographer
        self._goal_frame, self._base_frame = goal_frame, base_frame
        self._sent_tilt: float | None = None
        self._setpoints = SetpointSender()
        self._fronts = rospy.Publisher("front", Vector3Stamped, queue_size=1, tcp_nodelay=True)
        self._search = rospy.Publisher("~search", String, queue_size=1, latch=True)
        self._told_search: SearchState | None = None
        self._tell_search(SearchState.IDLE)
        self._markers = rospy.Publisher("~markers", MarkerArray, queue_size=1, latch=True)

    def result(self, words: str, has_result: bool) -> SurveyResult:
        """Return the result."""
        if not has_result or self._leader.inspection is None:
            return SurveyResult(reason=words)
        return messages.result_of(self._leader.inspection)

    def send(self, setpoint: np.ndarray | None, here: Here | None) -> None:
        """Publish where to fly and to tilt, if that is new, and where the front is to point."""
        inspection = self._leader.inspection
        if inspection is None or here is None:
            return
        if setpoint is not None:
            self._setpoints.send(Pose(Point(*setpoint), Quaternion(0.0, 0.0, 0.0, 1.0)))
        if inspection.front_rad is not None:
            turn = inspection.front_rad - here.more.motion.yaw_rad
            header = Header(stamp=rospy.Time(here.stamp_s), frame_id=self._base_frame)
            self._fronts.publish(Vector3Stamped(header, Vector3(math.cos(turn), math.sin(turn), 0.0)))
        if inspection.tilt_rad != self._sent_tilt:
            self._sent_tilt = inspection.tilt_rad
            self._photographer.tilt(inspection.tilt_rad)

    def feedback(self, here: Here, battery: BatteryState | None) -> SurveyFeedback:
        """Publish the markers, and return the feedback."""
        inspection = self._leader.inspection
        assert inspection is not None
        header = Header(stamp=rospy.Time(here.stamp_s), frame_id=self._goal_frame)
        self._markers.publish(messages.markers_of(inspection, here.place_m, header))
        return messages.feedback_of(inspection, battery, self._leader.has_map)

    def settled(self) -> None:
        """Publish whether photographs are searched for what to photograph next, if that is new."""
        self._tell_search(self._leader.search)

    def _tell_search(self, state: SearchState) -> None:
        if state is not self._told_search:
            self._told_search = state
            self._search.publish(state.value)
