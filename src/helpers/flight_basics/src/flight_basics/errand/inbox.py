"""Where messages wait for the one thread that takes them."""

from __future__ import annotations

import queue
import threading
from typing import Any, Callable


class Inbox:
    """A queue of messages. Anybody may put one, and nobody waits for it."""

    def __init__(self) -> None:
        self._waiting: queue.SimpleQueue[Any] = queue.SimpleQueue()

    def put(self, message: Any) -> None:
        """Put a message."""
        self._waiting.put(message)

    @property
    def waiting(self) -> int:
        """Number of messages that wait."""
        return self._waiting.qsize()

    def get(self, timeout_s: float) -> Any | None:
        """Return the oldest message, or None if none comes within a wall time."""
        try:
            return self._waiting.get(timeout=timeout_s)
        except queue.Empty:
            return None


class Worker:
    """A thread that does one thing after the other.

    on_error: told what a job has raised, in this thread. The next job follows.
    """

    def __init__(self, name: str, on_error: Callable[[Exception], None]) -> None:
        self._jobs: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._on_error = on_error
        threading.Thread(target=self._run, name=name, daemon=True).start()

    def do(self, job: Callable[[], None]) -> None:
        """Do something after all that is to be done already."""
        self._jobs.put(job)

    def _run(self) -> None:
        while True:
            try:
                self._jobs.get()()
            except Exception as error:
                self._on_error(error)
