"""SIGINT and SIGTERM for nodes whose main thread publishes.

rospy's own handler closes every connection from within the main thread, wherever that happens to be. A main
thread that is just publishing holds the connection's lock, so the handler waits for ever for the code that it
interrupted, and roslaunch has to kill the node. Here a signal only leaves a note.
"""

from __future__ import annotations

import signal


class StopSignals:
    """Notes that the process was asked to end. To be made in the main thread."""

    def __init__(self) -> None:
        self.received = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._note)

    def _note(self, number: int, frame: object) -> None:
        self.received = True
