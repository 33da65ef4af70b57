"""Publishes the map of a session, with its entropy, its path and its closures."""

from __future__ import annotations

import math

import rospy
from nav_msgs.msg import MapMetaData, OccupancyGrid, Path
from std_msgs.msg import Float64
from visualization_msgs.msg import Marker

from gridslam import StateError
from gridslam.session import SlamSession
from gridslam_ros import conversions


class MapPublisher:
    """Publishes map, map_metadata, ~entropy, ~path and ~closures together, all latched.

    Args:
        map_frame: the frame of all of them.
        interval_s: the least time by the scans' stamps between two maps, unless somebody asks for one.
    """

    def __init__(self, map_frame: str, interval_s: float) -> None:
        self._map_frame, self._interval_s = map_frame, interval_s
        self._maps = rospy.Publisher("map", conversions.NumpyGridMessage, queue_size=1, latch=True)
        self._metadata = rospy.Publisher("map_metadata", MapMetaData, queue_size=1, latch=True)
        self._entropy = rospy.Publisher("~entropy", Float64, queue_size=1, latch=True)
        self._paths = rospy.Publisher("~path", Path, queue_size=1, latch=True)
        self._closures = rospy.Publisher("~closures", Marker, queue_size=1, latch=True)
        self._integrated_s, self._published_s, self._is_old = math.nan, -math.inf, False

    def restart(self, integrated_s: float) -> None:
        """Begin with another session, whose last integrated scan has this stamp (nan: it has none)."""
        self._integrated_s, self._published_s = integrated_s, -math.inf
        self._is_old = not math.isnan(integrated_s)

    @property
    def is_empty(self) -> bool:
        """Whether no scan has been integrated."""
        return math.isnan(self._integrated_s)

    def integrated(self, stamp_s: float) -> None:
        """Take note of a scan that the session has integrated."""
        self._integrated_s, self._is_old = stamp_s, True

    def is_due(self, now_s: float, scans_wait: bool) -> bool:
        """Whether a map is due: the last one is old and an interval is over, or two if scans wait."""
        interval_s = (2.0 if scans_wait else 1.0) * self._interval_s
        return self._is_old and not 0.0 <= now_s - self._published_s < interval_s

    def publish(self, session: SlamSession, now_s: float) -> OccupancyGrid:
        """Publish and return what a session has mapped until now. Raises StateError where there is no map."""
        if self.is_empty:
            raise StateError("There is no map yet: no scan has been integrated.")
        self._published_s, self._is_old = now_s, False
        header = conversions.header_of(self._integrated_s, self._map_frame)
        message = conversions.grid_message(session.grid(), header)
        self._maps.publish(message)
        self._metadata.publish(message.info)
        self._entropy.publish(session.entropy)
        trajectory = session.trajectory()
        self._paths.publish(conversions.path_message(trajectory, header))
        self._closures.publish(conversions.closures_message(session.closures, trajectory, header))
        return message
