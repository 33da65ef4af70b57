"""Makes blocking calls outside the callbacks that ask for them."""

from __future__ import annotations

import queue
import threading
from typing import Callable


class RequestThread:
    """Makes one call at a time in its own thread.

    A call reports its own errors and must not raise. Only one thread may use it at a time.
    """

    def __init__(self) -> None:
        self._calls: queue.Queue = queue.Queue()
        self._idle = threading.Event()
        self._idle.set()
        threading.Thread(target=self._work, name="requests", daemon=True).start()

    def ask(self, call: Callable[[], None], patience_s: float) -> bool:
        """Start a call in the thread and wait shortly for its end.

        Return whether it has ended. While an earlier call hangs, no new call is made and the result is
        False. The caller then asks again later.
        """
        if not self._idle.is_set():
            return False
        self._idle.clear()
        self._calls.put(call)
        return self._idle.wait(patience_s)

    def _work(self) -> None:
        while True:
            call = self._calls.get()
            try:
                call()
            finally:
                self._idle.set()
