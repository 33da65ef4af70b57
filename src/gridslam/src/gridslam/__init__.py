"""Grid mapping SLAM with a Rao-Blackwellised particle filter (Grisetti et al. 2005, 2007). See README.md.

The library is imported when one of its names is first asked for. So `rostopic` and `rosservice` can read this
package's messages: their Python has no numpy.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gridslam.library import *  # noqa: F403
else:

    def __getattr__(name):
        library = import_module("gridslam.library")
        if name in getattr(library, "__all__", ()):  # it has none while it is being imported
            return getattr(library, name)
        raise AttributeError(f"module gridslam has no attribute {name}")
