"""Records a run with rosbag, into the run's own folder, and closes the bag at its end."""

from __future__ import annotations

import ctypes
import signal
import subprocess
from pathlib import Path

_CLOSING_S = 10.0
_PR_SET_PDEATHSIG = 1


class BagRecorder:
    """`rosbag record` of all topics but /clock, which `rosbag play --clock` makes itself."""

    def __init__(self, bag: Path) -> None:
        """Start recording into `bag`; raises OSError when rosbag cannot be started."""
        self.bag = bag
        command = ["rosrun", "rosbag", "record", "--all", "--exclude", "/clock", "--output-name", str(bag)]
        self._process = subprocess.Popen(
            [*command, "__name:=experiment_recorder"], preexec_fn=_end_with_parent
        )

    def close(self) -> bool:
        """Stop and wait until the bag is complete; tell whether it is."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(_CLOSING_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        return self.bag.is_file()


def _end_with_parent() -> None:
    """Have the kernel interrupt the recorder when its parent is killed: it must not record on alone."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGINT)
