"""In lockstep, tells the simulator that a node still works on a scan, though that takes long."""

from __future__ import annotations

import threading
import time
from typing import Callable

import rospy
from std_msgs.msg import Header

BEAT_S = 0.5
"""Wall time between two beats."""
LEAST_S = 0.005
"""A process that needs less CPU time between two beats does not work: it waits, or hangs."""


class WorkMeter:
    """Whether a process has worked since the last question.

    cpu_s: tells its CPU time.
    """

    def __init__(self, cpu_s: Callable[[], float] = time.process_time) -> None:
        self._cpu_s, self._before_s = cpu_s, cpu_s()

    def has_worked(self) -> bool:
        """Return whether it has needed CPU time since the last question."""
        before_s, self._before_s = self._before_s, self._cpu_s()
        return self._before_s - before_s >= LEAST_S


class Working:
    """Publishes ~working (std_msgs/Header) while the node works on what it has not acknowledged yet.

    The simulator waits for a participant that works. One whose CPU time stands still tells nothing, and is
    left behind after the time-out.

    is_busy: returns whether something is to be acknowledged; called from a thread of its own.
    """

    def __init__(self, is_busy: Callable[[], bool]) -> None:
        self._is_busy, self._meter = is_busy, WorkMeter()
        self._beats = rospy.Publisher("~working", Header, queue_size=1, tcp_nodelay=True)
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self) -> None:
        while not rospy.is_shutdown():
            time.sleep(BEAT_S)
            if self._meter.has_worked() and self._is_busy():
                self._beats.publish(Header())
