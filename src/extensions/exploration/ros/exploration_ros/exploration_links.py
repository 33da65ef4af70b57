"""What the node `explore` publishes: setpoints, feedback, result, and what RViz shows."""

from __future__ import annotations

from typing import Any

import numpy as np
import rospy
from flight_basics_ros.setpoints import SetpointSender
from geometry_msgs.msg import Point, Pose, Quaternion
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from exploration.msg import ExploreFeedback, ExploreResult
from exploration.next_view.leader import ExplorationLeader
from exploration_ros import exploration_messages
from flight_basics.errand.leader import Here


class ExplorationLinks:
    """Publishes pos_setpoint and ~markers; see `flight_basics_ros.errand_server.Links`.

    frame: of poses and setpoints.
    """

    def __init__(self, leader: ExplorationLeader, frame: str) -> None:
        self._leader, self._frame = leader, frame
        self._setpoints = SetpointSender()
        self._markers = rospy.Publisher("~markers", MarkerArray, queue_size=1, latch=True)

    def result(self, words: str, has_result: bool) -> ExploreResult:
        """Return the result."""
        if not has_result or self._leader.exploration is None:
            return ExploreResult(reason=words)
        return exploration_messages.result_of(self._leader.exploration)

    def send(self, setpoint: np.ndarray | None, here: Here | None) -> None:
        """Publish a new setpoint."""
        if setpoint is not None:
            self._setpoints.send(Pose(Point(*setpoint), Quaternion(0.0, 0.0, 0.0, 1.0)))

    def feedback(self, here: Here, battery: BatteryState | None) -> ExploreFeedback:
        """Publish the markers, and return the feedback."""
        exploration = self._leader.exploration
        assert exploration is not None
        feedback = exploration_messages.feedback_of(
            exploration, battery, self._leader.rate_per_s, self._leader.has_map
        )
        header = Header(stamp=rospy.Time(here.stamp_s), frame_id=self._frame)
        self._markers.publish(exploration_messages.markers_of(exploration, feedback, here.place_m, header))
        return feedback

    def settled(self) -> Any:
        """Nothing else is to be told."""
