"""How a node ends: at once, whatever it is doing when SIGINT or SIGTERM comes.

Python would raise KeyboardInterrupt out of the middle of an import; rospy closes its topics from within
whatever the main thread is just doing, and may wait for ever for a lock that it holds itself; and an
interpreter that ends while threads of rospy and numba live sometimes never does. So a thread of its own waits
for the signal, closes what there is to close, and ends the process without the interpreter's own end.
"""

from __future__ import annotations

import logging
import os
import signal
import sys
import threading

SIGNALS = (signal.SIGINT, signal.SIGTERM)
CLOSING_S = 0.8


class Ending:
    """Waits for the signals; made in the main thread before anything is imported that takes time."""

    def __init__(self):
        self._close = None
        # The threads made later inherit this, so that the signal always comes to the one that waits.
        signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
        threading.Thread(target=self._wait, name="ending", daemon=True).start()

    def closes_by(self, close) -> None:
        """Call ``close()`` first from now on, and then end with exit code 0."""
        self._close = close

    def _wait(self) -> None:
        number = signal.sigwait(SIGNALS)
        if self._close is None:
            os._exit(128 + number)  # nothing has begun
        leave(0, self._close)


def leave(code: int, close) -> None:
    """End the process with this exit code after ``close()``, or after ``CLOSING_S`` if that takes longer."""
    silence_threads()
    closing = threading.Thread(target=_close_and_flush, args=(close,), daemon=True)
    closing.start()
    closing.join(CLOSING_S)
    os._exit(code)


def silence_threads() -> None:
    """Let threads end without a traceback: rospy closes sockets under those that still listen to them."""
    threading.excepthook = lambda _: None


def _close_and_flush(close) -> None:
    try:
        close()
    finally:
        logging.shutdown()
        sys.stdout.flush()
        sys.stderr.flush()
