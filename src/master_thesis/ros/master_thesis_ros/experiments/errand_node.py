"""The node of a flight that another node leads by an action: it swaps the battery between, and lands."""

from __future__ import annotations

import threading
import time
from enum import Enum
from typing import Iterable, Sequence

import rospy
from actionlib_msgs.msg import GoalStatus
from mavros_msgs.msg import State
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from master_thesis.flight.monitor import Monitor
from master_thesis_ros.experiments.flight_node import FlightNode

SWAP_TRIES = 20
AGAIN_S = 0.5
"""Wall time between two tries to swap the battery."""


class ErrandNode(FlightNode):
    """Lets another node fly to the end, with fresh batteries between. A subclass sends its goal.

    Calls, besides what `FlightNode` does: gazebo/swap_battery, mavros_publisher/restart (std_srvs/Trigger).

    Attributes:
        swapped: batteries that were swapped.
    """

    def __init__(self, monitor: Monitor, swaps: int, lockstep: bool) -> None:
        """swaps: of the battery, at most."""
        self._swaps, self.swapped = swaps, 0
        self._swaps_now = self._must_send = self._is_ready = False
        super().__init__(monitor, lockstep)

    def _on_end(self, status: GoalStatus, end: str, is_home: bool, reason: str) -> Iterable[Enum]:
        """Take the action's result: swap the battery, or end the flight."""
        if status.status != GoalStatus.SUCCEEDED:
            return self._monitor.abort(f"The flight was refused: {status.text}")
        if end == "battery" and is_home and self.swapped < self._swaps:
            self.swapped += 1
            self._swaps_now = self._monitor.course.lands_between = True
            rospy.loginfo("The UAV lands at home for a full battery.")
            threading.Thread(target=self._land, daemon=True).start()
            return ()
        if not is_home:
            self._monitor.land_here(f"The UAV did not come home: {reason}")
            return ()
        self._monitor.on_goal_reached(True)
        return ()

    def _on_state(self, message: State) -> Iterable[Enum]:
        if not self._swaps_now:
            return super()._on_state(message)
        if message.connected and not message.armed and self._armed:
            threading.Thread(target=self._swap, daemon=True).start()
        self._armed = message.armed if message.connected else None
        return ()

    def _decisions(self) -> Sequence[Enum]:
        if self._swaps_now:
            return self._monitor.decide()
        return super()._decisions()

    def _swap(self) -> None:
        """Put in a full battery and take off again."""
        for name in ("/gazebo/swap_battery", "/mavros_publisher/restart"):
            for _ in range(SWAP_TRIES):
                try:
                    answer = rospy.ServiceProxy(name, Trigger)()
                    if answer.success:
                        break
                    why = answer.message
                except rospy.ServiceException as error:
                    why = str(error)
                time.sleep(AGAIN_S)
            else:
                rospy.logerr(f"The battery was not swapped: {name} says: {why}")
                return
        rospy.loginfo("The UAV has a full battery and takes off again.")
        self._must_send = True

    def _on_ready(self, message: Bool) -> None:
        self._is_ready = message.data
        super()._on_ready(message)
        if self._must_send and self._is_ready and self._armed:
            self._must_send = self._swaps_now = self._monitor.course.lands_between = False
            self.send_goal()
