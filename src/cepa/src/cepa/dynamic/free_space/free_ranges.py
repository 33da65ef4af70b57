"""How far a scan sees free in each direction, and where its beams end."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from cepa.dynamic.constants.free_space import LEVEL_RANGE_M, RANGE_BINS, RANGE_MARGIN_M, SHOWN_HEIGHT_M
from cepa.dynamic.free_space.kernels.beams import directions_of, points_of
from cepa.dynamic.free_space.kernels.ranges import bins_of
from cepa.motion import Motion, Quaternion, rotation_matrix
from cepa.scan import Beams

ANGLES_RAD = 2.0 * math.pi / RANGE_BINS * np.arange(RANGE_BINS)
DIRECTIONS = np.stack((np.cos(ANGLES_RAD), np.sin(ANGLES_RAD)))


def falls(rotation: np.ndarray) -> np.ndarray:
    """Return by how much (RANGE_BINS,) beams fall for each metre in the plane.

    rotation (3, 3): of the lidar's frame into the odometry's.
    """
    return slope_of(rotation) @ DIRECTIONS


def slope_of(rotation: np.ndarray) -> np.ndarray:
    """Return by how much (2,) a lidar's plane falls for each metre along x and y. rotation: as in `falls`."""
    slope: np.ndarray = rotation[:2, 2] / rotation[2, 2]
    return slope


class FreeRanges:
    """How far a scan sees free in RANGE_BINS equal directions; worked out when it is first asked for."""

    def __init__(self, beams: Beams, orientation_xyzw: Quaternion, range_max: float):
        """Of the lidar: ``orientation_xyzw`` of the lidar's frame in the odometry's."""
        self._beams, self._orientation, self._range_max = beams, orientation_xyzw, range_max

    @cached_property
    def _rotation(self) -> np.ndarray:
        return rotation_matrix(self._orientation)

    @cached_property
    def free_m(self) -> np.ndarray:
        """(RANGE_BINS,) m: how far each direction is seen free; -1 where no beam looks."""
        beams, free_m = self._beams, np.empty(RANGE_BINS)
        geometry = beams.ranges, beams.seen, beams.angle_0, beams.increment, self._rotation
        bins_of(*geometry, self._range_max - RANGE_MARGIN_M, free_m)
        return free_m

    @cached_property
    def slope(self) -> np.ndarray:
        """(2,): by how much the lidar's plane falls for each metre along x and y."""
        return slope_of(self._rotation)

    @cached_property
    def _falls(self) -> np.ndarray:
        return falls(self._rotation)

    @cached_property
    def level_m(self) -> np.ndarray:
        """(RANGE_BINS,) m: how far its beams stay within LEVEL_RANGE_M of the lidar's height."""
        return LEVEL_RANGE_M / np.maximum(np.abs(self._falls), 1e-6)

    @cached_property
    def shown_m(self) -> np.ndarray:
        """(RANGE_BINS,) m: how far it shows that nothing stands there; -1 where no beam looks.

        What stands on the floor ends every beam that comes down to it.
        """
        return np.minimum(self.free_m, SHOWN_HEIGHT_M / np.maximum(-self._falls, 1e-6))


class BeamEnds:
    """Turns scans into points along the odometry's axes. The next scan overwrites the points."""

    def __init__(self) -> None:
        self._points = np.empty((0, 3))
        self._geometry, self._directions = (0, 0.0, 0.0), np.empty((0, 2))

    def of(self, beams: Beams, motion: Motion, range_max: float) -> tuple[np.ndarray, FreeRanges]:
        """Return the ends of the beams that hit something (n, 3), m, and how far each direction is free."""
        geometry = beams.ranges.size, beams.angle_0, beams.increment
        if geometry != self._geometry:
            self._geometry, self._directions = geometry, np.empty((beams.ranges.size, 2))
            directions_of(beams.angle_0, beams.increment, self._directions)
            self._points = np.empty((beams.ranges.size, 3))
        orientation = motion.orientation_xyzw
        free = FreeRanges(beams, orientation, range_max)
        if beams.nearest >= range_max:
            return self._points[:0], free
        scan = beams.ranges, beams.seen, self._directions
        found = points_of(*scan, *orientation, range_max, self._points)
        return self._points[:found], free
