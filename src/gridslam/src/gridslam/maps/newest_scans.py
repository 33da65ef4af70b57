"""The newest scans of known places. No node keeps them, but a map that is drawn anew gets them."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.maps.new_map import Band
from gridslam.scan import PlanarScan

STORED = 3
"""So many scans of each node's place are kept."""
TIMES = 3
"""Each enters the map so many times: five passes or more have mapped the place before, and what was seen
there last is what is there now. What moves is in another cell with each scan, and does not show."""


@dataclass(frozen=True, eq=False)
class NewestScan:
    """A scan in a known place."""

    anchor: int
    """The node of its place."""
    base_in_anchor: np.ndarray
    """(3,) where it was taken: x, y in m and yaw in rad."""
    scan: PlanarScan


class NewestScans:
    """Of each known place. Memory does not grow with the number of passes."""

    def __init__(self) -> None:
        self._of: dict[int, deque[NewestScan]] = {}

    def add(self, anchor: int, base_in_anchor: np.ndarray, scan: PlanarScan) -> None:
        """Keep a scan at a node's place. The oldest one of that place is dropped."""
        self._of.setdefault(anchor, deque(maxlen=STORED)).append(NewestScan(anchor, base_in_anchor, scan))

    def all(self) -> tuple[NewestScan, ...]:
        """Return those of all places. The last ones of a place are newer."""
        return tuple(each for of_place in self._of.values() for each in of_place)

    def restore(self, scans: Sequence[NewestScan], nodes: int) -> None:
        """Go on from saved ones, on a path of so many nodes.

        Raises:
            ValueError: they make no sense.
        """
        self._of = {}
        for each in scans:
            pose = each.base_in_anchor
            if not 0 <= each.anchor < nodes or pose.shape != (3,) or not np.isfinite(pose).all():
                raise ValueError("the newest scans of known places are at nodes that are not there")
            self._of.setdefault(each.anchor, deque(maxlen=STORED)).append(each)


def placed(
    scans: Sequence[NewestScan], path: np.ndarray, usable: np.ndarray, band: Band
) -> tuple[np.ndarray, list[PlanarScan]]:
    """Return the poses (n, 3) at which scans enter a map of a path, and these scans.

    Each is there TIMES times.

    Args:
        scans: of known places.
        path: (k, 3) of all nodes.
        usable: (k,) bool: whether a node is in the map.
        band: of the heights whose scans are in the map.
    """
    poses, entered = [], []
    for each in scans:
        is_apart = abs(each.scan.height_m - band.middle_m) > band.half_m  # NaN is in every band
        if each.anchor < len(path) and usable[each.anchor] and not is_apart:
            poses += [se2.compose(path[each.anchor], each.base_in_anchor)] * TIMES
            entered += [each.scan] * TIMES
    return np.reshape(poses, (-1, 3)), entered
