"""The node of a flight that other nodes lead by actions: it swaps the battery between, and lands."""

from __future__ import annotations

import functools
import math
import threading
from enum import Enum
from typing import Any, Iterable, Sequence

import rospy
from actionlib_msgs.msg import GoalStatus
from mavros_msgs.msg import State
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool

from flight_basics.errors import FlightBasicsError
from flights.errors import FlightError, FlightsError
from flights.exploring.itinerary import Itinerary, Next
from flights.exploring.stopover import Stopover
from flights.flight.monitor import Monitor
from flights.flight.take_off import USUAL_HOVER_M
from flights_ros.drivers import batteries
from flights_ros.drivers.flight_node import FlightNode
from flights_ros.drivers.part import Flown, Part
from flights_ros.drivers.simulator_services import set_pace, slow_down
from flights_ros.drivers.taking_off import FIRST_TRIES, PUBLISHER, call_service, take_off, take_off_again
from gridslam import SlamError

WHY = {
    Next.AGAIN: "for a full battery",
    Next.WHEN_READY: "until it can go on",
    Next.NEXT_PART: "for the next part",
}


class LedFlightNode(FlightNode):
    """Lets other nodes fly one part after the other, with fresh batteries between.

    Subscribes, besides every `FlightNode`'s topics: the result of each part.
    Calls, besides what `FlightNode` does: what `batteries` does, mavros_publisher/restart (std_srvs/Trigger),
        mavros_publisher/set_parameters, and room_above of the node of each part.
    """

    def __init__(
        self,
        monitor: Monitor,
        itinerary: Itinerary,
        parts: Sequence[Part],
        lockstep: bool,
        hover_m: float | None = None,
    ) -> None:
        """hover_m: mavros_publisher waits until it is told to take off to this height; None: it does not."""
        self._itinerary, self._parts = itinerary, parts
        self._stopover, self._follows = Stopover(), Next.AGAIN
        self._began, self._charge = (math.nan, math.nan), math.nan
        self._autopilot = str(rospy.get_param("/gazebo/autopilot", "standin"))
        usual = rospy.get_param(PUBLISHER, {})
        self._hover_m = float(usual.get("hover_height", USUAL_HOVER_M)) if hover_m is None else hover_m
        self._ground_clearance_m = float(usual.get("ground_clearance", 0.12))
        if hover_m is not None:  # before the first scan is acknowledged, so that each run begins alike
            take_off(hover_m, functools.partial(call_service, tries=FIRST_TRIES))
            rospy.loginfo("The UAV takes off to %.2f m over the ground.", hover_m)
        super().__init__(monitor, lockstep)
        for part in parts:
            take = functools.partial(self._on_result, part)
            self.subscribe(f"{part.action}/result", part.result_class, take)
            for topic in part.listens:
                self.subscribe(*topic)

    def send_goal(self) -> None:
        """Begin the part, or go on with it."""
        self._began = self._monitor.now_s, self._charge
        self._parts[self._itinerary.part].send_goal()

    def _on_battery(self, message: BatteryState) -> None:
        super()._on_battery(message)
        self._charge = message.percentage

    def _on_result(self, part: Part, message: Any) -> Iterable[Enum]:
        """Take the result of an action: land between, or end the flight."""
        if part is not self._parts[self._itinerary.part]:
            return ()
        if message.status.status != GoalStatus.SUCCEEDED:
            return self._monitor.abort(f"The flight was refused: {message.status.text}")
        result, (began_s, began_charge) = message.result, self._began
        part.note(result, Flown(began_s, self._monitor.now_s, began_charge, self._charge))
        follows = self._itinerary.after(result.end, result.is_home)
        if follows is Next.LOST:
            self._monitor.land_here(f"The UAV did not come home: {result.reason}")
        elif follows is Next.OVER:
            self._monitor.on_goal_reached(True)
        else:
            self._stopover.begin()
            self._monitor.land_between()
            self._follows = follows
            rospy.loginfo("The UAV lands at home, %s.", WHY[follows])
            threading.Thread(target=self._land, daemon=True).start()
        return ()

    def _on_state(self, message: State) -> Iterable[Enum]:
        actions = super()._on_state(message)
        has_landed = self._stopover.on_armed(message.armed if message.connected else None)
        if has_landed and not actions:  # after a bad landing the run is over
            threading.Thread(target=self._go_on, daemon=True).start()
        return actions

    def _go_on(self) -> None:
        """On the ground: prepare the next part or wait, put in a full battery, and take off again."""
        if self._follows is not Next.AGAIN and not self._prepare():
            return
        try:
            if self._has_battery() and self._itinerary.take_battery():
                batteries.swap(self._autopilot, lambda: self._charge)
            self._take_off()
        except FlightError as error:
            self._abort(str(error))

    def _has_battery(self) -> bool:
        """Return whether the UAV flies by a battery. With an endless one there is none to swap."""
        return bool(rospy.get_param(f"{self._parts[self._itinerary.part].node}/use_battery", True))

    def _take_off(self) -> None:
        """Take off again; raises FlightError."""
        node = self._parts[self._itinerary.part].node
        height_m = take_off_again(node, self._hover_m, self._ground_clearance_m)
        rospy.loginfo("The UAV takes off again, to %.1f m.", height_m)
        self._stopover.take_off()

    def _abort(self, why: str) -> None:
        with self._lock:
            self._take(self._monitor.abort(why))

    def _prepare(self) -> bool:
        """Return whether the next part can be flown. Simulated time passes slowly meanwhile."""
        pace = float(rospy.get_param("/gazebo/real_time_factor", 1.0))  # before it changes
        slow_down()
        part = self._parts[self._itinerary.part]
        try:
            if self._follows is not Next.WHEN_READY:
                part.prepare()
            elif not part.wait():
                with self._lock:
                    self._take(self._monitor.stay_landed())
                return False
        except (FlightBasicsError, FlightsError, SlamError) as error:
            self._abort(str(error))
            return False
        finally:
            set_pace(pace)
        return True

    def _on_ready(self, message: Bool) -> None:
        super()._on_ready(message)
        if self._stopover.on_ready(message.data):
            self._monitor.fly_on()
            self.send_goal()
