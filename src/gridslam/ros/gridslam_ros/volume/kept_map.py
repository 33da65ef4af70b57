"""A copy of the map on disk, with which a node that died goes on."""

from __future__ import annotations

import os
from pathlib import Path

import rospkg
import rospy

from gridslam.volume import OctreeStream, write_octree


class KeptMap:
    """Keeps the map's newest copy in ROS's home, and its path in the node's parameter ~kept.

    A copy counts for a node that the same roslaunch starts again. A new launch begins with an empty map.

    Args:
        period_s: between two copies, by the clouds' stamps; 0: none is kept, and none found.
    """

    def __init__(self, period_s: float) -> None:
        self._period_s, self._launch, self._kept_s = period_s, os.getppid(), 0.0
        name = rospy.get_name().strip("/").replace("/", "_")
        folder = Path(rospkg.get_ros_home())
        self._path = folder / f"{name}_{self._launch}.ot"
        kept = rospy.get_param("~kept", {})
        is_ours = period_s > 0.0 and kept.get("launch") == self._launch and Path(kept["file"]).is_file()
        self.found = str(kept["file"]) if is_ours else ""
        """Path of the copy to begin with; empty: there is none."""
        if period_s > 0.0:
            for old in folder.glob(f"{name}_[0-9]*.ot"):
                launch = old.stem.rpartition("_")[2]
                if launch.isdecimal() and not _is_running(int(launch)):
                    old.unlink(missing_ok=True)

    def is_due(self, now_s: float) -> bool:
        """Return whether the period is over, by a stamp."""
        return self._period_s > 0.0 and not 0.0 <= now_s - self._kept_s < self._period_s

    def keep(self, now_s: float, octree: OctreeStream, resolution_m: float) -> None:
        """Replace the copy.

        Raises:
            MapError: it cannot be written; the older copy stays.
        """
        self._kept_s = now_s
        write_octree(self._path, octree, resolution_m)
        rospy.set_param("~kept", {"file": str(self._path), "launch": self._launch})


def _is_running(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
