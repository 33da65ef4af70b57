"""The map before the vehicle was lost in vain, kept beside the one that is made since."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gridslam.maps.beams import Beams
from gridslam.maps.rendering import Renderer
from gridslam.maps.tile_map import MapsState, TileMaps
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


@dataclass(frozen=True, eq=False)
class PiecesState:
    """`MapPieces` to save."""

    first_in_map: int
    left_out: tuple[tuple[int, int], ...]
    earlier_scans: int
    earlier_maps: MapsState | None


class MapPieces:
    """Which scans of a path are in the present map, which in the earlier one, and which in none."""

    def __init__(self) -> None:
        self.first_in_map = 0
        """Number of scans before the present map began; 0: it holds all."""
        self.earlier: EarlierMap | None = None
        """None: there is one map."""
        self.left_out: list[tuple[int, int]] = []
        """Ranges (first, after last) of scans that are in neither map."""

    def is_usable(self, count: int) -> np.ndarray:
        """Return which of so many scans (count,) are in the present map or in the earlier one."""
        found = np.ones(count, dtype=bool)
        for first, last in self.left_out:
            found[first:last] = False
        return found

    def begin(self, maps: TileMaps, parameters: SlamParameters, count: int) -> None:
        """Note that a new map begins after so many scans. Of the two before it, the larger one stays.

        ``maps``: the present ones, all alike.
        """
        own = count - self.first_in_map
        if self.earlier is not None and self.earlier.scans >= own:
            self.left_out.append((self.first_in_map, count))
        else:
            if self.earlier is not None:
                self.left_out = [(0, self.first_in_map)]
            self.earlier = EarlierMap(maps, parameters, own)
        self.first_in_map = count

    def leave_own(self, count: int) -> TileMaps:
        """Drop the present map. Return the earlier one, which takes its place."""
        earlier = self.earlier
        assert earlier is not None
        self.left_out.append((self.first_in_map, count))
        self.join()
        return earlier.maps

    def join(self) -> None:
        """Note that both maps are one."""
        self.first_in_map, self.earlier = 0, None

    def state(self) -> PiecesState:
        """Return what is known of the pieces, with the earlier map."""
        earlier = self.earlier
        return PiecesState(
            self.first_in_map,
            tuple(self.left_out),
            0 if earlier is None else earlier.scans,
            None if earlier is None else earlier.maps.state(),
        )

    def restore(self, state: PiecesState, parameters: SlamParameters, count: int) -> None:
        """Go on from a state, with a path of so many scans.

        Raises:
            ValueError: it makes no sense.
        """
        limits = [0, state.first_in_map, count] + [end for ends in state.left_out for end in ends]
        has_earlier = state.earlier_maps is not None
        if min(limits) < 0 or max(limits) > count or has_earlier != (state.first_in_map > 0):
            raise ValueError("the maps' pieces of the path are none")
        if not 0 <= state.earlier_scans <= state.first_in_map:
            raise ValueError("the earlier map holds more scans than there were")
        self.first_in_map, self.left_out = state.first_in_map, list(state.left_out)
        if state.earlier_maps is not None:
            maps = TileMaps(parameters.particles, parameters.delta)
            maps.restore(state.earlier_maps)
            self.earlier = EarlierMap(maps, parameters, state.earlier_scans)
