"""How far the UAV has gone without a look at what its body takes."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.free_space import BLIND_WAY_M, BLIND_WAY_M_RAD, ELSEWHERE_M
from cepa.motion import Motion


class BlindWay:
    """The way that the UAV has gone since all that its body takes was last seen.

    Its own place counts as free and goes with it, so that it can set off backwards. A UAV that turns to where
    it flies soon sees. One that does not turn would go on blindly into what stands there. The same would do
    one whose commands alternate between left and right.
    """

    def __init__(self) -> None:
        self._seen_xy = self._last_xy = (math.inf, math.inf)
        self._yaw_rad = 0.0
        self.is_too_long = False

    def follow(self, motion: Motion, is_seen: bool, free_m: np.ndarray) -> np.ndarray:
        """Return the direction (2,) of a way that is too long, or 0; see `leads_back`.

        is_seen: whether all that the body takes was seen. free_m (n,): how far each direction is free, below
        0 where no beam looks. A way that leads where a beam looks is never too long.
        """
        here, yaw_rad = motion.position_m[:2], motion.yaw_rad
        if is_seen or math.dist(here, self._last_xy) > ELSEWHERE_M:
            self._seen_xy, self._yaw_rad = here, yaw_rad
        self._last_xy = here
        way = np.subtract(here, self._seen_xy)
        way_m = math.hypot(*way)
        turned_rad = abs(math.remainder(yaw_rad - self._yaw_rad, 2.0 * math.pi))
        ahead = round(math.atan2(way[1], way[0]) / (2.0 * math.pi) * len(free_m)) % len(free_m)
        is_blind = free_m[ahead] < 0.0
        self.is_too_long = bool(is_blind and way_m > BLIND_WAY_M + BLIND_WAY_M_RAD * turned_rad)
        return way / way_m if self.is_too_long else np.zeros(2)
