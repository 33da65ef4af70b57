"""The node of a flight with a goal or a mission: it records, decides, and lands the UAV."""

from __future__ import annotations

import math
import threading
import time
from abc import abstractmethod
from enum import Enum
from typing import Any, Iterable, Sequence

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TwistStamped
from mavros_msgs.msg import AttitudeTarget, ExtendedState, PositionTarget, State, StatusText
from mavros_msgs.srv import SetMode
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as PathMessage
from sensor_msgs.msg import BatteryState, LaserScan
from std_msgs.msg import Bool, Header

from flights.flight.course import Action
from flights.flight.monitor import Monitor
from flights_ros.drivers.experiment_node import SETTLE_S, ExperimentNode
from flights_ros.drivers.messages import pose_values, stamp_s, twist_row
from node_tools.conversions import xyz
from node_tools.services import ServiceCall
from simulation_tools.publisher.families import family_of

PATH_SPACING_M = 0.1
PATH_PERIOD_S = 0.5
LAND_ATTEMPTS = 5
ANSWER_PATIENCE_S = 0.5
"""Wall time for the stamped messages of an instant."""
ORDER_PATIENCE_S = 30.0
"""Wall time in lockstep for an order, and for the setpoint of an instant. MAVROS answers within milliseconds,
and later on a busy machine."""
UNSTAMPED_S = 0.02
"""Wall time after which messages without a stamp (ready, goal_reached) have also arrived: their nodes have
sent them before the instant's setpoint.
"""


class FlightNode(ExperimentNode):
    """Controls a flight.

    Subscribes, besides every `ExperimentNode`'s topics: odometry (nav_msgs/Odometry); vel_raw, vel_final
    (geometry_msgs/TwistStamped); performance (diagnostic_msgs/DiagnosticArray); mavros/state,
    mavros/extended_state and mavros/statustext/recv (of mavros_msgs), mavros/battery
    (sensor_msgs/BatteryState); in lockstep mavros/setpoint_raw/local, mavros/setpoint_raw/attitude (of
    mavros_msgs) and mavros/setpoint_position/local (geometry_msgs/PoseStamped). Publishes: ~path
    (nav_msgs/Path, latched; for RViz). Calls: mavros/set_mode (landing). A subclass sends the goal
    (`send_goal`) and notes its arrival.
    """

    def __init__(self, monitor: Monitor, lockstep: bool, cepa: bool = True) -> None:
        self._monitor = monitor
        self._armed: bool | None = None  # None: not connected
        self._path = PathMessage()
        self._path_publisher = rospy.Publisher("~path", PathMessage, queue_size=1, latch=True)
        self._landing = family_of(str(rospy.get_param("/gazebo/autopilot", "standin"))).landing
        self._set_mode = ServiceCall("mavros/set_mode", SetMode)
        self._carried_out = threading.Semaphore(0)
        self._setpoint_s = -math.inf
        super().__init__(monitor, lockstep, cepa)
        log = monitor.log
        self.subscribe("odometry", Odometry, self._on_odometry)
        self.subscribe("vel_raw", TwistStamped, lambda message: log.v_ref.add(*twist_row(message)))
        self.subscribe("vel_final", TwistStamped, lambda message: log.v_final.add(*twist_row(message)))
        if lockstep:
            self.subscribe("mavros/setpoint_raw/local", PositionTarget, self._on_setpoint)
            self.subscribe("mavros/setpoint_position/local", PoseStamped, self._on_setpoint)
            # Not among the others, because it is advertised when the first one is sent
            rospy.Subscriber("mavros/setpoint_raw/attitude", AttitudeTarget, self._locked(self._on_setpoint))
        self.subscribe("performance", DiagnosticArray, self._on_performance)
        self.subscribe("mavros/state", State, self._on_state)
        self.subscribe("mavros/extended_state", ExtendedState, self._on_extended_state)
        self.subscribe("mavros/battery", BatteryState, self._on_battery)
        self.subscribe("mavros/statustext/recv", StatusText, self._on_text)

    @abstractmethod
    def send_goal(self) -> None:
        """Send the goal to the UAV, which hovers over the start."""

    def _carry_out(self, action: Enum) -> None:
        if action is Action.SEND_GOAL:
            self.send_goal()
            self._carried_out.release()
        elif action is Action.LAND:
            # In a separate thread, because a MAVROS that hangs answers late
            threading.Thread(target=self._carry_out_landing, daemon=True).start()

    def _carry_out_landing(self) -> None:
        self._land()
        self._carried_out.release()

    def _land(self) -> None:
        for _ in range(LAND_ATTEMPTS):
            if rospy.is_shutdown():
                return
            try:
                if self._set_mode(0, self._landing).mode_sent:
                    rospy.loginfo("The UAV is told to land.")
                    return
            except rospy.ServiceException as error:
                rospy.logwarn(f"MAVROS did not take the order to land: {error}")
            time.sleep(0.2)  # wall time; the flight goes on meanwhile
        rospy.logerr(f"MAVROS refused to land {LAND_ATTEMPTS} times; the run ends at its time limit.")

    def _hears_everybody(self) -> bool:
        return super()._hears_everybody() and self._has_heard(-math.inf)

    def _has_heard(self, t_s: float) -> bool:
        """Return whether each series that must be complete has a row of this instant."""
        log = self._monitor.log
        series = (log.truth, log.odometry, log.v_safe, log.v_final)
        return all(one.rows and one.rows[-1][0] >= t_s for one in series)

    def _decide_at(self, header: Header) -> bool:
        t_s = header.stamp.to_sec()
        with self._heard:
            # The last answer to the scan: who sent anything for this instant has sent it
            self._heard.wait_for(lambda: self._finished or self._setpoint_s >= t_s, ORDER_PATIENCE_S)
            self._heard.wait_for(lambda: self._finished or self._has_heard(t_s), ANSWER_PATIENCE_S)
        if self._unstamped_matter():
            time.sleep(UNSTAMPED_S)
        with self._lock:
            actions = self._decisions()
            self._take(actions)
        for action in actions:
            if action in (Action.SEND_GOAL, Action.LAND):
                self._carried_out.acquire(timeout=ORDER_PATIENCE_S)
        if actions:
            time.sleep(SETTLE_S)
        return True

    def _unstamped_matter(self) -> bool:
        """Return whether a message without a stamp can change what is decided now."""
        return True

    def _decisions(self) -> Sequence[Enum]:
        actions = self._monitor.decide()
        return actions if self._armed is None else actions + self._monitor.on_armed(self._armed)

    def _on_ready(self, message: Bool) -> None:
        self._monitor.course.on_ready(message.data)

    def _on_ground_truth(self, message: Odometry) -> Iterable[Enum]:
        pose = pose_values(message.pose.pose)
        self._draw_path(message)
        return self._monitor.on_truth(stamp_s(message), pose[:3], pose[3:], decide=not self._lockstep)

    def _on_odometry(self, message: Odometry) -> None:
        self._monitor.log.odometry.add(stamp_s(message), *pose_values(message.pose.pose))

    def _on_scan(self, message: LaserScan) -> None:
        log = self._monitor.log
        log.add_scan(stamp_s(message), message.ranges, message.angle_min, message.angle_increment)

    def _on_setpoint(self, message: PositionTarget | AttitudeTarget | PoseStamped) -> None:
        self._setpoint_s = max(self._setpoint_s, stamp_s(message))

    def _on_performance(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._monitor.on_performance({item.key: float(item.value) for item in status.values})

    def _on_state(self, message: State) -> Iterable[Enum]:
        self._armed = message.armed if message.connected else None
        if message.connected and message.armed:  # the mode in which it landed stays of interest
            self._monitor.on_mode(message.mode)
        waits = self._lockstep or not message.connected
        return () if waits else self._monitor.on_armed(message.armed)

    def _on_extended_state(self, message: ExtendedState) -> None:
        if message.landed_state != ExtendedState.LANDED_STATE_UNDEFINED:
            self._monitor.on_landed(message.landed_state == ExtendedState.LANDED_STATE_ON_GROUND)

    def _on_battery(self, message: BatteryState) -> None:
        self._monitor.on_charge(message.percentage)

    def _on_text(self, message: StatusText) -> None:
        self._monitor.on_text(message.severity, message.text)

    def _draw_path(self, message: Odometry) -> None:
        poses = self._path.poses
        if not poses or _distance_m(message.pose.pose, poses[-1].pose) >= PATH_SPACING_M:
            poses.append(PoseStamped(message.header, message.pose.pose))
        if (message.header.stamp - self._path.header.stamp).to_sec() >= PATH_PERIOD_S:
            self._path.header = message.header
            self._path_publisher.publish(self._path)


def _distance_m(a: Any, b: Any) -> float:
    """Return the distance between two geometry_msgs/Pose."""
    return math.dist(xyz(a.position), xyz(b.position))
