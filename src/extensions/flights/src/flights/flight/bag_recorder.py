"""Records a run with rosbag into the run's folder, and closes the bag at the end."""

from __future__ import annotations

import ctypes
import shutil
import signal
import subprocess
from pathlib import Path

RESERVE_MB = 200
"""Recording stops if less of the disk is free, because the results need space, too."""

_CLOSING_S = 10.0
_PR_SET_PDEATHSIG = 1


class BagRecorder:
    """`rosbag record` of all topics except /clock, which `rosbag play --clock` publishes itself."""

    def __init__(self, bag: Path) -> None:
        """Start recording into `bag`; raises OSError when rosbag cannot be started."""
        self.bag = bag
        command = ["rosrun", "rosbag", "record", "--all", "--exclude", "/clock", "--output-name", str(bag)]
        command += ["--min-space", f"{RESERVE_MB}M"]
        # Its standard output is a line for each topic. Warnings and errors come on the other one.
        self._process = subprocess.Popen(
            [*command, "__name:=experiment_recorder"],
            stdout=subprocess.DEVNULL,
            preexec_fn=_end_with_parent,
        )

    def shortage(self) -> str | None:
        """Return a sentence if the disk is too full to go on recording."""
        return shortage_of(self.bag, shutil.disk_usage(self.bag.parent).free / 2**20)

    def close(self) -> str | None:
        """Stop and wait until the bag is closed. Return its fault in a sentence, or None."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(_CLOSING_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self.bag.is_file():
            return self.shortage()
        return f"rosbag did not complete {self.bag}; see its messages above."


def shortage_of(bag: Path, free_mb: float) -> str | None:
    """Return a sentence if this space is too little to go on recording a bag."""
    if free_mb >= RESERVE_MB:
        return None
    return (
        f"Only {free_mb:.0f} MB are free for {bag}: below {RESERVE_MB} MB rosbag does not record, and the "
        "flight goes on without; free some space or choose another folder with results:=."
    )


def _end_with_parent() -> None:
    """Let the kernel interrupt the recorder if its parent is killed, so that it does not go on alone.

    The parent's threads block the signals (see node_tools.ending), but the recorder must receive them.
    """
    signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT, signal.SIGTERM))
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGINT)
