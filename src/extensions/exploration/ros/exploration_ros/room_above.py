"""Serves how far a UAV that stands may rise."""

from __future__ import annotations

import math
import threading
from typing import Callable

import numpy as np
import rospy

from exploration.planning import PathPlanner
from exploration.srv import RoomAbove, RoomAboveRequest, RoomAboveResponse
from flight_basics.errors import FlightBasicsError


def serve_room_above(
    planner: PathPlanner, planner_lock: threading.Lock, here: Callable[[], np.ndarray | None]
) -> rospy.Service:
    """Serve ~room_above (exploration/RoomAbove).

    planner: asked under its lock. here: returns the place (x, y, z) of the UAV; None: it is not known.
    """

    def answer(request: RoomAboveRequest) -> RoomAboveResponse:
        here_m = here()
        if here_m is None:
            return RoomAboveResponse(message="The place of the UAV is not known yet.")
        if not (math.isfinite(request.wanted) and request.wanted >= 0.0):
            return RoomAboveResponse(message=f"A UAV cannot rise by {request.wanted} m.")
        try:
            with planner_lock:
                return RoomAboveResponse(True, "", planner.room_above_m(here_m, request.wanted))
        except FlightBasicsError as error:
            return RoomAboveResponse(message=str(error))

    return rospy.Service("~room_above", RoomAbove, answer)
