"""What Linux tells of processes."""

from __future__ import annotations

import subprocess
import sys

from flights.graph import processes

WORK_S = 0.3
WORKS = f"import time\nwhile time.process_time() < {WORK_S}: pass"
PARENT = f"""
import subprocess, sys
subprocess.run([sys.executable, "-c", {WORKS!r}])
print("done", flush=True)
sys.stdin.read()
"""


def test_the_work_of_a_child_that_has_ended_counts_for_its_parent_only_there():
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert parent.stdout is not None
    assert parent.stdout.readline() == "done\n"
    own_s, children_s = processes.cpu_s(parent.pid), processes.ended_children_cpu_s(parent.pid)
    parent.communicate("")
    assert children_s >= 0.9 * WORK_S
    assert own_s < children_s


def test_of_a_process_that_is_gone_nothing_is_known():
    gone = subprocess.Popen([sys.executable, "-c", "pass"])
    gone.wait()
    assert processes.cpu_s(gone.pid) is None
    assert processes.ended_children_cpu_s(gone.pid) is None
