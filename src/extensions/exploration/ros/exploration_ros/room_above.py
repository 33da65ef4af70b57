"""Serves how far a UAV that stands may rise."""

from __future__ import annotations

import math

import numpy as np
import rospy
from flight_basics_ros.errand_server import ErrandServer

from exploration.planning import PathPlanner
from exploration.srv import RoomAbove, RoomAboveRequest, RoomAboveResponse
from flight_basics.errand.messages import Answer, Question
from flight_basics.errors import FlightBasicsError


def serve_room_above(server: ErrandServer, planner: PathPlanner) -> rospy.Service:
    """Serve ~room_above (exploration/RoomAbove). planner: asked in the worker's thread."""

    def answer(request: RoomAboveRequest) -> RoomAboveResponse:
        told = server.ask(Question(lambda here_m: room_above(planner, here_m, request.wanted)))
        return RoomAboveResponse(message=told.words) if isinstance(told, Answer) else told

    return rospy.Service("~room_above", RoomAbove, answer)


def room_above(planner: PathPlanner, here_m: np.ndarray | None, rise_max_m: float) -> RoomAboveResponse:
    """Return how far a UAV at a place (x, y, z) may rise. here_m: None: it is not known."""
    if here_m is None:
        return RoomAboveResponse(message="The place of the UAV is not known yet.")
    if not (math.isfinite(rise_max_m) and rise_max_m >= 0.0):
        return RoomAboveResponse(message=f"A UAV cannot rise by {rise_max_m} m.")
    try:
        return RoomAboveResponse(True, "", planner.room_above_m(here_m, rise_max_m))
    except FlightBasicsError as error:
        return RoomAboveResponse(message=str(error))
