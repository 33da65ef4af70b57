"""The complete state of a filter, to save it and go on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

import numpy as np

from gridslam.filter.kept.earlier_map import PiecesState
from gridslam.filter.kept.kept_scans import InSpace
from gridslam.filter.motion_model import MotionState
from gridslam.maps.new_map import Band
from gridslam.maps.newest_scans import NewestScan
from gridslam.maps.tile_map import MapsState
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan
from gridslam.trajectory import TreeState


@dataclass(frozen=True)
class FilterState:
    """A filter that is built from this goes on exactly as the original would.

    The arrays are the filter's own, not copies: write them before the next step.

    Raises:
        ValueError: they contradict each other.
    """

    parameters: SlamParameters
    starting_map: OccupancyGrid | None
    localisation_only: bool
    poses: np.ndarray
    """(particles, 3) x, y in m and yaw in rad, in the map, at the last processed scan."""
    log_weights: np.ndarray
    """(particles,) since the last resampling."""
    log_likelihoods: np.ndarray
    """(particles,) of each particle's whole path, by scans and odometry."""
    tree: TreeState
    """The particles' paths."""
    maps: MapsState
    pieces: PiecesState
    band: Band
    """Heights whose scans are in the maps."""
    motion: MotionState | None
    """Odometry since the last processed scan; None: there was no scan yet."""
    before: PlanarScan | None
    """The scan at which the next step begins; None: the next step is not checked."""
    scans: list[PlanarScan] | None
    """The processed scans; None: they are not kept."""
    odometry: np.ndarray | None
    """(k, 3) at these scans."""
    in_space: list[InSpace]
    """k, of these scans."""
    light_poses: np.ndarray
    """(m, 7) see `LightPoses`."""
    newest_scans: tuple[NewestScan, ...]
    """Of known places."""
    odometry_shift: np.ndarray | None
    """(3,) of the nodes' odometry, by known places; None: there was none."""
    random: Mapping[str, Any]
    """State of the random generator."""

    def __post_init__(self) -> None:
        count = self.parameters.particles
        shapes = {"poses": (count, 3), "log_weights": (count,), "log_likelihoods": (count,)}
        for name, shape in shapes.items():
            array = getattr(self, name)
            if array.shape != shape or not np.isfinite(array).all():
                raise ValueError(f"{name} do not fit {count} particles")
        if self.tree.leaves.shape != (count,):
            raise ValueError(f"the paths do not fit {count} particles")
        shift = self.odometry_shift
        if shift is not None and (shift.shape != (3,) or not np.isfinite(shift).all()):
            raise ValueError("the shift of odometry is no pose")
        nodes = len(self.tree.stamps_s)
        odometry = np.zeros((0, 3)) if self.odometry is None else self.odometry
        if self.scans is not None and (len(self.scans) != nodes or odometry.shape != (nodes, 3)):
            raise ValueError("there are not as many scans as stamps")
        rises_m = [each.rise_m for each in self.in_space]
        if len(rises_m) != len(self.scans or ()) or not np.isfinite(rises_m).all():
            raise ValueError("what is known in space is not of these scans")
