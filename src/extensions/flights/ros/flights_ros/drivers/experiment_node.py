"""The common part of the experiments' nodes: they watch a run, decide, and acknowledge scans in lockstep."""

from __future__ import annotations

import contextlib
import queue
import threading
from abc import ABC, abstractmethod
from enum import Enum
from typing import Any, Callable, Iterable, Protocol, Sequence

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from gazebo_msgs.msg import ContactsState
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, Header, String

from flights.flight.flight_log import FlightLog
from flights_ros.drivers.messages import decision_rows, stamp_s, twist_row

INTERRUPTED = "The run was interrupted before its end."
SETTLE_S = 0.1
"""Wall time after which, in lockstep, every node has received the order."""

Handler = Callable[[Any], Iterable[Enum] | None]
"""Takes a message and returns the actions to carry out."""


class WatchedRun(Protocol):
    """The state of a run. The last of its actions is called FINISH."""

    log: FlightLog

    @property
    def has_begun(self) -> bool:
        """Whether the wait for the hover is over."""

    def on_waiting(self, reason: str) -> None:
        """Note why the UAV does not hover yet, in words; empty: it hovers."""

    def on_contact(self, t_s: float, collision_1: str, collision_2: str, upwards: float = 0.0) -> None:
        """Note a contact between two collision shapes."""

    def abort(self, why: str) -> Sequence[Enum]:
        """End the run at once, unless it is over; `why` is a sentence."""


class ExperimentNode(ABC):
    """Controls a run by messages and their stamps. It is not part of the control chain.

    Subscribes: ready (std_msgs/Bool), waiting_for (std_msgs/String); ground_truth (nav_msgs/Odometry); scan
    (sensor_msgs/LaserScan); vel_safe (geometry_msgs/TwistStamped); cepa_stats
    (diagnostic_msgs/DiagnosticArray); collision (gazebo_msgs/ContactsState); /rosout (rosgraph_msgs/Log), for
    nodes that cannot start.
    Publishes: in lockstep ~processed (std_msgs/Header), the acknowledgement of a scan.

    In lockstep it decides at the first scan of each second of simulated time. The simulator waits for its
    acknowledgement, and all messages of this instant have arrived. So nothing depends on the speed of
    messages.
    """

    scan_class: Any = LaserScan
    scan_topic = "scan"

    def __init__(self, watched: WatchedRun, lockstep: bool, cepa: bool = True) -> None:
        """Subscribe to all topics.

        cepa: CEPA steers and publishes its decisions; else a user's node steers.
        """
        self._watched, self._lockstep = watched, lockstep
        self._lock = threading.Lock()
        self._heard = threading.Condition(self._lock)
        self._actions: queue.Queue[Enum] = queue.Queue()
        self._finished = False
        self._decided_in_s = -1
        self._processed = rospy.Publisher("~processed", Header, queue_size=1, tcp_nodelay=True)
        self._subscribers: list[rospy.Subscriber] = []
        self.subscribe("ready", Bool, self._on_ready)
        self.subscribe("ground_truth", Odometry, self._on_ground_truth)
        self.subscribe("vel_safe", TwistStamped, lambda message: watched.log.v_safe.add(*twist_row(message)))
        self.subscribe("collision", ContactsState, self._on_contacts)
        self.subscribe("/rosout", Log, self._on_log)
        if cepa:
            self.subscribe("cepa_stats", DiagnosticArray, self._on_stats)

    def subscribe(self, name: str, message_class: Any, handler: Handler) -> None:
        """Subscribe to a topic until the run is over. The handler is called under the lock."""
        callback = self._locked(handler)
        options = {"queue_size": 100, "tcp_nodelay": True}
        self._subscribers.append(rospy.Subscriber(name, message_class, callback, **options))

    def run(self) -> None:
        """Carry out the run's actions until it is over or ROS shuts down."""
        # Not among the others, because lockstep begins without it, too.
        on_waiting = self._locked(lambda message: self._watched.on_waiting(message.data))
        self._reasons = rospy.Subscriber("waiting_for", String, on_waiting)
        self._keep_scan = self._locked(self._on_scan)
        # Until the very end, because the simulator waits for the acknowledgement.
        self._scans = rospy.Subscriber(
            self.scan_topic, self.scan_class, self._take_scan, queue_size=100, tcp_nodelay=True
        )
        while not rospy.is_shutdown():
            try:
                action = self._actions.get(timeout=0.1)
            except queue.Empty:
                continue
            if action.name == "FINISH":
                break
            self._carry_out(action)

    def close(self) -> None:
        """End the run if it is not over, and unsubscribe."""
        with self._lock:
            self._finished = True
            self._actions.queue.clear()
            for action in self._watched.abort(INTERRUPTED):
                self._actions.put(action)
        for subscriber in self._subscribers:
            subscriber.unregister()

    @abstractmethod
    def _carry_out(self, action: Enum) -> None:
        """Carry out an action of the run."""

    @abstractmethod
    def _decide_at(self, header: Header) -> bool:
        """In lockstep, decide at the scan of this header; return whether to acknowledge it."""

    @abstractmethod
    def _on_ready(self, message: Bool) -> None:
        """Note whether the UAV hovers over the start and takes orders."""

    @abstractmethod
    def _on_ground_truth(self, message: Odometry) -> Iterable[Enum]:
        """Take the true pose. Return the actions; in lockstep the scan decides them."""

    @abstractmethod
    def _on_scan(self, message: LaserScan) -> Iterable[Enum] | None:
        """Keep a scan. Return the actions."""

    def _locked(self, handler: Handler) -> Callable[[Any], None]:
        def callback(message: Any) -> None:
            with self._lock:
                if self._finished:
                    return
                try:
                    self._take(handler(message) or ())
                except (KeyError, ValueError) as error:  # a value is missing or is not a number
                    rospy.logwarn_throttle(5.0, f"A {type(message).__name__} is ignored: {error}.")
                self._heard.notify_all()

        return callback

    def _take(self, actions: Iterable[Enum]) -> None:
        """Carry out the actions. After FINISH no message counts. Call it under the lock."""
        for action in actions:
            self._finished = self._finished or action.name == "FINISH"
            self._actions.put(action)

    def _take_scan(self, message: LaserScan) -> None:
        """Keep the scan. In lockstep decide on the actions and acknowledge the scan."""
        self._keep_scan(message)
        if not self._lockstep or (self._decided_in_s < 0 and not self._hears_everybody()):
            return  # the simulator repeats the first scan until it is acknowledged
        if message.header.stamp.secs > self._decided_in_s and not self._finished:
            self._decided_in_s = message.header.stamp.secs
            if not self._decide_at(message.header):
                return
        self._acknowledge(message.header)

    def _acknowledge(self, header: Header) -> None:
        with contextlib.suppress(rospy.ROSException):  # the node may end just now
            self._processed.publish(header)

    def _hears_everybody(self) -> bool:
        """Whether every topic is connected.

        For a topic that must be complete, the first message proves it.
        """
        of_each = [subscriber.impl for subscriber in self._subscribers]  # None after `close`
        return all(each is not None and each.get_num_connections() for each in of_each)

    def _on_stats(self, message: DiagnosticArray) -> None:
        for row in decision_rows(message):
            self._watched.log.decisions.add(*row)

    def _on_contacts(self, message: ContactsState) -> None:
        for state in message.states:
            upwards = state.contact_normals[0].z if state.contact_normals else 0.0
            names = state.collision1_name, state.collision2_name
            self._watched.on_contact(stamp_s(message), *names, upwards=upwards)

    def _on_log(self, message: Log) -> Iterable[Enum]:
        """End a run before its start if a node cannot start, because roslaunch would restart it for ever."""
        if message.level == Log.FATAL and not self._watched.has_begun:
            return self._watched.abort(message.msg)
        return ()
