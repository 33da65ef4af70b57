"""What the nodes of this package begin and end with."""

from __future__ import annotations

import math
import time
from contextlib import contextmanager
from typing import Callable, Iterator

import rospy

from simulation_tools.errors import SimulationToolsError
from simulation_tools.stop_signals import StopSignals, leave
from simulation_tools.values import ParameterError

LAST_ANSWER_S = 0.15
HEARD_AFTER_S = 0.3  # wall time until whoever listens to /rosout is connected to a new node
RETRY_S, REMINDER_S = 1.0, 10.0  # wall time


@contextmanager
def reading_parameters(node: str) -> Iterator[None]:
    """Turn what a conversion of a parameter raises into a sentence."""
    try:
        yield
    except (TypeError, ValueError) as error:
        raise ParameterError(f"A parameter of {node} is of the wrong type: {error}.") from None


def run(name: str, make: Callable[[], Callable[[StopSignals], None]], stop: StopSignals) -> None:
    """Make a node, run it until it is told to end, and end the process.

    make: returns what runs the node in the main thread; it returns when the signals say so or ROS shuts down.
    What is wrong at the start is one sentence and exit code 1; or, with the parameter ~keep_trying, a
    sentence now and then, until it is mended.
    """
    code = 0
    try:
        rospy.init_node(name, disable_signals=True)
        run_node = _make_at_last(make) if rospy.get_param("~keep_trying", False) else make()
        stop.watched()
        run_node(stop)
    except SimulationToolsError as error:
        rospy.rostime.wallsleep(HEARD_AFTER_S)
        rospy.logfatal(str(error))
        code = 1
    except rospy.ROSException:
        if not rospy.is_shutdown():
            raise
    leave(code, _close)


def _make_at_last(make: Callable) -> Callable[[StopSignals], None]:
    """Return what `make` does once nothing is wrong any more."""
    reminded_s = -math.inf
    while True:
        try:
            return make()
        except SimulationToolsError as error:
            rospy.rostime.wallsleep(RETRY_S)
            if rospy.is_shutdown():
                raise rospy.ROSInterruptException("told to end") from None
            if time.monotonic() - reminded_s > REMINDER_S:
                reminded_s = time.monotonic()
                rospy.logfatal(str(error))
                rospy.logwarn("It is tried again every second.")


def spin(stop: StopSignals, node, period_s: float = 0.25, watch: Callable[[], None] = lambda: None) -> None:
    """Let callbacks come, and call `watch` every so often (wall time), until told to end.

    node: its `_lock` is held while its callbacks publish; none may be under way when rospy closes the topics.
    """
    while not (rospy.is_shutdown() or stop.wait(period_s)):
        watch()
    node._lock.acquire(timeout=0.4)


def _close() -> None:
    told_by_ros = rospy.is_shutdown()
    rospy.signal_shutdown("the node has ended")
    if told_by_ros:
        rospy.rostime.wallsleep(LAST_ANSWER_S)  # rosnode kill waits for an answer, which rospy gives now
