"""Serves closer looks at a point while a survey is flown."""

from __future__ import annotations

import numpy as np
import rospy
from flight_basics_ros.errand_server import ErrandServer
from geometry_msgs.msg import Point, PointStamped

from flight_basics.errand.messages import Answer, Question
from inspection.flight.leader import SurveyLeader
from inspection.srv import LookCloser, LookCloserRequest, LookCloserResponse


class CloserLooks:
    """Serves ~look_closer (inspection/LookCloser); takes /clicked_point (geometry_msgs/PointStamped).

    Args:
        server: the worker's thread asks the leader. goal_frame: of points.
    """

    def __init__(self, server: ErrandServer, leader: SurveyLeader, goal_frame: str) -> None:
        self._server, self._leader, self._goal_frame = server, leader, goal_frame
        rospy.Service("~look_closer", LookCloser, self._look_closer)
        server.subscribe("/clicked_point", PointStamped, self._on_click, 1)

    def _on_click(self, clicked: PointStamped) -> None:
        frame = clicked.header.frame_id.lstrip("/")
        if frame != self._goal_frame:
            self._server.say(f'The point is in frame "{frame}", not in "{self._goal_frame}".')
            return
        self._server.put(self._asked(clicked.point))

    def _look_closer(self, request: LookCloserRequest) -> LookCloserResponse:
        return LookCloserResponse(*self._server.ask(self._asked(request.point)))

    def _asked(self, point: Point) -> Question:
        point_m = np.array((point.x, point.y, point.z))

        def answer(here_m: np.ndarray | None) -> Answer:
            told = self._leader.look_closer(point_m, here_m)
            rospy.loginfo("%s", told.words)
            return told

        return Question(answer, needs_flight=True)
