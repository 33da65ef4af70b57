"""The names that `from gridslam import ...` knows."""

from gridslam.errors import MapError, ParameterError, PoseError, ScanError, SlamError, StateError
from gridslam.filter.grid_slam import GridSlam
from gridslam.filter.scan_update import ScanUpdate
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan

__all__ = [
    "GridSlam",
    "MapError",
    "OccupancyGrid",
    "ParameterError",
    "PlanarScan",
    "PoseError",
    "ScanError",
    "ScanUpdate",
    "SlamError",
    "SlamParameters",
    "StateError",
]
