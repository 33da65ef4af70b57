"""Gives scans to the filter while the vehicle is tracked, and searches for the vehicle while it is lost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Callable

import numpy as np

from gridslam.localisation.relocaliser import Relocaliser, SearchState
from gridslam.localisation.sight import sees
from gridslam.localisation.standstill import Standstill, StandstillState
from gridslam.scan import PlanarScan, typical_range_m

if TYPE_CHECKING:
    from gridslam.filter.grid_slam import GridSlam
    from gridslam.filter.scan_update import ScanUpdate

CONFIRMATIONS = 2
"""Number of scans in a row that must agree with a pose that was given or found."""
SCANS_IN_VAIN = 20
"""After this many scans the search ends, if the map is SLAM's own."""
PAUSE_APART_MAX = 8
"""After a search of an earlier map in vain, the next one waits for this many more scans at most."""
SEEK_RANGE_SHARE = 0.25
"""While the vehicle is lost, a scan counts after this share of the scan's typical range, if that is less than
`linearUpdate`. In rooms of a few metres nobody drives a metre for each scan.
"""
FOUND_DEVIATION = (0.05, 0.05, 0.02)
"""m, m, rad: uncertainty of a place that was found."""
STANDSTILL_DEVIATION = (0.3, 0.3, 0.2)
"""m, m, rad: uncertainty of odometry that stands still while the scan changes."""


@dataclass(frozen=True, eq=False)
class SupervisorState:
    """A `Supervisor` to save."""

    search: SearchState
    search_of_earlier: SearchState
    """On the earlier map."""
    standstill: StandstillState
    in_vain: int


class Supervisor:
    """Between odometry and the filter.

    Args:
        say: is called with a sentence when the vehicle is lost or found.
    """

    def __init__(self, say: Callable[[str], None]):
        self._say = say
        self._relocaliser, self._earlier = Relocaliser(), Relocaliser(PAUSE_APART_MAX)
        self._standstill = Standstill()
        self._in_vain = 0

    @property
    def search(self) -> str:
        """Describes how far the search for a lost vehicle is; empty before it began."""
        return self._relocaliser.reason

    def process(
        self, slam: GridSlam, scan: PlanarScan, base: np.ndarray, covariance: np.ndarray | None = None
    ) -> ScanUpdate | None:
        """Take in a scan with continuous odometry (3,) and its covariance; see `GridSlam.process`."""
        if self._standstill.has_changed(scan, base) and not slam.is_told_in_space:
            self._say(
                "The scans change while odometry stands still: odometry has failed, the vehicle was carried, "
                "or something moves before the lidar."
            )
            slam.widen(STANDSTILL_DEVIATION)
        tracking = slam.tracking
        if tracking.is_lost:
            self._seek(slam, scan, base, covariance)
            return None
        update = slam.process(scan, base, covariance)
        if slam.evidence is not None:
            self._remember(slam, scan, base)
            if update is not None and slam.earlier is not None:
                self._recognise(slam, scan, base)
        return update

    def _recognise(self, slam: GridSlam, scan: PlanarScan, base: np.ndarray) -> None:
        """Look for the vehicle on the earlier map."""
        assert slam.earlier is not None
        self._earlier.add(scan, base)
        found = self._earlier.look(slam.earlier, slam.base_in_map[2])
        if found is None:
            return
        x, y, yaw = found.tolist()
        self._say(f"A place of the earlier map is recognised at x {x:.2f} m, y {y:.2f} m, yaw {yaw:.2f} rad.")
        slam.return_to_earlier(found, np.diag(FOUND_DEVIATION) ** 2)
        slam.tracking.is_apart = False
        self._earlier.clear()
        self.doubt(slam, "a place of the earlier map was recognised")

    def _remember(self, slam: GridSlam, scan: PlanarScan, base: np.ndarray) -> None:
        """Keep the judged scan while the pose is in doubt."""
        tracking = slam.tracking
        if not (tracking.contradictions or tracking.is_lost or tracking.is_confirming):
            self._relocaliser.clear()
            return
        self._relocaliser.add(scan, base)
        if tracking.is_confirming and tracking.agreed >= CONFIRMATIONS:
            if self._relocaliser.has_better(slam, np.array(slam.base_in_map)):
                tracking.lose("another place of the map fits the scans better")
            else:
                tracking.confirm()
        if tracking.is_lost:
            self._in_vain = 0
            self._say(
                f"The vehicle is lost: {tracking.reason}. The map stays as it is until the vehicle is found "
                "or given by initialpose."
            )
            self._look(slam, scan)

    def _seek(
        self, slam: GridSlam, scan: PlanarScan, base: np.ndarray, covariance: np.ndarray | None
    ) -> None:
        is_enough = slam.follow(base, scan.stamp_s, covariance, SEEK_RANGE_SHARE * typical_range_m(scan))
        if is_enough and sees(scan):  # a search without sight would be in vain, and begin another map
            slam.refuse(scan.stamp_s)
            self._relocaliser.add(scan, base)
            self._look(slam, scan)
            self._in_vain += 1
            if slam.tracking.is_lost and slam.has_own_map and self._in_vain >= SCANS_IN_VAIN:
                self._say(
                    "The vehicle was not found on the map. A new map begins here; the two are joined when a "
                    "place of the earlier one is recognised."
                )
                slam.begin_map()
                slam.tracking.begin_apart("the vehicle was not found on the map")
                self._relocaliser.clear()
                self._earlier.clear()

    def _look(self, slam: GridSlam, scan: PlanarScan) -> None:
        found = self._relocaliser.look(slam, slam.base_in_map[2])
        slam.tracking.reason = self._relocaliser.reason or slam.tracking.reason
        if found is None:
            return
        x, y, yaw = found.tolist()
        self._say(f"The vehicle is found again at x {x:.2f} m, y {y:.2f} m, yaw {yaw:.2f} rad.")
        slam.relocate(found, np.diag(FOUND_DEVIATION) ** 2, scan.stamp_s)
        self.doubt(slam, "the vehicle was found again")

    def doubt(self, slam: GridSlam, reason: str) -> None:
        """Begin at a pose on the map that was given or found: the next scans must fit nowhere else better."""
        slam.tracking.doubt(f"{reason}; the next scans must agree")
        self._relocaliser.clear()

    def forget_map(self) -> None:
        """Note that the map and the pose on it have been corrected."""
        self._relocaliser.forget_map()

    def forget_earlier(self) -> None:
        """Note that there is no earlier map any more."""
        self._earlier.clear()

    def state(self) -> SupervisorState:
        """Return the complete state."""
        searches = self._relocaliser.state(), self._earlier.state()
        return SupervisorState(*searches, self._standstill.state(), self._in_vain)

    def restore(self, state: SupervisorState) -> None:
        """Go on from a state.

        Raises:
            ValueError: it makes no sense.
        """
        self._relocaliser.restore(state.search)
        self._earlier.restore(state.search_of_earlier)
        self._standstill.restore(state.standstill)
        self._in_vain = int(state.in_vain)
