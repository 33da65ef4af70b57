"""An errand as an action server, with its common topics and services."""

from __future__ import annotations

import logging
import time
import traceback
from functools import partial
from typing import Any, Callable, Protocol

import numpy as np
import rospy
from actionlib import ActionServer, ServerGoalHandle
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, LaserScan
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from flight_basics.errand import messages as came
from flight_basics.errand import outputs as out
from flight_basics.errand.errand import Errand
from flight_basics.errand.errand_thread import ErrandThread
from flight_basics.errand.inbox import Worker
from flight_basics.errand.leader import Here, Leader
from flight_basics.errors import PoseError, sentence_of
from flight_basics_ros.begun_goal import identity_of
from flight_basics_ros.pose_source import PoseSource
from node_tools.node import give_up
from node_tools.stamp_watch import StampWatch
from node_tools.throttled_warnings import ThrottledWarnings

More = Callable[[Odometry, np.ndarray, float], Any]
"""Returns what else a leader wants to know of an odometry at a place (x, y, z) with a yaw in rad."""


class Links(Protocol):
    """What a node publishes of its errand. Called in the errand's thread alone."""

    def result(self, words: str, has_result: bool) -> Any:
        """Return the action's result. has_result: of what was flown; else it only says `words`."""

    def send(self, setpoint: Any, here: Here | None) -> None:
        """Publish where to fly. setpoint: None: it is not new."""

    def feedback(self, here: Here, battery: Any) -> Any:
        """Publish what RViz shows; return the feedback. battery: the newest sensor_msgs/BatteryState."""

    def settled(self) -> None:
        """A decision is made."""


class ErrandServer:
    """Carries an errand between ROS and its thread. Its callbacks only put messages into the inbox.

    Serves: ~pause, ~resume, ~abort (std_srvs/Trigger). Publishes in lockstep ~processed (std_msgs/Header).

    Args:
        name, spec: of the action. errand, leader, links: see there. content: what the goals' files hold, for
            their identity. on_goal: called when a goal comes.

    Attributes:
        say, say_if_it_lasts: warn with a limited rate.
    """

    def __init__(
        self,
        name: str,
        spec: Any,
        errand: Errand,
        leader: Leader,
        links: Links,
        content: str = "",
        on_goal: Callable[[], None] = lambda: None,
    ) -> None:
        self._links, self._content, self._on_arrival = links, content, on_goal
        self._warnings = ThrottledWarnings()
        self.say, self.say_if_it_lasts = self._warnings.say, self._warnings.say_if_it_lasts
        clock_s = rospy.get_time
        self._thread = ErrandThread(errand, leader, self._carry_out, self.fail, self._on_fault, clock_s)
        self._intake = Worker("goals", self.fail)
        self.put, self.ask, self.worker = self._thread.put, self._thread.ask, self._thread.worker
        self._processed = rospy.Publisher("~processed", Header, queue_size=1, tcp_nodelay=True)
        self._carries: dict[type, Callable[[Any], None]] = {
            out.Accept: self._accept,
            out.Finish: self._finish,
            out.Send: lambda send: links.send(send.setpoint, send.here),
            out.Tell: self._tell,
            out.Acknowledge: lambda scan: self._processed.publish(scan.header),
            out.Say: self._say,
            out.Settled: lambda _: links.settled(),
        }
        self._subscribers: list[rospy.Subscriber] = []
        self._action = ActionServer(name, spec, self._on_goal, self._on_cancel, auto_start=False)

    def start(self, commands: bool = True) -> None:
        """Begin to answer. commands: serve ~pause, ~resume and ~abort."""
        self._thread.start()
        self._action.start()
        for name in ("pause", "resume", "abort") if commands else ():
            rospy.Service(f"~{name}", Trigger, partial(self._on_command, name))

    def listen(self, source: PoseSource, more: More, waits: str) -> None:
        """Take poses. waits: what a pose that makes no sense leads to, in a sentence."""

        def on_fault(stamp_s: float, sentence: str) -> None:
            self.say_if_it_lasts(sentence)
            self.put(came.Pose(stamp_s, None))

        self.subscribe(source.topic, Odometry, partial(self._on_pose, source, more, waits, on_fault), 1)

    def listen_closely(self, source: PoseSource, waits: str) -> None:
        """Take poses, of which none may be lost. In flight, tell at once if one makes no sense."""
        watch = StampWatch(self._warnings)

        def on_fault(stamp_s: float, sentence: str) -> None:
            self.put(came.Pose(stamp_s, None, fault=sentence))

        def on_pose(odometry: Odometry) -> None:
            if watch.is_ahead(odometry.header.stamp, "pose"):
                return
            watch.went_back(odometry.header.stamp)
            self._on_pose(source, lambda *_: None, waits, on_fault, odometry)

        self.subscribe(source.topic, Odometry, on_pose, 10)

    def listen_to_battery(self) -> None:
        """Take the charge of the battery."""
        self.subscribe("battery", BatteryState, self._on_battery, 10)

    def listen_to_slam(self) -> None:
        """Take SLAM's state, and which map it makes."""
        self.subscribe("slam_state", String, lambda state: self.put(came.SlamState(state.data)), 10)
        self.listen_to_map_id()

    def listen_to_map_id(self) -> None:
        """Take which map SLAM makes."""
        self.subscribe("map_id", String, lambda told: self.put(came.MapId(told.data)), 1)

    def listen_to_scans(self) -> None:
        """Take scans, to acknowledge them in lockstep."""
        self.subscribe("scan", LaserScan, self._on_scan, 1)

    def subscribe(self, topic: str, kind: Any, take: Callable[[Any], None], queue: int, **how: Any) -> None:
        """Subscribe, for as long as the node runs."""
        self._subscribers.append(
            rospy.Subscriber(topic, kind, take, queue_size=queue, tcp_nodelay=True, **how)
        )

    def acquire(self, blocking: bool = True, timeout: float = -1.0) -> bool:
        """Stop, so that nothing publishes while rospy closes topics; `node_tools.node.spinning` calls it."""
        return self._thread.close(max(timeout, 0.0))

    # what comes

    def _on_goal(self, handle: ServerGoalHandle) -> None:
        self._on_arrival()
        self._intake.do(partial(self._take_goal, handle, time.monotonic_ns()))

    def _take_goal(self, handle: ServerGoalHandle, came_ns: int) -> None:
        """Put a goal. The master, which knows its sender, may be far away: orders overtake the goal."""
        told = handle.get_goal_id()
        identity = identity_of(handle, *filter(None, (self._content,)))
        stamp_s = told.stamp.to_sec()
        self.put(came.Goal(told.id, handle.get_goal(), identity, stamp_s, handle, came_ns))

    def _on_cancel(self, handle: ServerGoalHandle) -> None:
        self.put(came.Cancel(handle.get_goal_id().id))

    def _on_command(self, name: str, _: TriggerRequest) -> TriggerResponse:
        return TriggerResponse(*self.ask(came.Command(name)))

    def _on_pose(
        self,
        source: PoseSource,
        more: More,
        waits: str,
        on_fault: Callable[[float, str], None],
        odometry: Odometry,
    ) -> None:
        stamp_s = odometry.header.stamp.to_sec()
        try:
            place_m, yaw_rad = source.pose(odometry)
        except PoseError as error:
            on_fault(stamp_s, f"{error} {waits}")
            return
        at_m = np.array(place_m)
        known = more(odometry, at_m, yaw_rad)
        self.put(came.Pose(stamp_s, at_m, source.off_m, source.off_rad, known))

    def _on_battery(self, battery: BatteryState) -> None:
        self.put(came.Battery(battery.header.stamp.to_sec(), battery.percentage, battery))

    def _on_scan(self, scan: LaserScan) -> None:
        self.put(came.Scan(scan.header.stamp.to_sec(), scan.header))

    # what goes, in the errand's thread

    def _carry_out(self, output: out.Output) -> None:
        self._carries[type(output)](output)

    def _accept(self, accept: out.Accept) -> None:
        accept.goal.handle.set_accepted("This goal has been accepted.")

    def _finish(self, finish: out.Finish) -> None:
        handle = finish.goal.handle
        end = {
            out.End.SUCCEEDED: handle.set_succeeded,
            out.End.ABORTED: handle.set_aborted,
            out.End.CANCELED: handle.set_canceled,
        }[finish.end]
        end(self._links.result(finish.words, finish.has_result), finish.words)

    def _tell(self, tell: out.Tell) -> None:
        feedback = self._links.feedback(tell.here, tell.battery)
        if tell.goal is not None:
            tell.goal.handle.publish_feedback(feedback)

    def _say(self, say: out.Say) -> None:
        if say.level == "rarely":
            self.say(say.words)
        elif say.level == "warn":
            rospy.logwarn("%s", say.words)
        elif say.words:
            rospy.loginfo("%s", say.words)

    @staticmethod
    def _on_fault(error: Exception) -> None:
        """Write into the node's log file what nobody expected; whom it concerns is told in a sentence."""
        rospy.logerr_throttle_identical(10.0, sentence_of(error))
        logging.getLogger("rospy.core").error("%s", "".join(traceback.format_exception(error)))

    @staticmethod
    def fail(error: Exception) -> None:
        """End the node with a sentence, because a thread has failed."""
        if not rospy.is_shutdown():
            rospy.logerr("%s", "".join(traceback.format_exception(error)))
            give_up(f"{rospy.get_name()} ends: it failed with {error}.")
