"""Opens the camera's shutter once while the graph is listened to."""

from __future__ import annotations

import threading

import roslib.message
import rospy

from node_tools.services import ServiceCall

SERVICE, KIND = "/camera/shoot", "simulation_tools/Shoot"
PATIENCE_S = 3.0


class Shutter:
    """One shot.

    Attributes:
        said: what went wrong, in words; empty: the shutter opened; None: there is no such service.
    """

    def __init__(self) -> None:
        self.said: str | None = None

    def open_after(self, delay_s: float) -> None:
        """Open it in a thread of its own, after a wall time."""
        timer = threading.Timer(delay_s, self._open)
        timer.daemon = True
        timer.start()

    def _open(self) -> None:
        found = roslib.message.get_service_class(KIND)
        if found is None:
            return
        try:
            answer = ServiceCall(SERVICE, found, PATIENCE_S)(not_before=rospy.Time(0))
        except rospy.ServiceException as error:
            self.said = None if "there is no such service" in str(error) else str(error)
        else:
            self.said = "" if answer.success else answer.status_message
