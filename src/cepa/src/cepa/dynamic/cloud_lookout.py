"""What a UAV knows of its surroundings in three dimensions: the cloud, and what earlier clouds have shown."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from cepa.dynamic.lookout import FIELD_CELL_M, FIELD_WINDOW_M, OWN_PLACE_M, RANGE_MARGIN_M, SEEN_FREE_M
from cepa.dynamic.pseudo_3d import (
    Body,
    Cells,
    OwnPlace,
    Plane,
    ends_of,
    place_of,
    see_plane,
    see_ranges,
    shade,
)
from cepa.dynamic.voxel_memory import VoxelMemory
from cepa.kernels.layers import distance_layers, unseen_layers
from cepa.kernels.panorama import free_distances, level, see
from cepa.kernels.rollout import BY_SIGHT
from cepa.motion import Cloud, Motion, Ranging
from cepa.parameters import CepaParameters

LAYERS, LAYER_M = 15, 0.15
HEIGHT_GAIN_S = 1.0
"""The position controller climbs so that it would be at its height after this time. So does this one."""
STAY_SHARE = 0.3
"""Among layers, a metre off the own height counts so much of a metre off the height that is asked for."""
HEIGHT_ERROR_M = 0.05
"""Added to the body below and above, for the odometry and for what a cell of the memory rounds."""
ROW_TAN, ROWS, BINS = 0.005, 324, 720
COARSE_ROWS, COARSE_BINS = 27, 360
"""Rows of 3.4 degrees: no lidar's channels are farther apart, so an empty one in view is free."""
SEEN_CELL_M, SEEN_LEVEL_M, SEEN_WINDOW_M = 0.2, 0.15, 15.0
SEEN_CELL = np.array([SEEN_CELL_M, SEEN_LEVEL_M])
SEEN_CELLS, SEEN_LEVELS = 96, 24
SEEN_REACH_M = np.array([0.5 * SEEN_WINDOW_M + SEEN_CELL_M, 1.5])
BODY_SHARE_SEEN = 0.67
"""So much of the body's height must be in what was seen: cells are seen when their middles are."""
NEAR_M = 1.5
"""Nearer, little is in the field of view. So what was seen there stays as it was."""
MISSES = 3
GREATEST_MOVE_M = 1.0
"""The grids repeat themselves, so that a farther move between two clouds drops the memory."""
BESIDE_M = 0.15
"""A point so near to the rim of what moves belongs to it."""
OWN_REACH_M = 1.0
"""Around the body, for all that the UAV could reach by leaving its own place."""
NO_DISCS, NO_POINTS, NO_PLACE = np.empty((0, 6)), np.empty((0, 3)), np.empty(0)
FEWEST_RETURNS = 10
"""A cloud with fewer points shows nothing: the lidar may be covered."""


class Space(NamedTuple):
    """What is known at a cloud, along the odometry's axes with the lidar at the origin."""

    points: np.ndarray
    """(n, 3) m: seen and remembered."""
    is_hidden: np.ndarray
    """(n,) bool: which of them were not seen just now."""
    distance: np.ndarray
    """(LAYERS, n, n) m: to the nearest obstacle at the height of each layer; overwritten by the next."""
    unseen: np.ndarray
    """(LAYERS, k, k) uint8: 1 where the body would be in what was not seen, or beyond the height's limits;
    2 where only its own place is unseen, in which ``own_reach`` counts."""
    own_reach: np.ndarray
    """(bins,) m: how far the UAV may go in its own place; (0,): there is none."""
    heights_m: np.ndarray
    """(LAYERS,) m: of the layers above the lidar. They are fixed to the odometry's frame, or a path that is
    clear in a plan would not stay clear while it is flown."""
    detours_m: np.ndarray
    """(LAYERS,) m: how far each is from the height that is asked for; inf: out of the height's limits."""
    asked_m: float
    """The height that the reference asks for, above the lidar."""

    @property
    def middle_m(self) -> float:
        """Height of the middle layer above the lidar."""
        return float(self.heights_m[LAYERS // 2])

    def open_height_m(self, direction: np.ndarray, ahead_m: float, keep_m: float) -> float:
        """Return the height, m above the lidar, at which the way straight ahead is open for ``ahead_m``.

        direction: unit vector (2,). keep_m: distance to keep. It is the height that is asked for, if no layer
        is open or that one is. A layer between two that are open, too, is preferred.
        """
        middle = self.distance.shape[1] // 2
        along = np.arange(0.0, ahead_m, FIELD_CELL_M)[:, None] * direction / FIELD_CELL_M
        columns, rows = np.clip(np.rint(along).astype(int) + middle, 0, 2 * middle).T
        is_open = (self.distance[:, rows, columns] >= keep_m).all(axis=1) & np.isfinite(self.detours_m)
        if not is_open.any():
            return self.asked_m
        amid = is_open & np.append(is_open[1:], True) & np.append(True, is_open[:-1])
        cost = self.detours_m + STAY_SHARE * np.abs(self.heights_m)
        best = float(self.heights_m[np.argmin(np.where(amid if amid.any() else is_open, cost, math.inf))])
        return self.asked_m if abs(best - self.asked_m) <= 0.5 * LAYER_M else best


class CloudLookout:
    """Keeps what clouds have shown, fixed to the odometry's frame."""

    def __init__(self, parameters: CepaParameters):
        p = parameters
        self._p = p
        self.far_m = p.r_ub + FIELD_CELL_M
        side = 2 * round(0.5 * FIELD_WINDOW_M / FIELD_CELL_M) + 1
        self._columns = np.empty((side, side), np.uint64)
        self._field = np.empty((LAYERS, side, side))
        seen_side = 2 * round(0.5 * SEEN_WINDOW_M / SEEN_CELL_M) - 1
        self._unseen = np.empty((LAYERS, seen_side, seen_side), np.uint8)
        self._seen_s = np.empty((SEEN_CELLS, SEEN_CELLS, SEEN_LEVELS))
        self._nearest = np.empty((ROWS, BINS), np.float32)
        self._free = np.empty((COARSE_ROWS, COARSE_BINS), np.float32)
        self._levelled = np.empty((0, 3))
        self._memory = VoxelMemory()
        self.reset()

    def reset(self) -> None:
        """Forget what was seen."""
        self._seen_s[:] = -math.inf
        self._memory.reset()
        self._own_place = OwnPlace(OWN_PLACE_M)
        self._position_m = (math.nan, math.nan, math.nan)

    def take_over(self, earlier: CloudLookout) -> None:
        """Take over what one with other parameters remembers; it must not be used any longer."""
        self._seen_s, self._memory = earlier._seen_s, earlier._memory
        self._position_m, self._own_place = earlier._position_m, earlier._own_place

    @property
    def kept_m(self) -> float | None:
        """What was farther than this was forgotten at the newest look for want of room, m; None: nothing."""
        return self._memory.kept_m

    def look(
        self,
        cloud: Cloud | None,
        motion: Motion,
        discs: np.ndarray = NO_DISCS,
        plane: Plane | None = None,
        rangings: Sequence[Ranging] = (),
        beam_ends: np.ndarray = NO_POINTS,
    ) -> Space:
        """Return what is known with this cloud; None: no cloud came.

        discs: what moves (k, 6), m; what the cloud shows of it is not remembered. plane: what a planar scan
        shows, for a cloud that does not look all around, or for none. rangings: of range finders. beam_ends:
        of a planar scan (n, 3), m; obstacles that count whatever the cloud shows.
        """
        if math.dist(motion.position_m, self._position_m) > GREATEST_MOVE_M:
            self.reset()
        self._position_m = motion.position_m
        origin, stamp_s = np.array(motion.position_m), motion.stamp_s
        oldest_s = stamp_s - self._p.memory_s
        p = self._p
        returns = self._picture(cloud, motion)
        if len(beam_ends):
            returns = np.concatenate((returns, beam_ends))
        if rangings:
            returns = np.concatenate((returns, ends_of(rangings, motion, p.body_below, p.body_above)))
        for x, y, _, _, radius, _ in discs:
            returns = returns[np.hypot(returns[:, 0] - x, returns[:, 1] - y) > radius + BESIDE_M]
        picture = self._nearest, ROW_TAN, SEEN_FREE_M, NEAR_M, MISSES
        points, is_hidden = self._memory.update(returns, origin, stamp_s, oldest_s, picture)
        middle_m = LAYER_M * round(origin[2] / LAYER_M)
        heights_m = middle_m - origin[2] + LAYER_M * (np.arange(LAYERS) - LAYERS // 2)
        self._see(origin, stamp_s, oldest_s, knows_own_place=plane is None)
        body = Body(
            p.body_radius,
            BODY_SHARE_SEEN * p.body_below,
            BODY_SHARE_SEEN * p.body_above,
            middle_m - origin[2],
        )
        self._see_by_plane_and_ranges(plane, rangings, motion, body)
        origin[2] = middle_m
        asked_m = HEIGHT_GAIN_S * motion.climb_ref_m_s
        z = heights_m + motion.position_m[2]
        allowed = (self._p.height_min <= z) & (z <= self._p.height_max)
        detours_m = np.where(allowed, np.abs(heights_m - asked_m), math.inf)
        distance = self._distances(points, heights_m)
        unseen, own_reach = self._unseen_since(oldest_s, origin), NO_PLACE
        if plane is not None:
            own_reach = self._open_own_place(motion, body, oldest_s, origin)
            shade(distance, plane, points, unseen, FIELD_CELL_M, SEEN_CELL_M / FIELD_CELL_M, self.far_m)
        return Space(points, is_hidden, distance, unseen, own_reach, heights_m, detours_m, asked_m)

    def _picture(self, cloud: Cloud | None, motion: Motion) -> np.ndarray:
        """Fill the pictures of what is near and what is free; return the cloud's returns (n, 3), levelled."""
        if cloud is None:
            self._nearest[:] = math.inf
            self._free[:] = 0.0
            return self._levelled[:0]
        if len(self._levelled) < len(cloud.points_m):
            self._levelled = np.empty((len(cloud.points_m), 3))
        rotation, limits = motion.rotation(), (cloud.range_min_m, cloud.range_max_m)
        points = np.asarray(cloud.points_m, np.float32)
        count = level(points, rotation, *limits, ROW_TAN, self._levelled, self._nearest)
        no_return_m = cloud.range_max_m - RANGE_MARGIN_M if count >= FEWEST_RETURNS else 0.0
        view = cloud.elevation_rad, cloud.azimuth_rad
        free_distances(self._nearest, ROW_TAN, rotation, *view, no_return_m, self._free)
        return self._levelled[:count]

    def _distances(self, points: np.ndarray, heights_m: np.ndarray) -> np.ndarray:
        p, around = self._p, 0.5 * LAYER_M + HEIGHT_ERROR_M
        above_middle = points - (0.0, 0.0, heights_m[LAYERS // 2])
        body = p.body_below + around, p.body_above + around
        distance_layers(above_middle, FIELD_CELL_M, LAYER_M, *body, self.far_m, self._columns, self._field)
        return self._field

    def _see(self, origin: np.ndarray, stamp_s: float, oldest_s: float, knows_own_place: bool) -> None:
        p = self._p
        ends = p.body_below + SEEN_LEVEL_M, p.body_above + SEEN_LEVEL_M
        own = np.array([p.body_radius + OWN_PLACE_M if knows_own_place else 0.0, *ends])
        row_tan, when = ROW_TAN * (ROWS // COARSE_ROWS), (stamp_s, oldest_s)
        see(self._free, row_tan, origin, *when, SEEN_CELL, SEEN_REACH_M, own, NEAR_M, self._seen_s)

    def _see_by_plane_and_ranges(
        self, plane: Plane | None, rangings: Sequence[Ranging], motion: Motion, body: Body
    ) -> None:
        cells = Cells(self._seen_s, SEEN_CELL_M, SEEN_LEVEL_M)
        if plane is not None:
            see_plane(cells, plane, motion, body)
        see_ranges(cells, rangings, motion, body, body.radius + OWN_PLACE_M)

    def _open_own_place(self, motion: Motion, body: Body, oldest_s: float, origin: np.ndarray) -> np.ndarray:
        """Mark where only the own place is unseen; return how far it reaches in equal directions, m."""
        unseen, middle = self._unseen.copy(), self._unseen.shape[1] // 2
        is_seen = not unseen[LAYERS // 2, middle, middle]
        cells = Cells(self._seen_s, SEEN_CELL_M, SEEN_LEVEL_M)
        place = place_of(body, body.radius + OWN_REACH_M, cells, motion)
        seen_s = self._seen_s[place]
        self._seen_s[place] = motion.stamp_s  # for the next line only: nobody has seen it
        is_own = unseen > self._unseen_since(oldest_s, origin)
        self._seen_s[place] = seen_s
        np.copyto(self._unseen, unseen)
        self._unseen[is_own] = BY_SIGHT
        return self._own_place.follow(origin[:2].copy(), is_seen)

    def _unseen_since(self, oldest_s: float, origin: np.ndarray) -> np.ndarray:
        p = self._p
        body = np.array([p.body_radius, BODY_SHARE_SEEN * p.body_below, BODY_SHARE_SEEN * p.body_above])
        heights = np.array([p.height_min, p.height_max])
        unseen_layers(self._seen_s, origin, oldest_s, SEEN_CELL, LAYER_M, body, heights, self._unseen)
        return self._unseen
