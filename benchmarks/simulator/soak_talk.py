"""The soak's own ROS node: it watches the flight, and sends goals and messages without sense."""

from __future__ import annotations

import math
import threading
import time
from typing import Any, Callable
from xmlrpc.client import ServerProxy

import numpy as np
import rosgraph
import rospy
from gazebo_msgs.msg import ContactsState, ModelState
from gazebo_msgs.srv import SetModelState, SpawnModel
from geometry_msgs.msg import Pose, TwistStamped
from mavros_msgs.srv import SetMode
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool

from flights.errors import GraphError

NAME = "/soak"


class Talk:
    """A ROS node that publishes and subscribes; ROS_MASTER_URI leads to the graph.

    nonsense: functions that send something without sense, by name.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._changed = threading.Condition()
        self._pose: tuple[float, tuple[float, float, float]] = (-math.inf, (0.0, 0.0, 0.0))
        self._command_s = -math.inf
        self._ready = False
        self.contacts = 0
        self.touched: dict[str, float] = {}  # touched shapes, with the time of the first contact
        rospy.init_node(NAME[1:], disable_signals=True)
        for topic, kind, callback in (
            ("/UAV/ground_truth", Odometry, self._on_truth),
            ("/UAV/vel_setpoint/final/body", TwistStamped, self._on_command),
            ("/UAV/ready", Bool, self._on_ready),
            ("/UAV/collision", ContactsState, self._on_contacts),
        ):
            rospy.Subscriber(topic, kind, callback, queue_size=50, tcp_nodelay=True)
        self._goal = rospy.Publisher("/UAV/pos_setpoint", Pose, queue_size=1, latch=True)
        self._references = rospy.Publisher("/UAV/vel_setpoint/raw/body", TwistStamped, queue_size=1)
        self._commands = rospy.Publisher("/UAV/vel_setpoint/final/body", TwistStamped, queue_size=1)
        self._scans = rospy.Publisher("/scan", LaserScan, queue_size=1)
        self.nonsense: dict[str, Callable[[], None]] = {
            "goal that is none": lambda: self.go((math.nan, math.inf, 2.0)),
            "reference that is none": lambda: self._references.publish(_velocity(math.nan)),
            "command in no frame": lambda: self._commands.publish(_velocity(1.0, "nowhere")),
            "command from the future": lambda: self._commands.publish(_velocity(1.0, ahead_s=100.0)),
            "scan that is none": lambda: self._scans.publish(_scan(rng.uniform(0.0, 9.0, 3).tolist())),
            "pose that is none": self._put_nowhere,
            "model that is none": self._spawn_rubbish,
            "mode that is none": self._ask_for_no_mode,
        }

    @property
    def now_s(self) -> float:
        """Simulated time of the newest pose."""
        return self._pose[0]

    def wait_for_pose(self, patience_s: float) -> tuple[float, tuple[float, float, float]]:
        """Wait for a new pose. Return its time and place; GraphError if none comes."""
        with self._changed:
            before = self._pose
            if not self._changed.wait_for(lambda: self._pose is not before, patience_s):
                raise GraphError(f"No pose has come for {patience_s:g} s.")
            return self._pose

    def is_led(self, since_s: float) -> bool:
        """Whether commands have come since this time and the UAV is ready for them."""
        return self._ready and self._command_s > since_s

    def go(self, goal_m: tuple[float, float, float]) -> None:
        """Send the UAV to a place."""
        goal = Pose()
        goal.position.x, goal.position.y, goal.position.z = goal_m
        goal.orientation.w = 1.0
        self._goal.publish(goal)

    @staticmethod
    def pid_of(node: str) -> int | None:
        """Return the process id of a node; None if there is none."""
        try:
            answer: Any = ServerProxy(rosgraph.Master(NAME).lookupNode(node)).getPid(NAME)
            return answer[2]
        except (OSError, rosgraph.MasterException):
            return None

    def _on_truth(self, message: Odometry) -> None:
        p = message.pose.pose.position
        with self._changed:
            self._pose = message.header.stamp.to_sec(), (p.x, p.y, p.z)
            self._changed.notify_all()

    def _on_command(self, message: TwistStamped) -> None:
        if message._connection_header["callerid"] != NAME:
            self._command_s = message.header.stamp.to_sec()

    def _on_ready(self, message: Bool) -> None:
        self._ready = message.data

    def _on_contacts(self, message: ContactsState) -> None:
        for state in message.states:
            if not state.collision2_name.startswith("ground_plane::"):
                self.contacts += 1
                self.touched.setdefault(state.collision2_name, message.header.stamp.to_sec())

    def _put_nowhere(self) -> None:
        state = ModelState(model_name="iris")
        state.pose.position.x = math.nan
        _call("/gazebo/set_model_state", SetModelState, state)

    def _spawn_rubbish(self) -> None:
        _call("/gazebo/spawn_sdf_model", SpawnModel, "rubbish", "<sdf><model/>", "", Pose(), "")

    def _ask_for_no_mode(self) -> None:
        _call("/mavros/set_mode", SetMode, 0, "FLY")


def _velocity(forward_m_s: float, frame: str = "base_frame", ahead_s: float = 0.0) -> TwistStamped:
    message = TwistStamped()
    message.header.stamp = rospy.get_rostime() + rospy.Duration(ahead_s)
    message.header.frame_id = frame
    message.twist.linear.x = forward_m_s
    return message


def _scan(ranges: list[float]) -> LaserScan:
    """A scan whose angles ask for more ranges than it has."""
    message = LaserScan(angle_min=-2.0, angle_max=2.0, angle_increment=0.004, ranges=ranges)
    message.header.stamp, message.header.frame_id = rospy.get_rostime(), "hokuyo"
    message.range_min, message.range_max = 0.1, 30.0
    return message


def _call(name: str, kind: Any, *arguments: object) -> None:
    """Call a service that should refuse."""
    try:
        rospy.wait_for_service(name, timeout=5.0)
        rospy.ServiceProxy(name, kind)(*arguments)
    except (rospy.ServiceException, rospy.ROSException):
        time.sleep(0.1)
