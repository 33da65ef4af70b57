"""Clouds that are older than the map: strays, a clock that was set back, or a recording that begins again.

A stamp alone does not tell them apart. So three things count. How far back: SLAM goes on over a second, and
so does the map. How many: one old cloud is a stray. And what comes afterwards: where the clock was set back,
the sensor goes on from where it was. A recording or a simulation begins again where the map began, and when.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

import numpy as np

from gridslam.volume.clouds import Pose

TRIMMED_S = 1.0
"""A clock that went back by no more was trimmed, and clouds are left out until it has caught up: what the map
knows counts for more than a second of new clouds. SLAM does the same with its scans."""
OLD_ONES = 3
"""So many clouds in a row that are older still tell that the clock has gone back."""
GOES_ON_M = 1.5
"""A sensor that is no farther from its last place than this has gone on from there."""
SET_BACK_S = 5.0
"""A clock that goes back by no more was set, whatever the place: no recording is worth so little."""
SAME_M, SAME_RAD = 0.1, 0.03
"""SLAM's correction has not begun anew if it has changed by no more."""


class Follows(Enum):
    """What follows from a cloud's stamp and place."""

    TAKE = "take it"
    LEAVE_OUT = "leave it out"
    NEXT_FLIGHT = "the clock was set back: the map goes on"
    BEGIN_ANEW = "all begins again: so does the map"


class Placed(NamedTuple):
    """Where the sensor was in `odom`, and `odom` in the map."""

    sensor_in_odom: Pose
    odom_in_map: Pose


class ClockBack:
    """Judges the clouds in the order in which they come."""

    def __init__(self) -> None:
        self._newest_s: float | None = None
        self._first: Placed | None = None
        self._last: Placed | None = None
        self._old_ones = 0
        self._first_s = self._old_from_s = 0.0
        """Stamps of the map's first cloud, and of the first of the old ones."""

    def classify(self, stamp_s: float, placed: Placed) -> Follows:
        """Return what follows from the next cloud.

        A cloud of the newest stamp is left out: a simulator in lockstep repeats its first one until all nodes
        have started.
        """
        back_s = 0.0 if self._newest_s is None else self._newest_s - stamp_s
        if self._newest_s is None or back_s < 0.0:
            return self._take(stamp_s, placed, Follows.TAKE)
        if back_s <= TRIMMED_S:
            return Follows.LEAVE_OUT
        if not self._old_ones:
            self._old_from_s = stamp_s
        self._old_ones += 1
        if self._old_ones < OLD_ONES:
            return Follows.LEAVE_OUT
        if self._goes_on(placed):
            return self._take(stamp_s, placed, Follows.NEXT_FLIGHT)
        self._first = None
        return self._take(stamp_s, placed, Follows.BEGIN_ANEW)

    def _take(self, stamp_s: float, placed: Placed, follows: Follows) -> Follows:
        self._newest_s, self._old_ones, self._last = stamp_s, 0, placed
        if self._first is None:
            self._first, self._first_s = placed, stamp_s
        return follows

    def frame_stays(self, placed: Placed) -> bool:
        """Return whether odometry's frame is in the map where it was at the last cloud."""
        if self._last is None:
            return True
        change = placed.odom_in_map.translation - self._last.odom_in_map.translation
        turn_rad = placed.odom_in_map.turn_from(self._last.odom_in_map)
        return bool(np.linalg.norm(change) <= SAME_M and turn_rad <= SAME_RAD)

    def _goes_on(self, placed: Placed) -> bool:
        """Whether the sensor is where it was last, and not where a recording would begin again."""
        assert self._first is not None
        assert self._last is not None
        assert self._newest_s is not None
        if not self.frame_stays(placed):
            return False
        here_m = placed.sensor_in_odom.translation
        from_last_m = np.linalg.norm(here_m - self._last.sensor_in_odom.translation)
        from_first_m = np.linalg.norm(here_m - self._first.sensor_in_odom.translation)
        is_set = self._old_from_s > min(self._first_s + TRIMMED_S, self._newest_s - SET_BACK_S)
        return bool(from_last_m <= GOES_ON_M and (is_set or from_first_m > 2.0 * GOES_ON_M))
