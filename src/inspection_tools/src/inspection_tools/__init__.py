"""Helpers for UAV inspection software, free of ROS: see README.md for the nodes around them.

The library is imported when one of its names is first asked for. So `rostopic` and `rosservice` can read this
package's messages: their Python has no numpy.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from inspection_tools.library import *  # noqa: F403
else:

    def __getattr__(name):
        library = import_module("inspection_tools.library")
        if name in getattr(library, "__all__", ()):  # it has none while it is being imported
            return getattr(library, name)
        raise AttributeError(f"module inspection_tools has no attribute {name}")
