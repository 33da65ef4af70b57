"""When the points of a cloud were measured: makers of lidars tell it in several fields and units.

velodyne_driver: `time`, float32, s since the stamp (or below 0, if the stamp is of the last point). Ouster:
`t`, uint32, ns since the stamp. Hesai and RoboSense: `timestamp`, float64, s of the clock. Livox:
`offset_time`, uint32, ns, or `timestamp`, float64, ns of the clock.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable

import numpy as np

NAMES = ("time", "t", "timestamp", "time_stamp", "offset_time", "time_offset")
"""Of the field."""
SHORTEST_S, LONGEST_S = 0.001, 1.0
"""A cloud lasts so long. One that is shorter counts as one of an instant."""
UNITS = {1.0: "s", 1e-3: "ms", 1e-6: "us", 1e-9: "ns"}
"""In s. They lie a factor of 1000 apart, as the limits above do, so at most one fits."""
FAR_M = 10.0
"""A turn is told by what it costs at this distance."""
LIMIT_M = 0.1
"""A cloud that is bent by more than this is told: a usual side of a voxel."""


@dataclass(frozen=True, eq=False)
class PointTimes:
    """field: that tells them. since_s: (n,) of each point, after the stamp. why_not: a fault, or empty.

    With a fault the times tell how long the cloud lasted, but not when it began.
    """

    field: str
    since_s: np.ndarray
    why_not: str = ""

    @property
    def first_s(self) -> float:
        """Of the first point."""
        return float(self.since_s.min())

    @property
    def last_s(self) -> float:
        """Of the last point."""
        return float(self.since_s.max())

    @property
    def span_s(self) -> float:
        """From the first to the last."""
        return self.last_s - self.first_s


def point_times(field: str, values: np.ndarray, stamp_s: float) -> PointTimes | None:
    """Return the times of a cloud's points by a field's values (n,); None: all are of one instant.

    The unit is the one by which the cloud lasts from SHORTEST_S to LONGEST_S. The values count from the
    stamp, or from the zero of the clock that stamped the cloud.
    """
    if not len(values):
        return None
    least, greatest = float(values.min()), float(values.max())
    fitting = [unit for unit in UNITS if SHORTEST_S < (greatest - least) * unit <= LONGEST_S]
    if not fitting:  # NaN does not fit
        return None
    unit = fitting[0]
    for zero_s in (0.0, stamp_s):
        begin_s, end_s = least * unit - zero_s, greatest * unit - zero_s
        if begin_s >= -LONGEST_S and end_s <= LONGEST_S:
            return PointTimes(field, values.astype(float) * unit - zero_s)
    since_s = (values - values.dtype.type(least)).astype(float) * unit
    return PointTimes(field, since_s, f"its field {field} counts from another time than its stamp")


class SweptClouds:
    """Tells once a lidar that clouds count as of one instant though the UAV moved while they were measured.

    Args:
        say: is called with a sentence.
    """

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._told: set[str] = set()

    def watch(self, frame: str, times: PointTimes | None, speed_m_s: float, rate_rad_s: float) -> None:
        """Take the times of a cloud, and how fast the UAV flies and turns."""
        if times is None or frame in self._told:
            return
        off_m = times.span_s * (abs(speed_m_s) + abs(rate_rad_s) * FAR_M)
        if not off_m > LIMIT_M or math.isinf(off_m):
            return
        self._told.add(frame)
        self._say(
            f'The points of "{frame}" were measured within {times.span_s:.3g} s (field {times.field}), but '
            f"count as of one instant: at the present motion they are up to {off_m:.2g} m off at {FAR_M:g} "
            "m. Fly and turn slower, or straighten the clouds (deskew) before this node."
        )
