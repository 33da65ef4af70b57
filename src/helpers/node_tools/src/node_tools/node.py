"""Starts and runs a node: one sentence instead of a traceback, and a clean end."""

from __future__ import annotations

import math
import time
from functools import partial
from typing import Callable, Protocol

import rospy

from node_tools.ending import Ending, exit_later, leave, silence_threads, tell_log_faults_once
from node_tools.parameters import exponents_as_text

HEARD_AFTER_S = 0.3
"""Wall time until subscribers of /rosout are connected to a new node."""
RETRY_S, FIRST_REMINDER_S, REMINDER_S = 1.0, 2.0, 10.0  # wall time
LAST_ANSWER_S = 0.15  # wall time
LAST_CALLBACK_S = 0.4  # wall time
LOOK_S = 0.25
"""Wall time between two checks whether ROS has told the node to end."""

RunNode = Callable[[Ending], int | None]
"""Runs a node in the main thread until it is done, a signal comes, or ROS shuts down. It may return an exit
code.
"""
Errors = type[Exception] | tuple[type[Exception], ...]


class Lock(Protocol):
    """A lock of any kind."""

    def acquire(self, blocking: bool = ..., timeout: float = ...) -> bool:
        """Take it; return False after a time-out."""


class CallbackNode(Protocol):
    """A node that works in its callbacks."""

    @property
    def _lock(self) -> Lock:
        """Held while a callback publishes."""


def cannot_start(error: Exception) -> str:
    """Return the sentence about a fault in the node's parameters."""
    name = rospy.get_name()
    given = rospy.get_param("~", {})
    hint = exponents_as_text(given) if isinstance(given, dict) else ""
    how = hint or f"Change it in the launch file, or by rosparam set under {name}."
    return f"{name} cannot start: {error} {how}"


def run(
    name: str,
    make: Callable[[], RunNode],
    ending: Ending,
    errors: Errors,
    explain: Callable[[Exception], str] = cannot_start,
) -> None:
    """Make a node, run it until it is told to end, and end the process.

    A fault at the start gives one sentence and exit code 1. With the parameter ~keep_trying the node tries
    again until it can start. It repeats the sentence after `FIRST_REMINDER_S`, for nodes that start beside it
    and have not heard the first. Each further time takes twice as long, at most `REMINDER_S`.

    Args:
        name: the node's name.
        make: makes the node and returns what runs it; see `spinning`.
        ending: made before the imports of the executable.
        errors: base class or classes of the errors that are sentences for the user.
        explain: turns an error at the start into the sentence for the user; `str` if the error says it all.
    """
    take_leave = partial(_take_leave, ending)
    ending.closes_by(take_leave)
    try:
        tell_log_faults_once()
        rospy.init_node(name, disable_signals=True)
        keep_trying = rospy.get_param("~keep_trying", False)
        run_node = _make_at_last(make, errors, explain) if keep_trying else make()
        ending.start_is_over()
    except errors as error:
        rospy.rostime.wallsleep(HEARD_AFTER_S)
        give_up(explain(error))
    except Exception:
        if not rospy.core.is_shutdown_requested():
            raise
        leave(0, take_leave)
    ending.main_thread_closes()
    if ending.received:  # before the line above was reached
        leave(0, take_leave)
    code = _run(run_node, ending, errors)
    leave(code, partial(_take_leave, ending, f"its work is over, with exit code {code}"))


def _run(run_node: RunNode, ending: Ending, errors: Errors) -> int:
    """Return the exit code."""
    try:
        return run_node(ending) or 0
    except errors as error:
        rospy.logfatal("%s", error)
        return 1
    except rospy.ROSException:
        if not rospy.is_shutdown():
            raise
    return 0


def spinning(
    node: CallbackNode, period_s: float = LOOK_S, watch: Callable[[], None] = lambda: None
) -> RunNode:
    """Return a function that serves a node's callbacks until it is told to end.

    Args:
        node: works in its callbacks.
        period_s: wall time between two calls of `watch`.
        watch: is called by the main thread.
    """

    def close() -> None:
        silence_threads()
        exit_later(0)  # `watch` may wait for the lock
        # No callback may run while rospy closes the topics that it publishes.
        node._lock.acquire(timeout=LAST_CALLBACK_S)

    rospy.on_shutdown(close)

    def run_node(ending: Ending) -> None:
        while not (rospy.core.is_shutdown_requested() or ending.wait(period_s)):
            watch()

    return run_node


def give_up(sentence: str) -> None:
    """End the process with exit code 1 and a sentence. Does not return."""
    rospy.logfatal("%s", sentence)
    leave(1, partial(_take_leave, None, "it cannot start"))


def _make_at_last(
    make: Callable[[], RunNode], errors: Errors, explain: Callable[[Exception], str]
) -> RunNode:
    """Return the result of `make`, as soon as it raises no error."""
    due_s, patience_s = -math.inf, FIRST_REMINDER_S
    while True:
        try:
            return make()
        except errors as error:
            rospy.rostime.wallsleep(RETRY_S)
            if rospy.is_shutdown():
                raise rospy.ROSInterruptException("told to end") from None
            if time.monotonic() >= due_s:
                due_s, patience_s = time.monotonic() + patience_s, min(2.0 * patience_s, REMINDER_S)
                rospy.logfatal("%s", explain(error))
                rospy.logwarn("It is tried again every second.")


def _take_leave(ending: Ending | None = None, why: str = "the node ends") -> None:
    """Tell the master, and answer the caller that told the node to end (rosnode kill waits for it).

    The node's log says which signal ended it, else `why`. If ROS told it to, rospy has logged who asked.
    """
    told_by_ros = rospy.core.is_shutdown_requested()
    rospy.signal_shutdown((ending.cause if ending else "") or why)
    if told_by_ros:  # another thread is shutting down
        end_s = time.monotonic() + LAST_CALLBACK_S
        while not rospy.is_shutdown() and time.monotonic() < end_s:
            rospy.rostime.wallsleep(0.01)
        rospy.rostime.wallsleep(LAST_ANSWER_S)
