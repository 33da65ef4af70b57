"""Tells which map it is, and keeps what a node that dies needs to go on in the frame of its map."""

from __future__ import annotations

from typing import NamedTuple

import rospy
from std_msgs.msg import String

from gridslam.session import SlamSession
from node_tools.ending import Ending
from node_tools.restarts.kept_parameter import KeptParameter

KEEP_S = 1.0
"""ROS time between two writings of the pose."""
GONE_S = 60.0
"""A node that was away for longer, by the scans' stamps, begins as if there had been none: nobody flew on."""


class Former(NamedTuple):
    """Where odometry's frame was in the map of the node that died, and the base in odometry's frame."""

    stamp_s: float
    odom_in_map: tuple[float, float, float]
    base_in_odom: tuple[float, float, float]


class MapIdentity:
    """Publishes ~map_id (latched): the same as long as places in the map's frame mean the same.

    It is the stamp of the path's first scan, and a number that grows with each map that this launch begins. A
    given map (`starting_map`) is named by its file. A saved state keeps the path's first stamp, so it is the
    same map wherever it is loaded.

    Args:
        given: file of the map to begin with; empty: the map is SLAM's own.
        ending: of the node.
    """

    def __init__(self, given: str, ending: Ending) -> None:
        self._given = given
        self._kept = KeptParameter("~kept", ending)
        self._publisher = rospy.Publisher("~map_id", String, queue_size=1, latch=True)
        self._told_of: SlamSession | None = None
        self._id, self._kept_s = str(self._kept.values.get("id", "")), 0.0

    def former(self) -> Former | None:
        """Return what a node that died has left; None: there was none, or its map was a given one."""
        values = self._kept.values
        if self._given or "odom_in_map" not in values:
            return None
        return Former(float(values["stamp"]), tuple(values["odom_in_map"]), tuple(values["base_in_odom"]))

    def tell(self, session: SlamSession, is_saved: bool) -> None:
        """Publish the identity of a session's map once it has begun. is_saved: it was read from a file."""
        if session is self._told_of or session.slam is None:
            return
        self._told_of = session
        begun = f"{session.trajectory().stamps_s[0]:.3f}"
        number = int(self._kept.values.get("number", 0))
        if self._given:
            self._id = self._given
        elif not (is_saved and self._id.startswith(begun + "-")):
            number = number if is_saved else number + 1
            self._id = f"{begun}-{0 if is_saved else number}"
        self._publisher.publish(self._id)
        self._kept.keep({**self._kept.values, "id": self._id, "number": number})

    def keep(self, stamp_s: float, session: SlamSession, base_in_odom: tuple[float, float, float]) -> None:
        """Keep where the vehicle is, at the stamp of a scan."""
        now_s = rospy.get_time()
        if 0.0 <= now_s - self._kept_s < KEEP_S or session.map_to_odom is None:
            return
        self._kept_s = now_s
        places = {"odom_in_map": list(session.map_to_odom), "base_in_odom": list(base_in_odom)}
        self._kept.keep({**self._kept.values, **places, "stamp": stamp_s})
