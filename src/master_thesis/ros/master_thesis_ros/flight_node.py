"""The part of an experiment's driver that follows a flight: it hears, records, decides, and lands the UAV."""

from __future__ import annotations

import contextlib
import math
import queue
import threading
import time
from abc import ABC, abstractmethod

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from gazebo_msgs.msg import ContactsState
from geometry_msgs.msg import Point, PoseStamped, TwistStamped
from mavros_msgs.msg import State
from mavros_msgs.srv import SetMode
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as PathMessage
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, Header, String

from master_thesis.flight.course import Action, Phase
from master_thesis.flight.monitor import Monitor
from master_thesis_ros.messages import decision_rows, pose_values, stamp_s, twist_row

PATH_SPACING_M = 0.1
PATH_PERIOD_S = 0.5
LAND_ATTEMPTS = 5
INTERRUPTED = "The run was interrupted before its end."
SETTLE_S = 0.1  # of wall time; in lockstep, by then everybody has heard what is to be done
ANSWER_PATIENCE_S = 0.5  # of wall time for the stamped messages of an instant
UNSTAMPED_S = 0.02  # of wall time; so much later what bears no stamp (ready, goal_reached) has come, too


class FlightNode(ABC):
    """Drives one run by messages and their stamps; it stands beside the control chain, never in it.

    Subscribes: ready (std_msgs/Bool), waiting_for (std_msgs/String); ground_truth, odometry
    (nav_msgs/Odometry); vel_raw, vel_safe, vel_final (geometry_msgs/TwistStamped); scan
    (sensor_msgs/LaserScan); cepa_stats, performance (diagnostic_msgs/DiagnosticArray); collision
    (gazebo_msgs/ContactsState);
    mavros/state (mavros_msgs/State); /rosout (rosgraph_msgs/Log), for nodes that cannot start.
    Publishes: ~path (nav_msgs/Path, latched; for RViz); in lockstep ~processed (std_msgs/Header), the
    acknowledgement of a scan.
    Calls: mavros/set_mode (AUTO.LAND).
    A subclass says where to fly (`send_goal`), and hears when the UAV is there.

    In lockstep it decides once every whole second of simulated time, while the simulator waits for its
    acknowledgement and all others have said what they had to say: nothing depends on how fast messages are.
    """

    def __init__(self, monitor: Monitor, lockstep: bool, cepa: bool = True):
        """Hear everybody. cepa: it steers, and tells why; else a node of the user's own does."""
        self._monitor = monitor
        self._lock = threading.Lock()
        self._heard = threading.Condition(self._lock)
        self._actions: queue.Queue = queue.Queue()
        self._finished = False
        self._lockstep = lockstep
        self._decided_in_s = -1
        self._armed: bool | None = None  # None: not connected
        self._path = PathMessage()
        self._processed = rospy.Publisher("~processed", Header, queue_size=1, tcp_nodelay=True)
        self._path_publisher = rospy.Publisher("~path", PathMessage, queue_size=1, latch=True)
        self._set_mode = rospy.ServiceProxy("mavros/set_mode", SetMode)
        log = monitor.log
        self._subscribers: list[rospy.Subscriber] = []
        for name, message_class, handler in (
            ("ready", Bool, self._on_ready),
            ("ground_truth", Odometry, self._on_ground_truth),
            ("odometry", Odometry, self._on_odometry),
            ("vel_raw", TwistStamped, lambda message: log.v_ref.add(*twist_row(message))),
            ("vel_safe", TwistStamped, lambda message: log.v_safe.add(*twist_row(message))),
            ("vel_final", TwistStamped, lambda message: log.v_final.add(*twist_row(message))),
            ("performance", DiagnosticArray, self._on_performance),
            ("collision", ContactsState, self._on_contacts),
            ("mavros/state", State, self._on_state),
            ("/rosout", Log, self._on_log),
        ):
            self.subscribe(name, message_class, handler)
        if cepa:
            self.subscribe("cepa_stats", DiagnosticArray, self._on_stats)
        # Not among the others: lockstep begins without it, too.
        on_waiting = self._locked(lambda message: monitor.course.on_waiting(message.data))
        self._reasons = rospy.Subscriber("waiting_for", String, on_waiting)
        self._on_scan_locked = self._locked(self._on_scan)
        self._scans = rospy.Subscriber("scan", LaserScan, self._take_scan, queue_size=100, tcp_nodelay=True)

    @abstractmethod
    def send_goal(self) -> None:
        """Send the UAV, which hovers over the start, on its way."""

    def subscribe(self, name: str, message_class, handler) -> None:
        """Hear a topic until the run is over; the handler is called under the lock."""
        callback = self._locked(handler)
        options = {"queue_size": 100, "tcp_nodelay": True}
        self._subscribers.append(rospy.Subscriber(name, message_class, callback, **options))

    def run(self) -> None:
        """Carry out what the run asks for until it is over or ROS shuts down; SIGINT raises in here."""
        while not rospy.is_shutdown():
            try:
                action = self._actions.get(timeout=0.1)
            except queue.Empty:
                continue
            if action is Action.FINISH:
                break
            self._carry_out(action)

    def close(self) -> None:
        """End the run if it is not over, and hear no more."""
        with self._lock:  # and no callback publishes any more
            self._finished = True
            self._monitor.abort(INTERRUPTED)
        for subscriber in self._subscribers:
            subscriber.unregister()

    def _carry_out(self, action: Action) -> None:
        if action is Action.SEND_GOAL:
            self.send_goal()
        elif action is Action.LAND:
            # Of its own, since a call to a MAVROS that hangs would never return
            threading.Thread(target=self._land, daemon=True).start()

    def _land(self) -> None:
        for _ in range(LAND_ATTEMPTS):
            if rospy.is_shutdown():
                return
            try:
                if self._set_mode(0, "AUTO.LAND").mode_sent:
                    rospy.loginfo("The UAV is told to land.")
                    return
            except rospy.ServiceException as error:
                rospy.logwarn(f"MAVROS does not take the order to land: {error}")
            time.sleep(0.2)  # of wall time; the flight goes on meanwhile
        rospy.logerr(f"MAVROS refused to land {LAND_ATTEMPTS} times; the run ends at its time limit.")

    def _locked(self, handler):
        def callback(message):
            with self._lock:
                if self._finished:
                    return
                try:
                    handler(message)
                except (KeyError, ValueError) as error:  # figures that are missing or no numbers
                    rospy.logwarn_throttle(5.0, f"A {type(message).__name__} is ignored: {error}.")
                self._heard.notify_all()

        return callback

    def _enqueue(self, actions) -> None:
        for action in actions:
            self._actions.put(action)

    def _take_scan(self, message: LaserScan) -> None:
        """Keep the scan; in lockstep decide what is to be done, and acknowledge."""
        self._on_scan_locked(message)
        if not self._lockstep:
            return
        if self._decided_in_s < 0 and not self._hears_everybody():
            return  # the first scan comes again, and with it what was made of it
        if message.header.stamp.secs > self._decided_in_s and not self._finished:
            self._decided_in_s = message.header.stamp.secs
            self._settle(stamp_s(message))
            if self._decide():
                time.sleep(SETTLE_S)
        with contextlib.suppress(rospy.ROSException):  # the node may end just now
            self._processed.publish(message.header)

    def _hears_everybody(self) -> bool:
        """Whether every topic is connected; the series that must be complete prove it by their first row."""
        connected = all(subscriber.get_num_connections() for subscriber in self._subscribers)
        return connected and self._has_heard(-math.inf)

    def _has_heard(self, t_s: float) -> bool:
        """Whether every series that must be complete has come to this instant, which the simulator holds."""
        log = self._monitor.log
        series = (log.truth, log.odometry, log.v_safe, log.v_final)
        return all(one.rows and one.rows[-1][0] >= t_s for one in series)

    def _settle(self, t_s: float) -> None:
        """Wait until everything that was said of this instant has been heard."""
        with self._heard:
            self._heard.wait_for(lambda: self._finished or self._has_heard(t_s), ANSWER_PATIENCE_S)
        time.sleep(UNSTAMPED_S)

    def _decide(self) -> bool:
        with self._lock:
            actions = self._monitor.decide()
            if self._armed is not None:
                actions = actions + self._monitor.on_armed(self._armed)
            if Action.FINISH in actions:
                self._finished = True  # what comes later belongs to no flight
        self._enqueue(actions)
        return bool(actions)

    def _on_ready(self, message: Bool) -> None:
        self._monitor.course.on_ready(message.data)

    def _on_ground_truth(self, message: Odometry) -> None:
        pose = pose_values(message.pose.pose)
        decide = not self._lockstep
        self._enqueue(self._monitor.on_truth(stamp_s(message), pose[:3], pose[3:], decide))
        self._draw_path(message)

    def _on_odometry(self, message: Odometry) -> None:
        self._monitor.log.odometry.add(stamp_s(message), *pose_values(message.pose.pose))

    def _on_scan(self, message: LaserScan) -> None:
        log = self._monitor.log
        log.add_scan(stamp_s(message), message.ranges, message.angle_min, message.angle_increment)

    def _on_stats(self, message: DiagnosticArray) -> None:
        for row in decision_rows(message):
            self._monitor.log.decisions.add(*row)

    def _on_performance(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._monitor.on_performance({item.key: float(item.value) for item in status.values})

    def _on_contacts(self, message: ContactsState) -> None:
        for state in message.states:
            upwards = state.contact_normals[0].z if state.contact_normals else 0.0
            names = state.collision1_name, state.collision2_name
            self._monitor.on_contact(stamp_s(message), *names, upwards=upwards)

    def _on_state(self, message: State) -> None:
        self._armed = message.armed if message.connected else None
        if message.connected and not self._lockstep:
            self._enqueue(self._monitor.on_armed(message.armed))

    def _on_log(self, message: Log) -> None:
        """End a run before its flight when a node cannot start: roslaunch would start it again for ever."""
        if message.level == Log.FATAL and self._monitor.course.phase is Phase.WAITING:
            self._enqueue(self._monitor.abort(message.msg))

    def _draw_path(self, message: Odometry) -> None:
        here, poses = message.pose.pose.position, self._path.poses
        if not poses or _distance_squared(here, poses[-1].pose.position) >= PATH_SPACING_M**2:
            poses.append(PoseStamped(message.header, message.pose.pose))
        if (message.header.stamp - self._path.header.stamp).to_sec() >= PATH_PERIOD_S:
            self._path.header = message.header
            self._path_publisher.publish(self._path)


def _distance_squared(a: Point, b: Point) -> float:
    return (a.x - b.x) ** 2 + (a.y - b.y) ** 2 + (a.z - b.z) ** 2
