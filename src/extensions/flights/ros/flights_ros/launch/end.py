"""Ends a launch: after a successful run the experiment's node interrupts its roslaunch like Ctrl-C."""

from __future__ import annotations

import contextlib
import os
import signal
from pathlib import Path

from node_tools.ending import Ending
from simulation_tools_ros.launch_check import command_line

LAUNCH_ENDS_S = 10.0
"""Wall time until roslaunch has told this node to end."""


def end_launch(ending: Ending) -> None:
    """Let the roslaunch that started this process end everything.

    Return at once if there is none. If a required node ends by itself, roslaunch reports a death in red,
    even after a success.
    """
    parent = os.getppid()
    words = command_line(parent)
    if not any(Path(word).name == "roslaunch" for word in words[:2]) or "-c" in words:
        return
    with contextlib.suppress(ProcessLookupError):
        os.kill(parent, signal.SIGINT)
        ending.wait(LAUNCH_ENDS_S)
