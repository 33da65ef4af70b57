"""Writes the newest of some values where writing may take for ever, as to a ROS master that is far away."""

from __future__ import annotations

import queue
import threading
from typing import Any, Callable

PATIENCE_S = 1.0
"""Wall time that the writing may hold up who asks for it. It usually takes some milliseconds."""


class NewestWriter:
    """Writes in a thread of its own. Whoever asks waits shortly for the end, so that it is mostly done then.

    While a write hangs, nobody waits for it. Of what is asked for meanwhile, the newest is written later.

    Args:
        put: writes one value. It must not raise.
    """

    def __init__(self, put: Callable[[Any], None]) -> None:
        self._put = put
        self._values: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._is_idle = threading.Event()
        self._is_idle.set()
        threading.Thread(target=self._work, name="newest_writer", daemon=True).start()

    def write(self, value: Any) -> None:
        """Write a value, soon. Only one thread at a time may call it."""
        was_idle = self._is_idle.is_set()
        self._is_idle.clear()
        self._values.put(value)
        if was_idle:
            self._is_idle.wait(PATIENCE_S)

    def _work(self) -> None:
        while True:
            value = self._values.get()
            while not self._values.empty():
                value = self._values.get()
            self._put(value)
            if self._values.empty():
                self._is_idle.set()
