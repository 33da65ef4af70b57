"""A copy of the map on disk, with which a node that died goes on."""

from __future__ import annotations

import math
import os
import time
from pathlib import Path

import rospkg
import rospy

from gridslam.volume.saved.saved_map import VolumeState, write_volume
from node_tools.restarts.kept_parameter import KeptParameter

PAUSES = 50.0
"""The copies take one part in so many of the wall time at most: a long flight's map is large."""
ENDING = ".volume"


class KeptMap:
    """Keeps the map's newest copy in ROS's home, and its path in the node's parameter ~kept.

    A copy counts for a node that the same roslaunch starts again. A new launch begins with an empty map.

    Args:
        period_s: between two copies, by the clouds' stamps; 0: none is kept, and none found.
    """

    def __init__(self, period_s: float) -> None:
        self._period_s, self._kept_s = period_s, 0.0
        name = rospy.get_name().strip("/").replace("/", "_")
        folder = Path(rospkg.get_ros_home())
        self._path = folder / f"{name}_{os.getppid()}{ENDING}"
        self._rests_until_s = -math.inf
        self._kept = KeptParameter("~kept")
        found = str(self._kept.values.get("file", ""))
        self.found = found if period_s > 0.0 and Path(found).is_file() else ""
        """Path of the copy to begin with; empty: there is none."""
        if period_s > 0.0:
            for old in folder.glob(f"{name}_[0-9]*{ENDING}"):
                launch = old.stem.rpartition("_")[2]
                if launch.isdecimal() and not _is_running(int(launch)):
                    old.unlink(missing_ok=True)

    def is_due(self, now_s: float) -> bool:
        """Return whether the period is over, by a stamp."""
        is_over = not 0.0 <= now_s - self._kept_s < self._period_s
        return self._period_s > 0.0 and is_over and time.monotonic() >= self._rests_until_s

    def keep(self, now_s: float, state: VolumeState) -> None:
        """Replace the copy.

        Raises:
            StateError: it cannot be written; the older copy stays.
        """
        self._kept_s, began_s = now_s, time.monotonic()
        write_volume(state, self._path)
        self._rests_until_s = time.monotonic() + PAUSES * (time.monotonic() - began_s)
        self._kept.keep({"file": str(self._path)})


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
