"""The map side of the filter: the particles' maps, the earlier map, and the scans to make a map anew."""

from __future__ import annotations

import numpy as np

from gridslam.errors import StateError
from gridslam.filter.kept.earlier_map import MapPieces
from gridslam.filter.kept.kept_scans import KeptScans
from gridslam.filter.kept.known_places import known_node
from gridslam.filter.state import FilterState
from gridslam.maps.new_map import ALL_HEIGHTS, Band, MapDraft, new_maps
from gridslam.maps.newest_scans import NewestScans, placed
from gridslam.maps.rendering import Renderer
from gridslam.maps.tile_map import TileMaps
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan


class SlamMap:
    """What is mapped along the particles' paths. A node is a processed scan.

    Args:
        parameters: of the filter.
        starting_map: the map begins with this; None: empty.
        is_fixed: the map stays as it is.
        keep_scans: keep every processed scan, which `adopt` needs.
    """

    def __init__(
        self,
        parameters: SlamParameters,
        starting_map: OccupancyGrid | None,
        is_fixed: bool,
        keep_scans: bool,
    ) -> None:
        self._parameters, self.starting_map, self.is_fixed = parameters, starting_map, is_fixed
        self._kept = KeptScans() if keep_scans else None
        self.newest = NewestScans()
        """Of known places."""
        self._renderer = Renderer(parameters)
        self.pieces = MapPieces()
        """Which scans are in which map."""
        self.tiles = new_maps(starting_map, parameters.particles, parameters.delta)
        """Of the particles."""
        self.band = ALL_HEIGHTS
        """Of the heights whose scans are in the map."""

    @property
    def has_kept_scans(self) -> bool:
        """Whether every processed scan is kept."""
        return self._kept is not None

    @property
    def kept(self) -> KeptScans:
        """The processed scans; raises StateError if they were not kept."""
        if self._kept is None:
            raise StateError("The scans were not kept: construct GridSlam with keep_scans=True.")
        return self._kept

    @property
    def scans_in_map(self) -> list[PlanarScan | None]:
        """Each processed scan that enters the map of the present heights; None: it does not."""
        return self.kept.in_band(*self.band)

    def change_band(self, band: Band, poses: np.ndarray) -> None:
        """Go on with the map of other heights: of the scans there, along the path (k, 3) of all particles."""
        self.band = band
        self.adopt(poses, None)

    def add_node(self, scan: PlanarScan, base_in_odom: np.ndarray) -> None:
        """Keep a processed scan, if they are kept. `tiles` get it otherwise."""
        if self._kept is not None:
            self._kept.add(scan, base_in_odom)

    def add_known(self, anchor: int, base_in_anchor: np.ndarray, scan: PlanarScan) -> None:
        """Keep a scan of a known place for a while: beside a node, where the base was (3,) in its frame."""
        self.newest.add(anchor, base_in_anchor, scan.sharing(self.kept.scans[-1]))

    def known_node(self, path: np.ndarray, pose: np.ndarray, scan: PlanarScan) -> int | None:
        """Return the node of a place that enough passes have mapped; None: a scan there is to be kept.

        Args:
            path: (k, 3) of all nodes.
            pose: (3,) of the base at the scan.
            scan: its height counts.
        """
        if self._kept is None or self.is_fixed or self.pieces.earlier is not None:
            return None
        height_m, usable = scan.height_m + self._kept.rise_m, self.pieces.is_usable(len(path))
        return known_node(path, self._kept.heights_m, usable, pose, height_m)

    def grid(self, particle: int, nodes: int) -> OccupancyGrid:
        """Return a particle's map, or the earlier one if that holds more of the nodes. It is read-only."""
        earlier = self.pieces.earlier
        if earlier is not None and earlier.scans >= nodes - self.pieces.first_in_map:
            return earlier.grid()
        return self._renderer.render(self.tiles, particle)

    def replace(self, tiles: TileMaps) -> None:
        """Take other maps for all particles."""
        self.tiles, self._renderer = tiles, Renderer(self._parameters)

    def drop(self) -> None:
        """Drop the maps, before others are drawn: so there is memory for one of both only."""
        self.replace(new_maps(None, self._parameters.particles, self._parameters.delta))

    def begin_anew(self, nodes: int) -> None:
        """Begin an empty map after so many nodes. The present ones, all alike, become the earlier map."""
        self.pieces.begin(self.tiles, self._parameters, nodes)
        self.band = ALL_HEIGHTS
        self._leave_out()
        self.drop()

    def drop_own(self, nodes: int) -> None:
        """Go on with the earlier map after so many nodes. What was mapped since is lost."""
        self.replace(self.pieces.leave_own(nodes))

    def adopt(self, poses: np.ndarray, draft: MapDraft | None) -> None:
        """Give all particles a map of the scans along a corrected path (k, 3).

        Args:
            poses: of all nodes.
            draft: a map that holds the first of the scans at these poses; None: an empty one. If there is an
                earlier map, and the draft holds its scans, both are one then.

        Raises:
            StateError: the scans were not kept, or the poses are not one finite pose for each of them.
        """
        scans, parameters = self.scans_in_map, self._parameters
        if poses.shape != (len(scans), 3) or not np.isfinite(poses).all():
            raise StateError(f"The corrected trajectory must be {len(scans)} finite poses x, y, yaw.")
        if draft is None or not draft.band.is_same(self.band):  # it was begun at other heights
            first = 0 if draft is None else draft.first
            draft = MapDraft(parameters, self.starting_map, first, self.band)
        if not self.is_fixed:
            is_empty = draft.scans == draft.first  # else it has them already
            draft.add(poses[draft.scans :], scans[draft.scans :])
            if is_empty:
                usable = self.pieces.is_usable(len(poses)) & (np.arange(len(poses)) >= draft.first)
                draft.add_beside(*placed(self.newest.all(), poses, usable, draft.band))
        draft.maps.resample(np.zeros(parameters.particles, int))
        self.replace(draft.maps)
        if draft.first == 0:
            self.pieces.join()

    def restore(self, state: FilterState) -> None:
        """Go on from a filter's state.

        Raises:
            ValueError: it contradicts itself.
        """
        self.tiles.restore(state.maps)
        self.band = state.band
        self.pieces.restore(state.pieces, state.parameters, len(state.tree.stamps_s))
        if self._kept is not None and state.scans is not None and state.odometry is not None:
            self._kept.restore(state.scans, state.odometry, state.in_space)
            self.newest.restore(state.newest_scans, len(state.scans))
        self._leave_out()

    def _leave_out(self) -> None:
        """Let the scans that are in no map enter none."""
        if self._kept is not None:
            self._kept.leave_out(self.pieces.left_out)
