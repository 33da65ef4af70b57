"""What the node `mission` publishes: setpoints, feedback, result, and the waypoints for RViz."""

from __future__ import annotations

from typing import Any

import rospy
from flight_basics_ros.setpoints import SetpointSender
from geometry_msgs.msg import PoseArray

from flight_basics.errand.leader import Here
from inspection_tools import Waypoint
from inspection_tools.mission.leader import MissionLeader, Target
from inspection_tools.msg import MissionFeedback, MissionResult
from inspection_tools_ros import mission_messages


class MissionLinks:
    """Publishes pos_setpoint and ~waypoints; see `flight_basics_ros.errand_server.Links`.

    Args:
        frame: of poses and setpoints.

    Attributes:
        leader: set it before the first goal.
    """

    leader: MissionLeader

    def __init__(self, frame: str) -> None:
        self._frame = frame
        self._setpoints = SetpointSender()
        self._plans = rospy.Publisher("~waypoints", PoseArray, queue_size=1, latch=True)

    def show(self, waypoints: tuple[Waypoint, ...]) -> None:
        """Publish the waypoints of a mission that begins."""
        self._plans.publish(mission_messages.plan(waypoints, self._frame))

    def result(self, words: str, has_result: bool) -> MissionResult:
        """Return the result."""
        return MissionResult(reached=self.leader.reached if has_result else 0)

    def send(self, setpoint: Target | None, here: Here | None) -> None:
        """Publish a new setpoint."""
        if setpoint is not None:
            self._setpoints.send(mission_messages.setpoint(setpoint.position_m, setpoint.yaw_rad))

    def feedback(self, here: Here, battery: Any) -> MissionFeedback:
        """Return the feedback."""
        status = self.leader.status
        if status is None:  # it was cancelled before its first pose
            return MissionFeedback()
        target = mission_messages.setpoint(status.target.position_m, status.target.yaw_rad)
        return MissionFeedback(status.reached, status.of, target, status.distance_m)

    def settled(self) -> None:
        """Nothing else is to be told."""
