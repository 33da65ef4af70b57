"""Ends a process at once on SIGINT or SIGTERM, whatever it is doing.

Python raises KeyboardInterrupt even in the middle of an import. rospy's own handler closes topics in the
main thread, and may wait for ever for a lock that this thread holds. The interpreter's own exit sometimes
hangs while threads of rospy, numba or BLAS live. Therefore a separate thread waits for the signal, closes
what is open, removes the process's temporary folders, and ends the process without the interpreter's exit.
This module is the first import of every node's executable, so it imports little itself.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
import threading
from types import ModuleType
from typing import Callable

# rospy and dynamic_reconfigure load two modules of roslib that take a quarter of a node's start. `stacks` is
# out of date, and loads a parser. `launcher` looks through all packages for paths that only rosbuild had.
# Where rosdep is installed, it also says that rosdep was never initialised.
sys.modules.setdefault("roslib.stacks", ModuleType("roslib.stacks"))
_LAUNCHER = ModuleType("roslib.launcher")
_LAUNCHER.load_manifest = lambda _: None  # type: ignore[attr-defined]
sys.modules.setdefault("roslib.launcher", _LAUNCHER)

SIGNALS = (signal.SIGINT, signal.SIGTERM)
CLOSING_S = 2.0
"""Wall time after which the process ends, even if closing is not finished."""
STARTING = 50_000
"""Number of new objects after which Python collects garbage while a node starts: it imports, and loads
machine code. With the usual 700 that takes long.
"""
SCRATCH_TIMES = 3
_UNSAID = "Inbound TCP/IP connection failed"


class Ending:
    """Waits for the signals. Make it in the main thread, before the imports that take time."""

    def __init__(self) -> None:
        self._usual = gc.get_threshold()
        gc.set_threshold(STARTING)
        self._received = threading.Event()
        self.cause = ""
        """Which signal ends the process, and who sent it, in words; empty: none came yet."""
        self._act: Callable[[int], None] = lambda number: os._exit(128 + number)  # nothing is open yet
        # Later threads inherit this mask. So only the waiting thread gets the signal.
        signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
        threading.Thread(target=self._wait_for_signal, name="ending", daemon=True).start()

    def start_is_over(self) -> None:
        """Collect garbage as usual from now on, but not in what was loaded, because that stays."""
        gc.freeze()
        gc.set_threshold(*self._usual)

    @property
    def received(self) -> bool:
        """Whether the process was asked to end."""
        return self._received.is_set()

    def wait(self, timeout_s: float) -> bool:
        """Sleep until the process is asked to end (True) or the time is over (False)."""
        return self._received.wait(timeout_s)

    def closes_by(self, close: Callable[[], None], code: int = 0) -> None:
        """From now on a signal calls `close` and then ends the process with this exit code."""
        self._act = lambda number: leave(code, close)

    def main_thread_closes(self, within_s: float | None = CLOSING_S) -> None:
        """Leave the end to the main thread, which checks `received`.

        within_s: wall time after which the process ends anyway; None: no limit.
        """
        self._act = lambda number: None if within_s is None else exit_later(0, within_s)

    def _wait_for_signal(self) -> None:
        told = signal.sigwaitinfo(SIGNALS)
        self.cause = f"{signal.Signals(told.si_signo).name} {_sender(told.si_pid)}"
        self._received.set()
        _note(f"This process ends: {self.cause}.")
        self._act(told.si_signo)


def _sender(pid: int) -> str:
    """Return in words who sent a signal."""
    if pid == 0:
        return "of the terminal, or of another machine or container"
    try:
        with open(f"/proc/{pid}/cmdline", encoding="utf-8", errors="replace") as file:
            words = " ".join(file.read().split("\0")).strip()
    except OSError:
        words = "which has ended"
    return f"from process {pid} ({words})"


def _note(sentence: str) -> None:
    """Write into the node's log file, if ROS has opened it. The main thread may hang, and say no more."""
    import logging

    logging.getLogger("rospy.core").info(sentence)


def leave(code: int, close: Callable[[], None] = lambda: None) -> None:
    """End the process with this exit code after `close`, or after `CLOSING_S`. Does not return."""
    silence_threads()
    exit_later(code)
    try:
        close()
        _flush()
    finally:
        _exit(code)


def _exit(code: int) -> None:
    remove_scratch()
    os._exit(code)


def remove_scratch() -> None:
    """Remove this process's folders in the temporary folder. `mesh_files.scratch` names them.

    Another thread may still write into them. So they are looked for more than once.
    """
    import glob
    import shutil
    import tempfile

    try:
        namespace = os.stat("/proc/self/ns/pid").st_ino
    except OSError:
        namespace = 0
    mine = f"*_of_process_{os.getpid()}_in_{namespace}_*"
    for _ in range(SCRATCH_TIMES):
        for folder in glob.glob(os.path.join(glob.escape(tempfile.gettempdir()), mine)):
            shutil.rmtree(folder, ignore_errors=True)


def silence_threads() -> None:
    """Suppress what rospy's threads say about sockets that end: tracebacks, and a warning.

    rospy closes sockets that other threads still read. A node that connects while both end says nothing.
    """
    import logging

    threading.excepthook = lambda _: None
    logging.getLogger("rosout").addFilter(lambda record: not str(record.msg).startswith(_UNSAID))


def tell_log_faults_once() -> None:
    """From now on tell once that this process cannot write its log file, as on a full disk. It works on.

    Python's own way is a traceback for each line of the log.
    """
    import logging

    told: list[str] = []
    usual = logging.Handler.handleError

    def handle_error(handler: logging.Handler, record: logging.LogRecord) -> None:
        error = sys.exc_info()[1]
        if not isinstance(error, OSError):
            usual(handler, record)
        elif not told:
            told.append(getattr(handler, "baseFilename", "The log"))
            print(f"{told[0]} cannot be written: {error.strerror}. Free some space.", file=sys.stderr)

    logging.Handler.handleError = handle_error  # type: ignore[assignment, method-assign]


def exit_later(code: int, after_s: float = CLOSING_S) -> None:
    """End the process after this wall time, even if its threads still wait."""
    timer = threading.Timer(after_s, _exit, (code,))
    timer.daemon = True
    timer.start()


def _flush() -> None:
    import logging
    import sys

    logging.shutdown()
    sys.stdout.flush()
    sys.stderr.flush()
