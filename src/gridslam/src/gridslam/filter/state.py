"""The complete state of a filter, to save it and go on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

import numpy as np

from gridslam.filter.motion_model import Motion
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan


@dataclass(frozen=True)
class FilterState:
    """A filter that is built from this goes on exactly as the original would.

    The arrays are the filter's own, not copies: write them before the next step.
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
    tree: dict[str, np.ndarray]
    """Arrays of `TrajectoryTree`."""
    maps: dict[str, np.ndarray]
    """Arrays of `TileMaps`."""
    pieces: Mapping[str, np.ndarray]
    """Arrays of `Pieces`."""
    motion: Motion | None
    """Odometry since the last processed scan; None: there was no scan yet."""
    before: PlanarScan | None
    """The scan at which the next step begins; None: the next step is not checked."""
    scans: list[PlanarScan] | None
    """The processed scans; None: they are not kept."""
    random: Mapping[str, Any]
    """State of the random generator."""
