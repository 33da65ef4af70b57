"""The map that clouds are matched with: planes in voxels of four sizes."""

from __future__ import annotations

import numpy as np

from gridslam.cloud_odometry.kernels.planes import (
    FLOOR_LEVEL,
    MOMENTS,
    OTHER_SIDE,
    PLANE,
    add_points,
    fit_planes,
    floor_slope,
)
from gridslam.cloud_odometry.kernels.table import EMPTY, HALF, MASK, first_of_each_cube, rehash
from gridslam.cloud_odometry.parameters import CloudOdometryParameters

FIRST_SLOTS = 1 << 16
FULLEST = 0.6
"""Share of the slots that may be in use."""
POINTS_MIN = np.array([8, 10, 12, 16])
"""How many points a plane needs, for each level. Few rings of a lidar cross a coarse voxel far away."""


class PlaneMap:
    """Voxels with planes, in the map's frame.

    Attributes:
        keys: (m,) int64 and planes: (m, 9), see `kernels.planes`. levels_m: (4,) sides of the voxels.
        is_full: whether it takes no more voxels.
    """

    def __init__(self, parameters: CloudOdometryParameters) -> None:
        self._p = parameters
        self.levels_m = np.array(parameters.levels_m)
        self.keys = np.full(FIRST_SLOTS, EMPTY, dtype=np.int64)
        self.planes = np.zeros((FIRST_SLOTS, PLANE))
        self._moments = np.zeros((FIRST_SLOTS, MOMENTS))
        self._voxels = 0
        self.is_full = False

    @property
    def is_empty(self) -> bool:
        """Whether no cloud has been entered."""
        return self._voxels == 0

    def __len__(self) -> int:
        """Return the number of voxels, of all levels."""
        return self._voxels

    @property
    def slopes_late_m(self) -> float:
        """How late a slope is told where it begins, m of way: half of the widest voxel that tells slopes."""
        return 0.5 * float(self.levels_m[FLOOR_LEVEL])

    def slope_at(self, place: np.ndarray, eye: np.ndarray) -> np.ndarray | None:
        """Return (2,) the rise per metre along x and y of the floor at a place (3,), m; None: not known.

        eye: (3,) m, from where it is seen.
        """
        slope = np.empty(2)
        return slope if floor_slope(place, eye, self.levels_m, self.keys, self.planes, slope) else None

    def add(self, points: np.ndarray, origin: np.ndarray) -> None:
        """Enter points (n, 3) that were seen from an origin (3,), m, in the map's frame.

        A full map stays as it is.
        """
        entries_max = len(points) * len(self.levels_m)
        self.is_full = self._voxels + entries_max > self._p.voxels_max
        if self.is_full:
            return
        self.reserve(self._voxels + entries_max)
        changed = np.empty(entries_max, dtype=np.int64)
        entries, new = add_points(
            points,
            origin,
            self.levels_m,
            POINTS_MIN,
            self._p.points_max,
            self.keys,
            self._moments,
            self.planes,
            changed,
        )
        self._voxels += new
        self._fit(np.unique(changed[:entries]), origin)

    def _fit(self, slots: np.ndarray, origin: np.ndarray) -> None:
        keys = self.keys[slots]
        levels = (keys >> 60) % OTHER_SIDE
        places = np.column_stack([((keys >> shift) & MASK) - HALF for shift in (40, 20, 0)])
        middles = (places + 0.5) * self.levels_m[levels][:, None]
        fit_planes(
            slots,
            middles,
            levels,
            self.levels_m,
            self._p.flatness_m,
            self._p.points_per_reading,
            origin,
            self._moments,
            self.planes,
        )

    def reserve(self, voxels: int) -> None:
        """Make room for so many voxels of all levels."""
        slots = len(self.keys)
        while voxels > FULLEST * slots:
            slots *= 2
        if slots == len(self.keys):
            return
        rows = np.hstack((self._moments, self.planes))
        keys, larger = np.full(slots, EMPTY, dtype=np.int64), np.zeros((slots, MOMENTS + PLANE))
        rehash(self.keys, rows, keys, larger)
        self.keys = keys
        self._moments = np.ascontiguousarray(larger[:, :MOMENTS])
        self.planes = np.ascontiguousarray(larger[:, MOMENTS:])


def thinned(points: np.ndarray, side_m: float) -> np.ndarray:
    """Return of points (n, 3) the first one of each cube of this side, in their order."""
    slots = 1 << (max(2 * len(points), 2) - 1).bit_length()
    keys, chosen = np.full(slots, EMPTY, dtype=np.int64), np.empty(len(points), dtype=np.int64)
    return points[chosen[: first_of_each_cube(points, side_m, keys, chosen)]]
