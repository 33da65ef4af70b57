#!/usr/bin/env python3
"""Runs the TestCases of several modules against one graph, in one process: a start costs more than a test.

A launch file names their files as `args`, in the order in which they run. They find modules that lie beside
them or in the folder above.
"""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import rospy
import rostest


def suite_of(files: list[Path]) -> ModuleType:
    """Return a module whose tests are those of the files."""
    suite = ModuleType("suite_of_contracts")
    suite.load_tests = lambda loader, *_: loader.loadTestsFromNames([file.stem for file in files])
    return suite


if __name__ == "__main__":
    modules = [Path(word) for word in rospy.myargv()[1:] if word.endswith(".py")]
    sys.path[:0] = sorted({str(folder) for module in modules for folder in module.parents[:2]})
    rospy.init_node("contract")
    sys.modules["suite_of_contracts"] = suite_of(modules)
    rostest.rosrun("node_tools", "contract", "suite_of_contracts")
