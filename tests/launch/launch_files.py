"""Launch files as roslaunch itself loads them, and Python programs, without a process that imports all anew.

A command whose output becomes a parameter runs once.

The checks among these commands end at once, as for bringup.sh: they only look at a calling roslaunch.
"""

from __future__ import annotations

import contextlib
import io
import os
import runpy
import shlex
import shutil
import sys
from functools import cache
from pathlib import Path
from subprocess import CompletedProcess
from unittest import mock

import roslaunch
import roslaunch.config
import roslaunch.loader
import roslib.packages
import rospkg

from benchmarks.shared.forked import in_a_copy

_LOADER = roslaunch.loader.Loader
_PARAM_VALUE = _LOADER.param_value


def run(*words: str) -> CompletedProcess:
    """Run a Python program to its end in a copy of this process, which has loaded the libraries."""

    def program() -> tuple[int, str, str]:
        sys.argv, code, said, complained = list(words), 0, io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(complained):
            try:
                runpy.run_path(str(shutil.which(words[0])), run_name="__main__")
            except SystemExit as end:
                code = int(end.code or 0)
        return code, said.getvalue(), complained.getvalue()

    return CompletedProcess(words, *in_a_copy(program))


@cache
def _param_value(verbose: bool, name: str, kind: str, *sources: str | None) -> object:
    command = sources[-1]
    if command is None:
        return _PARAM_VALUE(None, verbose, name, kind, *sources)
    done = run(*shlex.split(command))
    assert done.returncode == 0, f"{command}: {done.stderr}"
    return roslaunch.loader.convert_value(done.stdout, kind)


def load(path: str | Path, *given: str) -> roslaunch.config.ROSLaunchConfig:
    """Load a file with arguments such as "lidar:=ust".

    Raises:
        AssertionError: roslaunch refuses the file.
    """
    runs_once = mock.patch.object(_LOADER, "param_value", lambda _, *what: _param_value(*what))
    finds_once = mock.patch.object(rospkg, "RosPack", rospkg.RosPack.get_instance)
    with runs_once, finds_once, mock.patch.dict(os.environ, LAUNCH_CHECKED="1"):
        try:
            return roslaunch.config.load_config_default([(str(path), given)], None, verbose=False)
        except roslaunch.RLException as error:
            raise AssertionError(f"{path} {given}: {error}") from None


@cache
def node_exists(package: str, node: str) -> bool:
    """Return whether ROS finds the program of a node."""
    return bool(roslib.packages.find_node(package, node, rospkg.RosPack.get_instance()))


@cache
def launch_file(package: str, name: str) -> str | None:
    """Return the path of a launch file as ROS finds it by the name of its package."""
    found = roslib.packages.find_resource(package, name, rospack=rospkg.RosPack.get_instance())
    return next((path for path in found if path.endswith(".launch")), None)
