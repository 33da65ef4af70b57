"""Launch files as roslaunch itself loads them. A command whose output becomes a parameter runs once.

The checks among these commands end at once, as for bringup.sh: they only look at a calling roslaunch.
"""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from unittest import mock

import roslaunch
import roslaunch.config
import roslaunch.loader
import roslib.packages

_LOADER = roslaunch.loader.Loader
_PARAM_VALUE = _LOADER.param_value


@cache
def _param_value(*given: object) -> object:
    return _PARAM_VALUE(None, *given)


def load(path: str | Path, *given: str) -> roslaunch.config.ROSLaunchConfig:
    """Load a file with arguments such as "lidar:=ust".

    Raises:
        AssertionError: roslaunch refuses the file.
    """
    runs_once = mock.patch.object(_LOADER, "param_value", lambda _, *what: _param_value(*what))
    with runs_once, mock.patch.dict(os.environ, LAUNCH_CHECKED="1"):
        try:
            return roslaunch.config.load_config_default([(str(path), given)], None, verbose=False)
        except roslaunch.RLException as error:
            raise AssertionError(f"{path} {given}: {error}") from None


@cache
def node_exists(package: str, node: str) -> bool:
    """Return whether ROS finds the program of a node."""
    return bool(roslib.packages.find_node(package, node))
