"""Lets a UAV take off, and again after a landing, no higher than there is room above it."""

from __future__ import annotations

import time
from typing import Any, Callable

import rospy
from dynamic_reconfigure.msg import Config, DoubleParameter
from dynamic_reconfigure.srv import Reconfigure
from std_srvs.srv import Trigger

from exploration.srv import RoomAbove
from flights.errors import FlightError
from flights.flight.take_off import hover_height_m
from node_tools.services import ServiceCall

PUBLISHER = "/mavros_publisher"
TRIES = 20
FIRST_TRIES = 120
"""Before the first take-off mavros_publisher may still start."""
ANSWER_S = 10.0
"""Wall time in which a service must answer. Whoever knows the map may be planning a way on it."""
AGAIN_S = 0.5
"""Wall time between two tries to call a service."""

NO_REASON = "no, and gives no reason"

Call = Callable[..., Any]


def call_service(name: str, kind: Any, *arguments: Any, tries: int = TRIES) -> Any:
    """Call a service until it succeeds, and return its answer; raises FlightError if it does not."""
    for _ in range(tries):
        try:
            answer = ServiceCall(name, kind, ANSWER_S)(*arguments)
            if getattr(answer, "success", True):
                return answer
            why = getattr(answer, "message", NO_REASON)  # MAVROS's answers about parameters have none
        except rospy.ServiceException as error:
            why = str(error)
        time.sleep(AGAIN_S)
    raise FlightError(f"The UAV does not take off: {name} says: {why}")


def take_off_again(
    node: str, usual_hover_m: float, ground_clearance_m: float, call: Call = call_service
) -> float:
    """Let the UAV rise, and return the height over the ground that it hovers at, m.

    Args:
        node: that knows the map, with the service `room_above`.
        usual_hover_m: height over the ground at which it hovers if nothing is above it.
        ground_clearance_m: height of its origin while it stands.
        call: as `call_service`.

    Raises:
        FlightError: there is too little room, or a service fails. The UAV stays on the ground.
    """
    room = call(f"{node}/room_above", RoomAbove, usual_hover_m)
    height_m = hover_height_m(room.room, usual_hover_m, ground_clearance_m)
    take_off(height_m, call)
    return height_m


def take_off(height_m: float, call: Call = call_service) -> None:
    """Let the UAV, which stands, rise to a height over the ground; raises FlightError if a service fails."""
    height = Config(doubles=[DoubleParameter("hover_height", height_m)])
    call(f"{PUBLISHER}/set_parameters", Reconfigure, height)
    call(f"{PUBLISHER}/restart", Trigger)
