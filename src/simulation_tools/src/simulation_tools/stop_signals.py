"""How a node ends: at once, whatever it is doing when SIGINT or SIGTERM comes.

Python would raise KeyboardInterrupt out of the middle of an import. rospy's own handler closes every
connection from within the main thread, wherever that happens to be, and waits for ever for a lock that the
interrupted code holds. And an interpreter that shuts down while threads of rospy, numba or BLAS live
sometimes never does. So a thread of its own waits for the signal, the main thread closes what there is to
close, and the process ends without the interpreter's own end.
"""

from __future__ import annotations

import logging
import os
import signal
import sys
import threading
from typing import Callable

# As in node_tools.ending: rosdep, where it is installed and not initialised, would complain in every node.
sys.modules.setdefault("rosdep2", None)  # type: ignore[arg-type]

SIGNALS = (signal.SIGINT, signal.SIGTERM)
PATIENCE_S = 1.0


class StopSignals:
    """Notes that the process was asked to end; to be made in the main thread before any slow import.

    Until `watched` is called a signal ends the process on the spot: nothing has begun yet. From then on the
    main thread has `PATIENCE_S` to end by itself.
    """

    def __init__(self) -> None:
        self._received = threading.Event()
        self._watched = False
        # Threads made from now on inherit the mask, so a signal always comes to the one that waits for it.
        signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
        threading.Thread(target=self._wait_for_signal, name="stop_signals", daemon=True).start()

    @property
    def received(self) -> bool:
        """Whether the process was asked to end."""
        return self._received.is_set()

    def wait(self, timeout_s: float) -> bool:
        """Sleep until the process is asked to end (True) or the time is over."""
        return self._received.wait(timeout_s)

    def watched(self) -> None:
        """Declare that the main thread looks at `received` from now on."""
        self._watched = True

    def _wait_for_signal(self) -> None:
        number = signal.sigwait(SIGNALS)
        self._received.set()
        if not self._watched:
            os._exit(128 + number)
        _exit_later(0)


def leave(code: int, close: Callable[[], None] = lambda: None) -> None:
    """End the process after `close`, or after `PATIENCE_S` if that takes longer. Does not return."""
    _exit_later(code)
    try:
        close()
        logging.shutdown()
        sys.stdout.flush()
        sys.stderr.flush()
    finally:
        os._exit(code)


def _exit_later(code: int) -> None:
    timer = threading.Timer(PATIENCE_S, os._exit, (code,))
    timer.daemon = True
    timer.start()
