"""What the nodes of this package do alike: warnings, the way a node starts and ends."""

from __future__ import annotations

import rospy

from gridslam import SlamError
from gridslam_ros.ending import Ending, leave, silence_threads
from gridslam_ros.remarks import kind_of

WARNING_PERIOD_S = 5.0
LAST_CALLBACK_S = 0.4
CANNOT_START = "%s cannot start: %s Change it in the launch file, or by rosparam set under %s."


def run(name: str, node_class, ending: Ending) -> None:
    """Run a node until it is told to end; what is wrong at the start is one sentence and exit code 1."""
    ending.closes_by(lambda: rospy.signal_shutdown("signal"))
    try:
        rospy.init_node(name, disable_signals=True)
        node = node_class()
    except SlamError as error:
        give_up(CANNOT_START, rospy.get_name(), error, rospy.get_name())
    except Exception:
        if not rospy.core.is_shutdown_requested():
            raise
        leave(0, _answer_last_call)  # told to end while it was made
    # No callback may be under way when rospy closes the topics that it publishes on
    rospy.on_shutdown(lambda: node._lock.acquire(timeout=LAST_CALLBACK_S))
    rospy.on_shutdown(silence_threads)
    rospy.spin()
    leave(0, _answer_last_call)


def give_up(sentence: str, *words) -> None:
    """End the process with exit code 1 and one sentence, formatted with the words."""
    rospy.logfatal(sentence, *words)
    leave(1, lambda: rospy.signal_shutdown("failed"))


def _answer_last_call() -> None:
    """Whoever told the node to end (rosnode kill) waits for an answer, which rospy gives now."""
    rospy.rostime.wallsleep(0.15)


class Warnings:
    """Says each fault once in a while, however often it comes."""

    def __init__(self):
        self._said_at_s: dict[str, float] = {}

    def say(self, sentence) -> None:
        """Log the sentence as a warning unless its like was logged in the last seconds."""
        kind = kind_of(sentence)
        now_s = rospy.get_time()
        said_at_s = self._said_at_s.get(kind)
        if said_at_s is None or not 0.0 <= now_s - said_at_s < WARNING_PERIOD_S:
            self._said_at_s[kind] = now_s
            rospy.logwarn("%s", sentence)
