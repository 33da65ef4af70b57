"""What a lidar's messages tell, once it is known what its driver means by them."""

from __future__ import annotations

import copy
from typing import Callable, Iterable

import numpy as np
from sensor_msgs.msg import LaserScan, PointCloud2
from std_msgs.msg import Header

from input_checks.far_value import FarValues
from input_checks.point_times import NAMES, PointTimes, point_times
from node_tools.clouds import FORMATS, points_of, rows_of

UNSEEN_INTENSITY = -1.0
"""LaserScan.intensities of a beam that nobody has seen: the message has no field of its own for that."""
BEYOND = 2.0
"""A point for nothing ends at this many times the range up to which it is known to be free, which cuts it."""


class LidarReadings:
    """The door by which nodes take scans and clouds. What a driver tells for nothing becomes nothing.

    Args:
        say: is called with a sentence when a far value is taken for nothing, or no longer.
    """

    def __init__(self, say: Callable[[str], None]) -> None:
        self._far = FarValues(say)

    def look_ahead(self, messages: Iterable[LaserScan | PointCloud2]) -> None:
        """Learn from the first messages of a recording, which come again, what its first scan means."""
        for message in messages:
            self.points(message) if isinstance(message, PointCloud2) else self.scan(message)
        self._far.rewind()

    def scan(self, message: LaserScan) -> LaserScan:
        """Return a scan with +inf where a beam met nothing (REP-117); the same one if it has that.

        Of beams that nobody has seen (padding) nothing is known, so they stay as they are.
        """
        ranges_m = seen_m = np.asarray(message.ranges)
        intensities = np.asarray(message.intensities)
        seen = intensities != UNSEEN_INTENSITY if len(intensities) == len(ranges_m) > 0 else None
        if seen is not None:
            seen_m = ranges_m[seen]
        header, limits_m = message.header, (message.range_min, message.range_max)
        found = self._far.nothing_in(header.frame_id, header.stamp.to_sec(), seen_m, limits_m)
        if found is None:
            return message
        met_nothing, value_m = found
        if seen is not None:
            seen[seen] = met_nothing
            met_nothing = seen
        told = copy.copy(message)
        told.ranges = np.where(met_nothing, ranges_m.dtype.type(np.inf), ranges_m)
        told.range_max = min(value_m, message.range_max)  # it is not known to be free beyond
        return told

    def points(self, message: PointCloud2, free_up_to_m: float = 0.0) -> np.ndarray:
        """Return the points (n, 3) of a cloud as `met` does. Raises CloudError as `points_of`."""
        return self.met(message.header, points_of(message), free_up_to_m)

    def met(self, header: Header, points: np.ndarray, free_up_to_m: float = 0.0) -> np.ndarray:
        """Return a cloud's points (n, 3), float32, m, with NaN where a beam met nothing; they are changed.

        free_up_to_m: greatest range of a map's rays. If the lidar sees so far, a beam that met nothing ends
        beyond it, so that the map takes the ray for free.
        """
        far_m = np.sqrt(np.einsum("ij,ij->i", points, points))
        found = self._far.nothing_in(header.frame_id, header.stamp.to_sec(), far_m, (0.0, np.inf))
        if found is not None:
            met_nothing, value_m = found
            is_free = 0.0 < free_up_to_m <= value_m * (1.0 + 1e-6)
            points[met_nothing] = points[met_nothing] * BEYOND if is_free else np.nan
        return points


def times_of(message: PointCloud2) -> PointTimes | None:
    """Return when each point of a cloud was measured; None: all at once, or it does not tell.

    Raises:
        CloudError: its steps and its length do not agree.
    """
    for field in message.fields:
        if field.name.lower() in NAMES and field.datatype in FORMATS:
            values = rows_of(message, [field])[field.name].reshape(-1)
            return point_times(field.name, values, message.header.stamp.to_sec())
    return None
