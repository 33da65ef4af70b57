"""Grid mapping SLAM with a Rao-Blackwellised particle filter (Grisetti et al. 2005, 2007). See README.md.

The library is imported when one of its names is first asked for. So `rostopic` and `rosservice` can read this
package's messages: their Python has no numpy.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gridslam.library import *  # noqa: F403
else:

    def __getattr__(name):
        if name.startswith("_") or find_spec(f"gridslam.{name}"):  # Python imports modules by itself
            raise AttributeError(f"module gridslam has no attribute {name}")
        return getattr(import_module("gridslam.library"), name)
