"""The shared part of MAVROS's plugins: link, ROS names, clock, and the newest messages."""

from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass, field
from typing import Any, Callable

import rospy
from genpy import Time
from pymavlink.dialects.v20 import common
from std_msgs.msg import Header

from simulation_tools.geometry import Quaternion, Vector3
from simulation_tools.mavros.client import FcuClient
from simulation_tools.ned_frames import attitude_to_enu, flu_to_frd

REFUSALS_EVERY_S = 1.0  # of one topic, wall time


class Topic:
    """A publisher that builds a message only if it has subscribers or is latched."""

    def __init__(self, publisher: rospy.Publisher, latch: bool) -> None:
        self._publisher = publisher
        self._latch = latch

    @property
    def wanted(self) -> bool:
        """Whether a message would be published."""
        return self._latch or self._publisher.get_num_connections() > 0

    def publish(self, make: Callable[[], Any]) -> None:
        """Publish what `make` returns, if the topic has a subscriber or is latched."""
        if self.wanted:
            self._publisher.publish(make())


@dataclass
class Heard:
    """The flight controller's newest messages for several plugins; None: not received yet."""

    time_boot_ms: int = 0
    heartbeat: Any = None
    attitude: Quaternion | None = None  # of FLU in ENU, x y z w
    rates: Vector3 = (0.0, 0.0, 0.0)  # FLU, rad/s
    local_position: Any = None  # LOCAL_POSITION_NED
    global_position: Any = None  # GLOBAL_POSITION_INT

    @property
    def attitude_or_level(self) -> Quaternion:
        """The attitude. Before it is known: level and facing east."""
        return self.attitude or (0.0, 0.0, 0.0, 1.0)


@dataclass
class Timer:
    """A job that is done at a period of wall time."""

    period_s: float
    callback: Callable[[float], None]
    due_s: float = field(default=-math.inf)


def number(name: str, default: float) -> float:
    """Return a parameter of the node.

    If it is not a number, warn and return the default, as MAVROS does. MAVROS's own px4_config.yaml contains
    such a value: angular_velocity_stdev is "0.0003490659 // 0.02 degrees".
    """
    value = rospy.get_param(name, default)
    if isinstance(value, (int, float)):
        return float(value)
    rospy.logwarn(f"The parameter {name} of mavros is {value!r}, which is not a number; {default:g} is used.")
    return default


class Uas:
    """The flight controller as the plugins see it.

    Handlers and timers run in the thread that polls the client. Subscribers and services run in threads of
    their own. Stamps are in the flight controller's time, which is ROS's in simulation.
    """

    def __init__(self, client: FcuClient) -> None:
        """Read ~geoid_height: height of the geoid over the ellipsoid at the place of flight, m."""
        self.client = client
        self.geoid_height_m = number("~geoid_height", 0.0)
        self.heard = Heard()
        self.plan_lock = threading.Lock()
        """The flight controller transfers one list at a time: its mission or its fence."""
        self._timers: list[Timer] = []
        self._connection_jobs: list[Callable[[], object]] = []
        self._refused_s: dict[str, float] = {}
        client.on("ATTITUDE_QUATERNION", self._on_attitude)
        client.on("LOCAL_POSITION_NED", self._on_local_position)
        client.on("GLOBAL_POSITION_INT", self._on_global_position)

    # ROS

    @staticmethod
    def advertise(name: str, message_class: type, latch: bool = False) -> Topic:
        """Return a topic below ~."""
        publisher = rospy.Publisher("~" + name, message_class, queue_size=10, latch=latch, tcp_nodelay=True)
        return Topic(publisher, latch)

    @staticmethod
    def subscribe(name: str, message_class: type, callback: Callable, queue_size: int = 1) -> None:
        """Listen to a topic below ~."""
        rospy.Subscriber("~" + name, message_class, callback, queue_size=queue_size, tcp_nodelay=True)

    @staticmethod
    def serve(name: str, service_class: type, handler: Callable) -> None:
        """Offer a service below ~."""
        rospy.Service("~" + name, service_class, handler)

    # The clock

    @property
    def now(self) -> Time:
        """The flight controller's time; ROS's before it is known."""
        ms = self.heard.time_boot_ms
        return stamp_from_us(1000 * ms) if ms else rospy.get_rostime()

    def note_time(self, time_boot_ms: int) -> None:
        """Note the flight controller's time. If it jumps back, forget all earlier messages."""
        if time_boot_ms < self.heard.time_boot_ms - 1000:
            rospy.logwarn("The flight controller's clock jumped back: mavros forgets what it heard before.")
            self.heard = Heard(heartbeat=self.heard.heartbeat)
        self.heard.time_boot_ms = max(time_boot_ms, self.heard.time_boot_ms)

    # Timers and jobs

    def every(self, period_s: float, callback: Callable[[float], None]) -> None:
        """Call `callback` (with the wall time, s) at once and then periodically."""
        self._timers.append(Timer(period_s, callback))

    def run_timers(self) -> float:
        """Call all timers that are due. Return the wall time until the next one, s."""
        now_s = time.monotonic()
        for timer in self._timers:
            if now_s >= timer.due_s:
                timer.due_s = now_s + timer.period_s
                timer.callback(now_s)
        return min((timer.due_s for timer in self._timers), default=math.inf) - now_s

    def on_connection(self, job: Callable[[], object]) -> None:
        """Do a job, which may block, whenever the flight controller connects."""
        self._connection_jobs.append(job)

    def connected(self) -> None:
        """Start the jobs for a new connection."""
        threading.Thread(target=self._run_connection_jobs, name="connection", daemon=True).start()

    def _run_connection_jobs(self) -> None:
        for job in self._connection_jobs:
            if not rospy.is_shutdown():
                job()

    # Messages to the flight controller

    def send_setpoint(self, topic: str, header: Header | None, build: Callable) -> None:
        """Build a setpoint's MAVLink message and send it; see `send_built`.

        build: returns the message for a time_boot_ms: the stamp, or the present time if the stamp is zero.
        """
        stamp = header.stamp if header is not None and not header.stamp.is_zero() else rospy.get_rostime()
        self.send_built(f"A setpoint on {topic}", lambda: build(stamp.to_nsec() // 1_000_000))

    def send_built(self, what: str, build: Callable[[], common.MAVLink_message]) -> None:
        """Send a message, or refuse it with a sentence about `what`.

        build: returns the message. If it cannot, it raises ValueError with the reason.
        """
        try:
            message = build()
        except ValueError as error:
            if time.monotonic() - self._refused_s.get(what, -math.inf) > REFUSALS_EVERY_S:
                self._refused_s[what] = time.monotonic()
                rospy.logwarn(f"{what} is refused: {error}.")
            return
        if not self.client.send(message):
            rospy.logwarn_throttle(1.0, f"{what} could not be sent to the flight controller.")

    # Messages from the flight controller

    def _on_attitude(self, message: common.MAVLink_message) -> None:
        self.note_time(message.time_boot_ms)
        self.heard.attitude = attitude_to_enu((message.q1, message.q2, message.q3, message.q4))
        self.heard.rates = flu_to_frd((message.rollspeed, message.pitchspeed, message.yawspeed))

    def _on_local_position(self, message: common.MAVLink_message) -> None:
        self.note_time(message.time_boot_ms)
        self.heard.local_position = message

    def _on_global_position(self, message: common.MAVLink_message) -> None:
        self.note_time(message.time_boot_ms)
        self.heard.global_position = message


def stamp_from_us(time_us: int) -> Time:
    """Return the ROS time of a flight controller whose clock is ROS's."""
    seconds, microseconds = divmod(int(time_us), 1_000_000)
    return Time(seconds, 1000 * microseconds)


def stamp_from_ms(time_boot_ms: int) -> Time:
    """Return the ROS time of a flight controller whose clock is ROS's."""
    return stamp_from_us(1000 * int(time_boot_ms))


def diagonal(*variances: float) -> list[float]:
    """Return a diagonal covariance matrix, row by row."""
    size = len(variances)
    return [variances[i // size] if i % (size + 1) == 0 else 0.0 for i in range(size * size)]


UNKNOWN = diagonal(-1.0, 0.0, 0.0)
"""MAVROS's matrix for an unknown covariance."""
