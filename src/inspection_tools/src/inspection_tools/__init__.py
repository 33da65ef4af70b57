"""Helpers for UAV inspection software, free of ROS: see README.md for the nodes around them.

The library is imported when one of its names is first asked for. So `rostopic` and `rosservice` can read this
package's messages: their Python has no numpy.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from inspection_tools.library import *  # noqa: F403
else:

    def __getattr__(name):
        if name.startswith("_") or find_spec(f"inspection_tools.{name}"):  # Python imports modules by itself
            raise AttributeError(f"module inspection_tools has no attribute {name}")
        return getattr(import_module("inspection_tools.library"), name)
