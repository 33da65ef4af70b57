#!/usr/bin/env python3
"""Fly ArduPilot through MAVROS by a script, and print what each step did, one JSON line each.

usage: copter_session.py      (needs `sitl.launch autopilot:=ardupilot`; ROS_MASTER_URI leads to it)

Times are seconds of simulation time, places metres from where the UAV stood, speeds m/s over the ground.
"""

from __future__ import annotations

import json
import math
import sys
import threading
from typing import Any, Callable

import rospy
from geometry_msgs.msg import PoseStamped, TwistStamped
from mavros_msgs.msg import ParamValue, State
from mavros_msgs.srv import CommandBool, CommandTOL, ParamSet, SetMode
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState

HEIGHT_M, SPEED_M_S = 3.0, 2.0
START_S, STEP_S, HOME_S = 120.0, 40.0, 120.0
SEND_S = 0.05
STANDBY = 3  # MAV_STATE_STANDBY


class Session:
    """A UAV and what commands it."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self.now_s = 0.0
        self.place_m = self._began_m = (0.0, 0.0, 0.0)
        self.speed_m_s = 0.0
        self.state = State()
        self.voltage_v = math.nan
        self._subscribers = [
            rospy.Subscriber("/UAV/ground_truth", Odometry, self._on_truth, queue_size=10),
            rospy.Subscriber("/mavros/state", State, self._on_state, queue_size=10),
            rospy.Subscriber("/mavros/battery", BatteryState, self._on_battery, queue_size=10),
        ]
        self._positions = rospy.Publisher("/mavros/setpoint_position/local", PoseStamped, queue_size=1)
        self._velocities = rospy.Publisher("/mavros/setpoint_velocity/cmd_vel", TwistStamped, queue_size=1)

    def _on_truth(self, message: Odometry) -> None:
        p, v = message.pose.pose.position, message.twist.twist.linear
        with self._changed:
            self.now_s = message.header.stamp.to_sec()
            self.place_m = p.x - self._began_m[0], p.y - self._began_m[1], p.z - self._began_m[2]
            self.speed_m_s = math.hypot(v.x, v.y)
            self._changed.notify()

    def _on_state(self, message: State) -> None:
        self.state = message

    def _on_battery(self, message: BatteryState) -> None:
        self.voltage_v = message.voltage

    def call(self, name: str, kind: Any, **request: Any) -> Any:
        """Call a service of MAVROS."""
        rospy.wait_for_service(f"/mavros/{name}", 60.0)
        return rospy.ServiceProxy(f"/mavros/{name}", kind)(**request)

    def until(
        self, condition: Callable[[], bool], seconds: float, send: Callable[[], None] | None = None
    ) -> float:
        """Wait, and send something meanwhile. Returns how long it took; infinity when it did not come."""
        began_s = sent_s = self.now_s
        while not condition():
            with self._changed:
                if not self._changed.wait(60.0):
                    raise RuntimeError("The simulator has told nothing for a minute.")
            if send is not None and self.now_s - sent_s >= SEND_S:
                sent_s = self.now_s
                send()
            if self.now_s - began_s > seconds:
                return math.inf
        return self.now_s - began_s

    def wait(self, seconds: float, send: Callable[[], None] | None = None) -> None:
        """Let time pass."""
        self.until(lambda: False, seconds, send)

    def be(self, mode: str) -> bool:
        """Ask for a mode, and wait until it is there."""
        self.call("set_mode", SetMode, custom_mode=mode)
        return self.until(lambda: self.state.mode == mode, STEP_S) < STEP_S

    def set(self, name: str, value: float) -> bool:
        """Set a parameter of the flight controller."""
        whole = isinstance(value, int)
        given = ParamValue(integer=value if whole else 0, real=0.0 if whole else value)
        return self.call("param/set", ParamSet, param_id=name, value=given).success

    def take_off(self) -> dict[str, Any]:
        """Arm in GUIDED and rise."""
        ready_s = self.until(lambda: self.state.connected and self.state.system_status >= STANDBY, START_S)
        guided = self.be("GUIDED")
        asked = 0
        while not self.state.armed and asked < START_S:
            self.call("cmd/arming", CommandBool, value=True)
            self.until(lambda: self.state.armed, 2.0)
            asked += 2
        taken = self.call("cmd/takeoff", CommandTOL, altitude=HEIGHT_M).success
        risen_s = self.until(lambda: self.place_m[2] > 0.95 * HEIGHT_M, STEP_S)
        self.wait(5.0)
        return {
            "ready_s": ready_s,
            "guided": guided,
            "taken": taken,
            "risen_s": risen_s,
            "height_m": self.place_m[2],
        }

    def fly_to(self, x: float, y: float) -> dict[str, Any]:
        """Send a position until the UAV stands there."""
        target = PoseStamped()
        target.header.frame_id = "map"
        target.pose.position.x, target.pose.position.y, target.pose.position.z = x, y, HEIGHT_M
        target.pose.orientation.w = 1.0
        there = (x, y, HEIGHT_M)
        came_s = self.until(
            lambda: math.dist(self.place_m, there) < 0.3 and self.speed_m_s < 0.1,
            STEP_S,
            lambda: self._positions.publish(target),
        )
        return {"came_s": came_s, "off_m": math.dist(self.place_m, there)}

    def send_velocity(self, x_m_s: float, y_m_s: float) -> None:
        """Send a velocity once, in east and north."""
        target = TwistStamped()
        target.header.stamp = rospy.Time.now()
        target.twist.linear.x, target.twist.linear.y = x_m_s, y_m_s
        self._velocities.publish(target)

    def lose_setpoints(self) -> dict[str, Any]:
        """Fly by velocities; then send none."""
        self.wait(4.0, lambda: self.send_velocity(-SPEED_M_S, 0.0))
        speed, where = self.speed_m_s, self.place_m
        stopped_s = self.until(lambda: self.speed_m_s < 0.1, STEP_S)
        return {
            "speed_m_s": speed,
            "stopped_s": stopped_s,
            "way_m": math.dist(where, self.place_m),
            "mode": self.state.mode,
        }

    def come_home(self) -> dict[str, Any]:
        """Wait until the flight controller has landed at home."""
        highest, from_m = self.place_m[2], math.hypot(*self.place_m[:2])

        def has_landed() -> bool:
            nonlocal highest
            highest = max(highest, self.place_m[2])
            return not self.state.armed

        landed_s = self.until(has_landed, HOME_S)
        return {
            "landed_s": landed_s,
            "from_m": from_m,
            "highest_m": highest,
            "off_m": math.hypot(*self.place_m[:2]),
        }

    def breach(self, radius_m: float) -> dict[str, Any]:
        """Fly against a fence round home."""
        set_all = all(
            [self.set("FENCE_TYPE", 2), self.set("FENCE_RADIUS", radius_m), self.set("FENCE_ENABLE", 1)]
        )
        self.until(lambda: self.state.mode != "GUIDED", STEP_S, lambda: self.send_velocity(0.0, SPEED_M_S))
        mode, breached_m = self.state.mode, math.hypot(*self.place_m[:2])
        farthest_m = breached_m

        def turns() -> bool:
            nonlocal farthest_m
            farthest_m = max(farthest_m, math.hypot(*self.place_m[:2]))
            return farthest_m > math.hypot(*self.place_m[:2]) + 1.0

        self.until(turns, STEP_S)
        return {"set": set_all, "mode": mode, "breached_m": breached_m, "farthest_m": farthest_m}

    def sink_battery(self, volts: float) -> dict[str, Any]:
        """Let the battery's voltage fall."""
        was_set = self.set("BATT_LOW_VOLT", volts + 0.5) and self.set("SIM_BATT_VOLTAGE", volts)
        heard_s = self.until(lambda: self.voltage_v < volts + 0.3, STEP_S)
        failsafe_s = self.until(lambda: self.state.mode != "GUIDED", STEP_S)
        return {"set": was_set, "heard_s": heard_s, "failsafe_s": failsafe_s, "mode": self.state.mode}


def main() -> int:
    """Fly all steps."""
    rospy.init_node("copter_session")
    session = Session()

    def tell(step: str, **seen: Any) -> None:
        print(json.dumps({"step": step, **seen}), flush=True)

    session.until(lambda: session.now_s > 0.0, START_S)
    session._began_m = session.place_m
    tell("take_off", **session.take_off())
    tell("position", **session.fly_to(6.0, 2.0))
    tell("loss", **session.lose_setpoints())
    tell("rtl", is_in=session.be("RTL"), **session.come_home())
    tell("again", **session.take_off())
    tell("fence", **session.breach(15.0))
    tell("fence_home", **session.come_home())
    session.set("FENCE_ENABLE", 0)
    tell("third", **session.take_off())
    tell("battery", **session.sink_battery(10.5))
    tell("land", is_in=session.be("LAND"), **session.come_home())
    return 0


if __name__ == "__main__":
    sys.exit(main())
