"""Tests the pose against what cannot be wrong at the same time as the map: places found again, and odometry.

Scans agree with a map that was made at wrong poses, too. So the share of beams that agree does not tell how
far the pose has drifted. A place that is found again does: it tells how far the path was off there, and so
how fast the filter drifts. Odometry does where it excludes the filter's step, and no scan tells which one is
right.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gridslam.errors import StateError

UNCERTAIN_FROM_M, CERTAIN_BELOW_M = 0.5, 0.3
"""m: the pose is doubted if it may be off by more than the first, until it is less than the second."""
MAP_SIGMAS = 1.25
"""In the map, the pose may be off by so many standard deviations of its place, as errors were so far."""
WAY_MIN_M = 10.0
"""m: an error that was found after a shorter way has grown on this way at least."""
DRIFT_MUCH = 0.1
"""m per m: where closures have told that the pose drifts faster, as after a wheel that slipped, the map's
spread counts wholly, whatever its errors were before. Usual is 0.03 at most.
"""
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
    spread_m: float = 0.0
    """How far the pose may have drifted since a place was found again, by what scans and odometry measure."""
    map_spread_m: float = 0.0
    """How far the place in the map may be off from where the map began, by what scans and odometry tell."""
    error_share: float = 1.0
    """How large the place's error in the map is usually, as a share of what scans and odometry tell."""
    is_bridged: bool = False
    """Whether the map goes on after a gap where odometry alone says, and no place was found again since."""
    is_drifting: bool = False
    """Whether that is too far, though nothing says that the pose is wrong."""

    def __post_init__(self) -> None:
        numbers = (self.drift, self.way_m, self.open_m, self.spread_m, self.map_spread_m, self.error_share)
        if not all(0.0 <= value < math.inf for value in numbers):
            raise StateError("The numbers of the pose's own check make no sense.")

    @property
    def _counted_map_spread_m(self) -> float:
        """In a place that was recognised, the pose is as good as the map there."""
        share = max(1.0, self.error_share) if self.drift > DRIFT_MUCH else self.error_share
        return MAP_SIGMAS * share * self.map_spread_m

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

    @property
    def reason_of_drift(self) -> str:
        """Why the pose may have drifted, in words."""
        if self.is_bridged:
            return (
                "the scans agree with the map, but scans were missing before it goes on in unseen space: "
                "there odometry alone tells the way, and no place was recognised since"
            )
        if self._counted_map_spread_m > MAP_SIGMAS * self.spread_m:
            return (
                "the scans agree with the map, but no closure tells where this part of the map is; it may be "
                f"off by {self._counted_map_spread_m:.1f} m"
            )
        drifted_m = max(self.spread_m, self._counted_map_spread_m)
        return (
            f"the scans agree with the map, but no place was recognised for {self.way_m:.0f} m; the pose may "
            f"have drifted by {drifted_m:.1f} m"
        )

    def travelled(self, way_m: float) -> SelfCheck:
        """The vehicle has moved by this much."""
        return replace(self, way_m=self.way_m + way_m)._judged()

    def recognised(self, drift: float = 0.0) -> SelfCheck:
        """A place was found again, and the path is right there. It had drifted by this; see `drift_of`."""
        known = self.drift * 0.5 ** (self.way_m / HALF_LIFE_M)
        return replace(self, drift=max(drift, known), way_m=0.0, spread_m=0.0, is_bridged=False)._judged()

    def begun_anew(self) -> SelfCheck:
        """The pose was given or found on the map, and other tests prove it."""
        return SelfCheck(self.drift)

    def left_open(self, open_m: float) -> SelfCheck:
        """The pose may be off by this much, as long as nothing decides it."""
        return replace(self, open_m=open_m)._judged()

    def spread_over(self, spread_m: float, map_spread_m: float, error_share: float = 1.0) -> SelfCheck:
        """The pose may have drifted by this much since a place was found again, and in the map."""
        return replace(self, spread_m=spread_m, map_spread_m=map_spread_m, error_share=error_share)._judged()

    def bridged(self) -> SelfCheck:
        """Scans were missing, and what came after them is mapped where odometry alone says."""
        return replace(self, is_bridged=True)._judged()

    def _judged(self) -> SelfCheck:
        limit_m, drifted_m = (
            CERTAIN_BELOW_M if was_beyond else UNCERTAIN_FROM_M
            for was_beyond in (self.is_doubted, self.is_drifting)
        )
        spread_m = max(self.spread_m, self._counted_map_spread_m)
        return replace(
            self, is_doubted=self.expected_m > limit_m, is_drifting=self.is_bridged or spread_m > drifted_m
        )


def drift_of(before: np.ndarray, corrected: np.ndarray) -> float:
    """Return how fast a path had drifted, m per m of travel, by its correction; 0: by less than counts.

    The greatest error has grown since the last node before it that was right, to a tenth of that error.

    Args:
        before: (k, 3) poses of its nodes: x, y in m and yaw in rad.
        corrected: (k, 3) the same after the correction.
    """
    moved_m = np.hypot(*(corrected - before)[:, :2].T)
    way_m = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(before[:, :2], axis=0).T))])
    worst = int(moved_m.argmax())
    if moved_m[worst] <= UNCERTAIN_FROM_M:
        return 0.0
    right = np.flatnonzero(moved_m[:worst] < 0.1 * moved_m[worst])
    grown_m = way_m[worst] - (way_m[right[-1]] if len(right) else 0.0)
    return float(moved_m[worst] / max(grown_m, WAY_MIN_M))
