"""Finds a lost vehicle anywhere on its map, and believes it only when several scans agree.

The scans since the vehicle got lost are joined (`joined_scans`) and searched for on the whole map. A place
counts if no other one fits nearly as well, and if nearly all of these scans agree with it. Then the next
scans must agree with it, too, and a last search with all of them must find it again. Of places that fit
alike, as in a hall that looks the same from both ends, the heading chooses, because it is seldom lost with
the position.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from gridslam import se2
from gridslam.localisation.joined_scans import JoinedScan, JoinedScans
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.scan import PlanarScan
from gridslam.tracking.evidence import Agreement
from gridslam.tracking.monitor import UNSEEN_WEIGHT

if TYPE_CHECKING:
    from gridslam.search import Place, PlaceSearch  # scipy slows the start

SCANS_MAX, SCANS_NEW = 16, 4
"""Number of scans with which places are compared, and of the newest ones, which are searched for."""
RANGE_MAX_M, WIDE_RANGE_MAX_M = 12.0, 20.0
"""Farther points are not searched for: they would need more headings. The second is for all scans."""
SCANS_FIRST = 2
"""The first search waits for this many."""
CONFIRMATIONS = 2
"""Number of further scans that must agree with a place."""
SHARE_MIN = 0.65
"""A scan agrees with a place if this share of its beams does."""
OUTLIERS_OF, OUTLIERS = 4, 1
"""Of four scans one may contradict a place, as where people stand before the lidar, and of those that confirm
it one.
"""
FIT_MIN, FIT_SHARE, PLACES_MAX = 0.5, 0.8, 8
"""Of the search: least mean fit of the points, least share of the best fit, and greatest number of places."""
RIVAL_MARGIN, RIVAL_FACTOR = 0.05, 2.0
"""A place rivals the best one if at most this share of the beams contradicts it, plus this many times the
share that contradicts the best one.
"""
HEADING_NEAR_RAD, HEADING_FAR_RAD = 1.0, 2.0
"""Of places that fit alike, one counts if its heading is as near to that by odometry as the first, and the
headings of all others are farther from it than the second.
"""
SIGMA_MAX_M = 0.3
"""A place must be known to this, in every direction."""
SAME_M, SAME_RAD = 0.5, 0.2
"""Poses that differ by less than this are one place."""
PAUSE_SCANS_MAX = 8
"""After a search in vain, the next one waits for this many more scans at most; for none after the first, and
then for more and more. So a vehicle on the map is found soon, and one beside it costs little.
"""


class KnownMap(Protocol):
    """The filter, of which the map counts only."""

    def grid(self) -> OccupancyGrid:
        """Return the map."""

    def agreement(self, scan: PlanarScan, pose: np.ndarray) -> Agreement:
        """Compare a scan, taken at a pose of the base in the map, with the map."""

    def surface_points(self, scan: PlanarScan) -> np.ndarray:
        """Return the ends (n, 2) of the beams that hit something, in the base frame."""


@dataclass(frozen=True, eq=False)
class SearchState:
    """A `Relocaliser` to save.

    Raises:
        ValueError: it makes no sense.
    """

    scans: tuple[JoinedScan, ...]
    frame_in_map: np.ndarray | None
    """(3,) pose of the joined scans' frame at the place that was found."""
    counts: tuple[int, int, int, int]
    reason: str

    def __post_init__(self) -> None:
        place = self.frame_in_map
        if place is not None and (place.shape != (3,) or not np.isfinite(place).all()):
            raise ValueError("the search's state makes no sense")


class Relocaliser:
    """Looks for the vehicle. After a search in vain the next one waits for at most ``pause_max`` scans."""

    def __init__(self, pause_max: int = PAUSE_SCANS_MAX) -> None:
        self._pause_max = pause_max
        self._joined = JoinedScans(SCANS_MAX)
        self.clear()

    def clear(self) -> None:
        """Forget scans and map: the vehicle has been found, or the search begins anew."""
        self._joined.clear()
        self._frame_in_map: np.ndarray | None = None
        """(3,) pose of the joined scans' frame at the place that was found."""
        self._confirmed = self._contradicted = self._pause = self._failures = 0
        self._search: PlaceSearch | None = None
        self.reason = ""
        """How far the search is, in words; empty before the first one."""

    def add(self, scan: PlanarScan, base_in_odom: np.ndarray) -> None:
        """Take in a scan since the vehicle may be lost, with continuous odometry."""
        self._joined.add(scan, base_in_odom)

    def forget_map(self) -> None:
        """Forget the map and the places on it, because it has been corrected; the scans still count."""
        self._frame_in_map, self._search = None, None

    def look(self, known: KnownMap, heading_rad: float) -> np.ndarray | None:
        """Return the pose (3,) of the base at the newest scan if it is certain, else None.

        ``heading_rad`` is its heading in the map at that scan, if only the position has been lost.
        """
        if self._frame_in_map is not None:
            return self._confirm(known, heading_rad)
        if len(self._joined.scans) < SCANS_FIRST or self._pause > 0:
            self._pause -= 1
            return None
        self._frame_in_map = self._unique(known, heading_rad)
        if self._frame_in_map is None:
            self._failures += 1
            self._pause = min(self._failures**2 // 4, self._pause_max)
        else:
            self._confirmed = self._contradicted = 0
            self.reason = "a place has been found; more scans must agree with it"
        return None

    def has_better(self, known: KnownMap, base_in_map: np.ndarray) -> bool:
        """Return whether the scans fit another place of the map clearly better than a pose of the base."""
        if not self._joined.scans:
            return False
        newest = self._joined.scans[-1].base
        places = self._places(known)
        if not places:
            return False
        x, y, yaw = se2.between(base_in_map, places[0].pose)
        if np.hypot(x, y) < SAME_M and abs(yaw) < SAME_RAD:
            return False
        elsewhere = se2.compose(places[0].pose, se2.inverse(newest))
        here = se2.compose(base_in_map, se2.inverse(newest))
        best = self._mean_share(known, elsewhere)
        return best >= SHARE_MIN and not _rivals(self._mean_share(known, here), best)

    def state(self) -> SearchState:
        """Return the complete state but the map."""
        counts = (self._confirmed, self._contradicted, self._pause, self._failures)
        return SearchState(tuple(self._joined.scans), self._frame_in_map, counts, self.reason)

    def restore(self, state: SearchState) -> None:
        """Go on from a state.

        Raises:
            ValueError: it makes no sense.
        """
        self.clear()
        self._joined.restore(state.scans)
        self._frame_in_map, self.reason = state.frame_in_map, str(state.reason)
        self._confirmed, self._contradicted, self._pause, self._failures = map(int, state.counts)

    def _confirm(self, known: KnownMap, heading_rad: float) -> np.ndarray | None:
        assert self._frame_in_map is not None
        newest = self._joined.scans[-1]
        if _share(known, newest, self._frame_in_map) < SHARE_MIN:
            self._contradicted += 1
            if self._contradicted > OUTLIERS:
                self.reason = "a place was found, but later scans contradict it"
                self._frame_in_map = None
            return None
        self._confirmed += 1
        if self._confirmed < CONFIRMATIONS:
            return None
        before = se2.compose(self._frame_in_map, newest.base)
        self._frame_in_map = self._unique(known, heading_rad)
        if self._frame_in_map is None:
            return None
        here = se2.compose(self._frame_in_map, newest.base)
        x, y, yaw = se2.between(before, here)
        if np.hypot(x, y) > SAME_M or abs(yaw) > SAME_RAD:
            self.reason = "two searches have found different places"
            self._frame_in_map = None
            return None
        return here

    def _places(self, known: KnownMap, scans: int = SCANS_NEW, range_m: float = RANGE_MAX_M) -> list[Place]:
        """Search the map for so many of the newest scans."""
        from gridslam.search import LikelihoodField, PlaceSearch, SearchSettings

        if self._search is None:
            self._search = PlaceSearch(LikelihoodField.from_grid(known.grid()))
        newest = self._joined.scans[-1].base
        points = np.concatenate(
            [
                se2.transform(se2.between(newest, seen.base), known.surface_points(seen.scan))
                for seen in self._joined.scans[-scans:]
            ]
        )
        near = points[np.hypot(*points.T) < range_m]
        return self._search.find(near, SearchSettings(FIT_MIN, FIT_SHARE, PLACES_MAX))

    def _unique(self, known: KnownMap, heading_rad: float) -> np.ndarray | None:
        """Return the joined scans' frame in the map if one place alone fits all scans and the heading."""
        newest = self._joined.scans[-1].base
        places = self._places(known)
        if len(places) == PLACES_MAX:  # there may be more, but what rivals the best one fits all scans
            places = self._places(known, SCANS_MAX, WIDE_RANGE_MAX_M)
        if not places:
            self.reason = "no place of the map fits the scans"
            return None
        if len(places) == PLACES_MAX:
            self.reason = f"{PLACES_MAX} or more places of the map fit the scans alike"
            return None
        frames = [se2.compose(place.pose, se2.inverse(newest)) for place in places]
        shares = np.array([[_share(known, seen, frame) for seen in self._joined.scans] for frame in frames])
        new, all_scans = shares[:, -SCANS_NEW:].mean(axis=1), shares.mean(axis=1)
        alike = np.flatnonzero(_rivals(new, new.max()) & _rivals(all_scans, all_scans.max()))
        if not len(alike):
            self.reason = "the newest scans fit another place than the others do"
            return None
        turned = np.array([abs(se2.wrap(places[i].pose[2] - heading_rad)) for i in alike])
        near, far = turned < HEADING_NEAR_RAD, turned > HEADING_FAR_RAD
        if len(alike) > 1 and not (near.sum() == 1 and (near | far).all()):
            self.reason = f"{len(alike)} or more places of the map fit the scans alike"
            return None
        best = int(alike[turned.argmin()])
        if np.sqrt(np.linalg.eigvalsh(places[best].covariance[:2, :2])[-1]) > SIGMA_MAX_M:
            self.reason = "the scans fit along a whole wall or corridor"
            return None
        agrees = shares[best, -SCANS_NEW:] >= SHARE_MIN
        if np.count_nonzero(~agrees) > OUTLIERS * len(agrees) // OUTLIERS_OF:
            self.reason = "the best place of the map contradicts some of the scans"
            return None
        return frames[best]

    def _mean_share(self, known: KnownMap, frame: np.ndarray) -> float:
        """Return the mean share of the newest scans' beams that agree, with the joined scans' frame there."""
        return float(np.mean([_share(known, seen, frame) for seen in self._joined.scans[-SCANS_NEW:]]))


def _share(known: KnownMap, seen: JoinedScan, frame: np.ndarray) -> float:
    """Return the share of a scan's beams that agree with the map, with the joined scans' frame at a pose."""
    found = known.agreement(seen.scan, se2.compose(frame, seen.base))
    return found.share(UNSEEN_WEIGHT) if found.is_meaningful() else 0.0


def _rivals(share: Any, best: float) -> Any:
    """Return whether a place with this share of agreeing beams, or each of several, rivals the best one."""
    return 1.0 - share < RIVAL_MARGIN + RIVAL_FACTOR * (1.0 - best)
