"""Requests of other threads to the one thread that owns the simulation."""

from __future__ import annotations

import queue
import threading
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from typing import Any, Callable

from simulation_tools.errors import SimulationToolsError


class RunLoopError(SimulationToolsError):
    """The run loop cannot do what it was asked to."""


class Requests:
    """Calls of functions that other threads want between two steps. The thread that makes it owns it."""

    def __init__(self) -> None:
        self._waiting: queue.Queue = queue.Queue()
        self._owner = threading.get_ident()
        self._closed = False

    def call(self, function: Callable[[], Any], timeout_s: float) -> Any:
        """Run `function` in the owner's thread; return what it returns, raise what it raises.

        Raises:
            RunLoopError: no answer within timeout_s of wall time, or the simulator is shutting down.
        """
        if threading.get_ident() == self._owner:
            return function()
        future: Future = Future()
        self._waiting.put((function, future))
        if self._closed:
            self._refuse_all()
        try:
            return future.result(timeout_s)
        except FutureTimeoutError as error:
            future.cancel()
            raise RunLoopError(f"The simulator did not answer within {timeout_s:g} s.") from error

    def serve(self) -> None:
        """Run all waiting functions. The owner's thread calls this between two steps."""
        while not self._waiting.empty():
            function, future = self._waiting.get()
            if not future.set_running_or_notify_cancel():
                continue  # the caller has given up
            try:
                future.set_result(function())
            except Exception as error:  # the caller gets every exception
                future.set_exception(error)

    def close(self) -> None:
        """Refuse every request from now on."""
        self._closed = True
        self._refuse_all()

    def _refuse_all(self) -> None:
        while not self._waiting.empty():
            try:
                _, future = self._waiting.get_nowait()
            except queue.Empty:
                return
            future.set_exception(RunLoopError("The simulator is shutting down."))
