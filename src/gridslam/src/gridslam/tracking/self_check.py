"""Tests the pose against what cannot be wrong at the same time as the map: places found again, and odometry.

Scans agree with a map that was made at wrong poses, too. So the share of beams that agree does not tell how
far the pose has drifted. A place that is found again does: it tells how far the path was off there, and so
how fast the filter drifts. Odometry does where it excludes the filter's step, and no scan tells which one is
right.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from gridslam.errors import StateError

UNCERTAIN_FROM_M, CERTAIN_BELOW_M = 0.5, 0.3
"""m: the pose is doubted if it may be off by more than the first, until it is less than the second."""
WAY_MIN_M = 10.0
"""m: an error that was found after a shorter way has grown on this way at least."""
HALF_LIFE_M = 50.0
"""m: a drift counts half after this much travel on which places were found where they should be."""


@dataclass(frozen=True)
class SelfCheck:
    """What is known of the pose's error. It never changes; each method returns the next one.

    Raises:
        StateError: the numbers make no sense.
    """

    drift: float = 0.0
    """How fast the pose drifts where no place is found again: m per m of travel."""
    way_m: float = 0.0
    """Travel since a place was found again."""
    open_m: float = 0.0
    """How far the pose may be off by what is not decided yet: a place that was found once, or a step."""
    is_doubted: bool = False

    def __post_init__(self) -> None:
        if not all(0.0 <= value < math.inf for value in (self.drift, self.way_m, self.open_m)):
            raise StateError("The numbers of the pose's own check make no sense.")

    @property
    def expected_m(self) -> float:
        """How far the pose may be off, m."""
        return max(self.open_m, self.drift * self.way_m)

    @property
    def reason(self) -> str:
        """Why the pose is doubted, in words."""
        if self.open_m >= self.drift * self.way_m:
            return (
                f"a place that was seen before, or odometry, says that the pose is off by {self.open_m:.1f} m"
            )
        way, share = f"{self.way_m:.0f} m", f"{100.0 * self.drift:.1f} %"
        return (
            f"the pose may be off by {self.expected_m:.1f} m: no place was recognised for {way}, and it "
            f"drifted by {share} of the way before"
        )

    def travelled(self, way_m: float) -> SelfCheck:
        """The vehicle has moved by this much."""
        return replace(self, way_m=self.way_m + way_m)._judged()

    def recognised(self, off_m: float) -> SelfCheck:
        """A place was found again, and the pose was off by this much. It is right now."""
        found = off_m / max(self.way_m, WAY_MIN_M) if off_m > UNCERTAIN_FROM_M else 0.0
        known = self.drift * 0.5 ** (self.way_m / HALF_LIFE_M)
        return replace(self, drift=max(found, known), way_m=0.0)._judged()

    def begun_anew(self) -> SelfCheck:
        """The pose was given or found on the map, and other tests prove it."""
        return SelfCheck(self.drift)

    def left_open(self, open_m: float) -> SelfCheck:
        """The pose may be off by this much, as long as nothing decides it."""
        return replace(self, open_m=open_m)._judged()

    def _judged(self) -> SelfCheck:
        limit_m = CERTAIN_BELOW_M if self.is_doubted else UNCERTAIN_FROM_M
        return replace(self, is_doubted=self.expected_m > limit_m)
