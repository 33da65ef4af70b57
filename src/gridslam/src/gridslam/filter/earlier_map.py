"""The map before the vehicle was lost in vain, kept beside the one that is made since."""

from __future__ import annotations

from typing import Mapping, NamedTuple

import numpy as np

from gridslam.maps.beams import Beams
from gridslam.maps.rendering import Renderer
from gridslam.maps.tile_map import TileMaps
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan
from gridslam.tracking.evidence import Agreement


class EarlierMap:
    """A map that stays as it is. `Relocaliser` looks for the vehicle on it.

    Args:
        maps: all particles have the same one.
        parameters: the filter's.
        scans: number of scans in the map.
    """

    def __init__(self, maps: TileMaps, parameters: SlamParameters, scans: int) -> None:
        self.maps, self.scans = maps, scans
        self._parameters, self._renderer = parameters, Renderer(parameters)

    def grid(self) -> OccupancyGrid:
        """Return the map; its cells are read-only."""
        return self._renderer.render(self.maps, 0)

    def agreement(self, scan: PlanarScan, pose: np.ndarray) -> Agreement:
        """Compare a scan, taken at a pose of the base in the map, with the map."""
        beams = Beams.from_scan(scan, self._parameters)
        return self.maps.agreement(0, np.asarray(pose, float), beams)

    def surface_points(self, scan: PlanarScan) -> np.ndarray:
        """Return the ends (n, 2) of the beams that hit something, thinned, m, in the base frame."""
        return Beams.from_scan(scan, self._parameters).matching[:, :2] * self._parameters.delta


class Usable(NamedTuple):
    """Which scans of a path may be recognised."""

    begun: int
    """See `Pieces`."""
    is_usable: np.ndarray
    """(k,) bool: whether a scan is in the present map or in the earlier one."""


class Pieces:
    """Which scans of a path are in the present map, which in the earlier one, and which in none."""

    def __init__(self) -> None:
        self.begun = 0
        """Number of scans before the present map began; 0: it holds all."""
        self.earlier: EarlierMap | None = None
        """None: there is one map."""
        self.left_out: list[tuple[int, int]] = []
        """Ranges (first, after last) of scans that are in neither map."""

    def snapshot(self, count: int) -> Usable:
        """Return which of so many scans may be recognised."""
        is_usable = np.ones(count, dtype=bool)
        for first, last in self.left_out:
            is_usable[first:last] = False
        return Usable(self.begun, is_usable)

    def begin(self, maps: TileMaps, parameters: SlamParameters, count: int) -> None:
        """Note that a new map begins after so many scans. Of the two before it, the larger one stays.

        ``maps``: the present ones, all alike.
        """
        own = count - self.begun
        if self.earlier is not None and self.earlier.scans >= own:
            self.left_out.append((self.begun, count))
        else:
            if self.earlier is not None:
                self.left_out = [(0, self.begun)]
            self.earlier = EarlierMap(maps, parameters, own)
        self.begun = count

    def leave_own(self, count: int) -> TileMaps:
        """Drop the present map. Return the earlier one, which takes its place."""
        earlier = self.earlier
        assert earlier is not None
        self.left_out.append((self.begun, count))
        self.join()
        return earlier.maps

    def join(self) -> None:
        """Note that both maps are one."""
        self.begun, self.earlier = 0, None

    def to_arrays(self) -> dict[str, np.ndarray]:
        """Return the input of `restore`."""
        found = {
            "begun": np.array([self.begun, 0 if self.earlier is None else self.earlier.scans]),
            "left_out": np.array(self.left_out, int).reshape(-1, 2),
        }
        return found if self.earlier is None else {**found, **self.earlier.maps.to_arrays()}

    def restore(self, arrays: Mapping[str, np.ndarray], parameters: SlamParameters, count: int) -> None:
        """Go on from the output of `to_arrays`, with a path of so many scans.

        Raises:
            KeyError, ValueError: it makes no sense.
        """
        begun, scans = (int(number) for number in arrays["begun"])
        left_out = [(int(first), int(last)) for first, last in arrays["left_out"].reshape(-1, 2)]
        limits = [0, begun, count] + [end for ends in left_out for end in ends]
        if min(limits) < 0 or max(limits) > count or not 0 <= scans <= begun:
            raise ValueError("the maps' pieces of the path are none")
        self.begun, self.left_out = begun, left_out
        if begun:
            maps = TileMaps(parameters.particles, parameters.delta)
            maps.restore(dict(arrays))
            self.earlier = EarlierMap(maps, parameters, scans)
