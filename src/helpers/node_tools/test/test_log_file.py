"""A full disk under the log file gives one sentence, and the process works on."""

import logging
import subprocess
import sys
from pathlib import Path

SOURCES = Path(__file__).resolve().parents[1] / "src"
PROGRAM = """
import logging, sys
from node_tools.ending import tell_log_faults_once
tell_log_faults_once()
logger = logging.getLogger("node")
logger.addHandler(logging.FileHandler("/dev/full"))
for number in range(20):
    logger.warning("line %d", number)
logger.warning("%d", "a mistake of the caller")
print("works on")
sys.stdout.flush()
import os
os._exit(0)
"""


def test_a_full_disk_is_told_once_and_other_faults_as_always():
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        capture_output=True, text=True, check=True, env={"PYTHONPATH": str(SOURCES)}, timeout=200.0,
    )  # fmt: skip
    assert done.stdout == "works on\n"
    assert done.stderr.count("/dev/full cannot be written: No space left on device. Free some space.\n") == 1
    assert done.stderr.count("Traceback") == 1  # that of the caller's mistake
    assert "TypeError" in done.stderr


def test_importing_it_changes_nothing():
    assert logging.Handler.handleError.__module__ == "logging"
