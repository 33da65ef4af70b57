"""The last scans, joined by odometry and by aligning each with those before it."""

from __future__ import annotations

from typing import NamedTuple, Sequence

import numpy as np

from gridslam import se2
from gridslam.scan import PlanarScan

LINKS_BACK = 3
"""A scan is aligned with so many scans before it."""
TURNS_RAD = (0.0, -0.15, 0.15)
"""The alignment begins at odometry's prediction turned by each of these: the heading errs most."""

LEAST_VARIANCE = np.array((1e-4, 1e-4, 1e-5))
"""m2, m2, rad2: of a step of odometry, however short."""


class JoinedScan(NamedTuple):
    """A scan and where its base was."""

    scan: PlanarScan
    base_in_odom: np.ndarray
    """(3,) by odometry alone."""
    base: np.ndarray
    """(3,) in a frame in which the scans fit each other. It begins as the odometry's."""


class JoinedScans:
    """The newest scans, oldest first.

    Odometry alone blurs a window of scans, because it measures turns to some degrees only. Neighbouring scans
    see the same surfaces, and tell the step between them to centimetres.
    """

    def __init__(self, scans_max: int) -> None:
        self._scans_max = scans_max
        self.scans: list[JoinedScan] = []

    def clear(self) -> None:
        """Forget all scans."""
        self.scans = []

    def add(self, scan: PlanarScan, base_in_odom: np.ndarray) -> None:
        """Take in the next scan, with continuous odometry (3,)."""
        base_in_odom = np.asarray(base_in_odom, float)
        base = base_in_odom
        if self.scans:
            last = self.scans[-1]
            step = se2.between(last.base_in_odom, base_in_odom)
            base = self._aligned(scan, se2.compose(last.base, step), step)
        self.scans = [*self.scans[-self._scans_max + 1 :], JoinedScan(scan, base_in_odom, base)]

    def restore(self, scans: Sequence[JoinedScan]) -> None:
        """Go on with saved scans.

        Raises:
            ValueError: their poses make no sense.
        """
        bases = np.array([(each.base_in_odom, each.base) for each in scans])
        if bases.shape[1:] not in ((), (2, 3)) or not np.isfinite(bases).all():
            raise ValueError("the joined scans' poses make no sense")
        self.scans = list(scans)

    def _aligned(self, scan: PlanarScan, predicted: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return a scan's pose (3,) by odometry's prediction and its links with the scans before it."""
        from gridslam.loop_closure.links.scan_pairs import link_pairs
        from gridslam.loop_closure.parameters import LoopClosureParameters
        from gridslam.maps.scan_surfaces import ScanSurfaces, surfaces_of

        p, before = LoopClosureParameters(), self.scans[-LINKS_BACK:]
        surfaces = ScanSurfaces(
            surfaces_of(each, p.link_range_m) for each in (*(s.scan for s in before), scan)
        )
        pairs = np.array([(older, len(before)) for older in range(len(before))])
        starts = predicted + np.array([(0.0, 0.0, turn) for turn in TURNS_RAD])
        begun = np.array([se2.between(older.base, starts) for older in before])
        way_m, turned_rad = np.hypot(*step[:2]), abs(step[2])
        heading = p.odometry_rad_per_sqrt_m**2 * way_m + p.odometry_rad_per_sqrt_rad**2 * turned_rad
        place = p.odometry_m_per_sqrt_m**2 * way_m
        information = np.diag(1.0 / (np.array((place, place, heading)) + LEAST_VARIANCE))
        pull = np.zeros(3)
        for older, edge in zip(before, link_pairs(pairs, surfaces, begun, p, is_pass=True)):
            if edge is not None:
                firmness = np.linalg.inv(edge.covariance)
                information = information + firmness
                off = se2.between(predicted, se2.compose(older.base, edge.newer_in_older))
                pull += firmness @ off
        return se2.compose(predicted, np.linalg.solve(information, pull))
