"""The thread that SLAM runs in, so that no callback ever waits for it."""

from __future__ import annotations

import threading
from collections import deque
from concurrent.futures import Future
from typing import Callable

from gridslam_ros.scan_queue import ScanQueue

IDLE_S = 1.0
"""Wall time after which the thread looks for work though nothing has come."""


class Worker:
    """Does one thing at a time: first questions, then upkeep if it is due, then scans.

    Args:
        wakened: its lock guards the queue; notify it when a scan or a transform has come.
        queue: the scans.
        is_ready: whether a scan's transforms are known.
        on_scan: is called with each scan in turn.
        on_left_out: is called with the scans that the queue left out: too late, and without TF.
        upkeep: is called with whether scans are waiting; returns a job to do now, or None.
        on_failure: is called with an unexpected exception of one of them.
        idle: is called when no scan is ready; returns a job to do now, or None.
    """

    def __init__(
        self,
        wakened: threading.Condition,
        queue: ScanQueue,
        is_ready: Callable,
        on_scan: Callable,
        on_left_out: Callable,
        upkeep: Callable,
        on_failure: Callable[[Exception], None],
        idle: Callable = lambda: None,
    ):
        self._wakened, self._queue = wakened, queue
        self._is_ready, self._on_scan, self._on_left_out = is_ready, on_scan, on_left_out
        self._upkeep, self._on_failure, self._idle = upkeep, on_failure, idle
        self._asked: deque = deque()

    def start(self) -> None:
        """Begin to work."""
        threading.Thread(target=self._run, name="slam", daemon=True).start()

    def ask(self, question: Callable) -> Future:
        """Return the future answer of ``question()``. The thread calls it before the next scan."""
        answer: Future = Future()
        with self._wakened:
            self._asked.append((question, answer))
            self._wakened.notify_all()
        return answer

    def _run(self) -> None:
        try:
            while True:
                self._next()()
        except Exception as error:
            self._on_failure(error)

    def _next(self) -> Callable:
        with self._wakened:
            while True:
                if self._asked:
                    question, answer = self._asked.popleft()
                    return lambda: _answer(question, answer)
                upkeep = self._upkeep(len(self._queue) > 0)
                if upkeep:
                    return upkeep
                scan, too_late, without_tf = self._queue.take(self._is_ready)
                self._on_left_out(too_late, without_tf)
                if scan is not None:
                    return lambda: self._on_scan(scan)
                idle = self._idle()
                if idle:
                    return idle
                self._wakened.wait(IDLE_S)


def _answer(question: Callable, answer: Future) -> None:
    try:
        answer.set_result(question())
    except Exception as error:
        answer.set_exception(error)
