#!/usr/bin/env python3
"""SIGINT and SIGTERM end the nodes at once, whatever they are doing: importing, warming up, spinning."""

import signal
import subprocess
import time
import unittest
from pathlib import Path

import rospy
import rosservice
import rostest
from roslib.packages import find_node

PACKAGE, NODES = "cepa", ("cepa", "cepa_visualiser")
AFTER_S = (0.0, 0.25, 0.6, 1.3)
LEFT_WITHIN_S = 1.5


def blocked_signals(pid) -> int:
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1], 16) for line in lines if line.startswith("SigBlk:"))


class EndingTest(unittest.TestCase):
    def start(self, node, index):
        return subprocess.Popen(
            [find_node(PACKAGE, node)[0], f"__name:={node}_{index}"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def wait_for_the_first_line(self, process):
        """Python itself takes a moment to start, longer on a busy machine; then the signals are blocked."""
        deadline = time.monotonic() + 10.0
        while not blocked_signals(process.pid) & 1 << (signal.SIGINT - 1):
            self.assertLess(time.monotonic(), deadline, "it does not watch for signals")
            time.sleep(0.005)

    def test_a_signal_ends_it_at_once(self):
        for index, after_s in enumerate(AFTER_S):
            number = (signal.SIGINT, signal.SIGTERM)[index % 4 == 3]
            processes = [self.start(node, index) for node in NODES]
            for process in processes:
                self.wait_for_the_first_line(process)
            time.sleep(after_s)
            for process in processes:
                process.send_signal(number)
            deadline = time.monotonic() + LEFT_WITHIN_S
            for node, process in zip(NODES, processes):
                with self.subTest(node=node, after_s=after_s, signal=number):
                    try:
                        said, _ = process.communicate(timeout=max(deadline - time.monotonic(), 0.01))
                    except subprocess.TimeoutExpired:
                        process.kill()
                        self.fail(f"it is still there, and said: {process.communicate()[0]}")
                    self.assertNotIn("Traceback", said)
                    self.assertIn(process.returncode, (0, 128 + number), said)

    def test_a_node_that_spins_takes_leave_of_the_master(self):
        process = self.start(NODES[0], "spinning")
        name = f"/{NODES[0]}_spinning"
        deadline = time.monotonic() + 15.0
        while f"{name}/set_parameters" not in rosservice.get_service_list(node=None):
            self.assertLess(time.monotonic(), deadline, "it never came up")
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=LEFT_WITHIN_S)
        self.assertEqual(process.returncode, 0, said)
        left = [service for service in rosservice.get_service_list() if service.startswith(name)]
        self.assertEqual(left, [])


if __name__ == "__main__":
    rospy.init_node("ending_contract")
    rostest.rosrun(PACKAGE, "ending_contract", EndingTest)
