"""What clouds, planar scans and range finders have shown in three dimensions."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from cepa.dynamic.constants.cost_to_go import HEIGHT_GAIN_S, STAY_SHARE, WITHIN_LAYER
from cepa.dynamic.constants.distance_fields import LAYERS
from cepa.dynamic.constants.free_space import NEAR_M, PICTURE_ROW_TAN
from cepa.dynamic.constants.obstacle_tracks import BESIDE_DISC_M, LONG_M, STOOD_NEW_SHARE
from cepa.dynamic.constants.remembered import GREATEST_MOVE_M, SEEN_PAST_M, SEEN_THROUGH_CLOUDS
from cepa.dynamic.free_space.cloud_picture import CloudPicture
from cepa.dynamic.free_space.planar_sensors import LidarPlane
from cepa.dynamic.free_space.seen_cells import SeenCells
from cepa.dynamic.free_space.slab import HaveStood
from cepa.dynamic.obstacle_tracks.falling import Falling
from cepa.dynamic.remembered.field_grid import FieldGrid
from cepa.dynamic.remembered.kernels.voxels import outside
from cepa.dynamic.remembered.layered_field import LayeredField
from cepa.dynamic.remembered.voxel_memory import VoxelMemory
from cepa.motion import Cloud, Motion, Ranging
from cepa.parameters import CepaParameters

NO_MOVERS, NO_POINTS, NO_PLACE = np.empty((0, 6)), np.empty((0, 3)), np.empty(0)


class RecalledSpace(NamedTuple):
    """What is known at a scan, along the odometry's axes with the lidar at the origin."""

    points: np.ndarray
    """(n, 3) m: seen and remembered."""
    is_hidden: np.ndarray
    """(n,) bool: which of them were not seen just now."""
    distance: np.ndarray
    """(LAYERS, n, n) m: to the nearest obstacle at the height of each layer; overwritten by the next."""
    unseen: np.ndarray
    """(LAYERS, k, k) uint8: 1 where the body would be in what was not seen, or beyond the height's limits;
    2 where only its own place is unseen, in which ``own_reach_m`` counts."""
    own_reach_m: np.ndarray
    """(bins,) m: how far the UAV may go in its own place; (0,): there is none."""
    heights_m: np.ndarray
    """(LAYERS,) m: of the layers above the lidar. They are fixed to the odometry's frame, or a path that is
    clear in a plan would not stay clear while it is flown."""
    detours_m: np.ndarray
    """(LAYERS,) m: how far each is from the height that is asked for; inf: out of the height's limits."""
    asked_m: float
    """The height that the reference asks for, above the lidar."""
    grid: FieldGrid
    """Of ``distance``."""

    @property
    def middle_m(self) -> float:
        """Height of the middle layer above the lidar."""
        return float(self.heights_m[LAYERS // 2])

    @property
    def here_m(self) -> float:
        """Distance from the UAV's place to what stands."""
        _, rows, columns = self.distance.shape
        return float(self.distance[LAYERS // 2, rows // 2, columns // 2])

    def open_height_m(self, direction: np.ndarray, ahead_m: float, keep_m: float) -> float:
        """Return the height, m above the lidar, at which the way straight ahead is open for ``ahead_m``.

        direction: unit vector (2,). keep_m: distance to keep. It is the height that is asked for, if no layer
        is open or that one is. A layer between two that are open, too, is preferred.
        """
        middle = self.distance.shape[1] // 2
        cell_m = self.grid.cell_m
        along = np.arange(0.0, max(ahead_m, cell_m), cell_m)[:, None] * direction / cell_m
        columns, rows = np.clip(np.rint(along).astype(int) + middle, 0, 2 * middle).T
        is_open = (self.distance[:, rows, columns] >= keep_m).all(axis=1) & np.isfinite(self.detours_m)
        if not is_open.any():
            return self.asked_m
        amid = is_open & np.append(is_open[1:], True) & np.append(True, is_open[:-1])
        choice = amid if amid.any() else is_open
        asked = int(np.argmin(self.detours_m))
        low_m, high_m = float(self.heights_m[0]), float(self.heights_m[-1])
        within_m = min(max(self.asked_m, low_m), high_m)  # the outermost layer stands for all beyond it
        if choice[asked] and abs(self.heights_m[asked] - within_m) <= 0.5 * self.grid.layer_m + 1e-6:
            return self.asked_m
        cost = self.detours_m + STAY_SHARE * np.abs(self.heights_m)
        best = float(self.heights_m[np.argmin(np.where(choice, cost, math.inf))])
        if abs(best - within_m) <= 0.5 * self.grid.layer_m:
            return self.asked_m
        if not self.grid.is_fine:
            return best
        within_layer_m = WITHIN_LAYER * self.grid.layer_m
        return best + min(max(self.asked_m - best, -within_layer_m), within_layer_m)


class SpaceMemory:
    """Keeps what was shown, fixed to the odometry's frame."""

    def __init__(self, parameters: CepaParameters):
        self._p = parameters
        self._points, self._picture = VoxelMemory(), CloudPicture()
        self._seen, self._field = SeenCells(parameters), LayeredField(parameters)
        self._falling = Falling(parameters.body_above)
        self.reset()

    def reset(self) -> None:
        """Forget what was seen."""
        self._seen.reset()
        self._points.reset()
        self._falling.reset()
        self._position_m = (math.nan, math.nan, math.nan)

    def take_over(self, earlier: SpaceMemory) -> None:
        """Take over what one with other parameters remembers; it must not be used any longer."""
        self._seen.take_over(earlier._seen)
        self._points, self._position_m = earlier._points, earlier._position_m
        self._falling = earlier._falling

    @property
    def kept_m(self) -> float | None:
        """What was farther than this was forgotten at the newest scan for want of room, m; None: nothing."""
        return self._points.kept_m

    @property
    def far_m(self) -> float:
        """The greatest distance in the field."""
        return self._field.far_m

    def take_in(
        self,
        cloud: Cloud | None,
        motion: Motion,
        movers: np.ndarray = NO_MOVERS,
        plane: LidarPlane | None = None,
        rangings: Sequence[Ranging] = (),
        beam_ends: np.ndarray = NO_POINTS,
        is_held: bool = False,
    ) -> RecalledSpace:
        """Take in a cloud, or that none came, and return what is known.

        movers: what moves (k, 6), m; what the cloud shows of it is not remembered. plane: what a planar scan
        shows, for a cloud that does not look all around, or for none. rangings: of range finders. beam_ends:
        of a planar scan (n, 3), m; obstacles that count whatever the cloud shows. is_held: the UAV gets
        nowhere. Then what is near grows old, too: it may have gone where no beam tells.
        """
        if math.dist(motion.position_m, self._position_m) > GREATEST_MOVE_M:
            self.reset()
        self._position_m = motion.position_m
        oldest_s = motion.stamp_s - self._p.memory_s
        origin = np.array(motion.position_m)
        points, is_hidden = self._remember(cloud, motion, oldest_s, movers, rangings, beam_ends, is_held)
        layer_m = self._field.grid.layer_m
        level_m = layer_m * round(origin[2] / layer_m)
        heights_m = level_m - origin[2] + layer_m * (np.arange(LAYERS) - LAYERS // 2)
        middle_m = level_m - origin[2]
        self._seen.take_in_cloud(self._picture.free, motion, oldest_s, has_own_place=plane is None)
        self._seen.take_in_plane_and_ranges(plane, rangings, motion, middle_m)
        origin[2] = level_m
        distance = self._field.of_points(points, heights_m)
        unseen, own_reach_m = self._seen.unseen_since(oldest_s, origin), NO_PLACE
        if plane is not None:
            own_reach_m = self._seen.open_own_place(unseen, motion, middle_m, oldest_s, origin)
            self._field.shade(distance, plane, points, unseen)
        asked_m = HEIGHT_GAIN_S * motion.climb_ref_m_s
        detours_m = self._detours_m(heights_m, motion.position_m[2], asked_m)
        known = points, is_hidden, distance, unseen, own_reach_m, heights_m, detours_m, asked_m
        return RecalledSpace(*known, self._field.grid)

    def columns(self, motion: Motion, counts_signs: bool) -> np.ndarray:
        """Return the discs (k, 8) that something comes down into, as clouds have shown; see `Falling`."""
        return self._falling.columns(motion, counts_signs)

    def forget_over(self, motion: Motion, way: float) -> None:
        """Forget what is over (way 1) or under (-1) the UAV; what stands there is seen again."""
        self._points.forget_over(np.array(motion.position_m), self._p.r_lb, way)

    def have_stood(self, movers: np.ndarray, points: np.ndarray, motion: Motion) -> np.ndarray:
        """Return which of what seems to move (k, 6), m, has stood there, as clouds show (k,).

        points: of the scan (n, 3), m. A box seems to move where the lidar sinks below its top, or leans: then
        the scan meets it at once. Clouds have shown before what stands below.
        """
        origin, stood = np.array(motion.position_m), np.zeros(len(movers), np.bool_)
        for number, (x, y, _, _, radius, _) in enumerate(movers):
            own = points[np.hypot(points[:, 0] - x, points[:, 1] - y) < radius + BESIDE_DISC_M]
            is_old = self._points.have_stood(own, origin, motion.stamp_s)
            new_share = STOOD_NEW_SHARE / max(1.0, radius / LONG_M)
            stood[number] = len(own) > 0 and 1.0 - is_old.mean() < new_share
        return stood

    def has_stood(self, motion: Motion) -> HaveStood:
        """Return what tells at which points, from the UAV, clouds have shown something for long."""
        origin, stamp_s = np.array(motion.position_m), motion.stamp_s
        return lambda points: self._points.have_stood(points, origin, stamp_s)

    def _remember(
        self,
        cloud: Cloud | None,
        motion: Motion,
        oldest_s: float,
        movers: np.ndarray,
        rangings: Sequence[Ranging],
        beam_ends: np.ndarray,
        is_held: bool,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Remember what stands; return all points (m, 3), m, and which of them are older (m,)."""
        p, returns = self._p, self._picture.take_in(cloud, motion)
        if cloud is not None:
            self._falling.take_in(
                returns, self._picture.free, PICTURE_ROW_TAN * self._picture.rows_in_one, motion
            )
        if len(beam_ends):
            returns = np.concatenate((returns, beam_ends))
        if rangings:
            returns = np.concatenate((returns, ends_of(rangings, motion, p.body_below, p.body_above)))
        for x, y, _, _, radius, _ in movers:
            returns = outside(returns, x, y, radius + BESIDE_DISC_M)
        near_m = 0.0 if is_held else NEAR_M
        picture = self._picture.nearest, PICTURE_ROW_TAN, SEEN_PAST_M, near_m, SEEN_THROUGH_CLOUDS
        return self._points.update(returns, np.array(motion.position_m), motion.stamp_s, oldest_s, picture)

    def _detours_m(self, heights_m: np.ndarray, lidar_m: float, asked_m: float) -> np.ndarray:
        z = heights_m + lidar_m
        allowed = (self._p.height_min <= z) & (z <= self._p.height_max)
        return np.where(allowed, np.abs(heights_m - asked_m), math.inf)


def ends_of(rangings: Sequence[Ranging], motion: Motion, below_m: float, above_m: float) -> np.ndarray:
    """Return where range finders met something (n, 3), m.

    What is at the body already, between ``below_m`` under and ``above_m`` over the lidar, is left out: it is
    the floor that the UAV stands on, or a hand.
    """
    rotation = motion.rotation()
    ends = [
        rotation @ (np.array(ranging.origin_m) + ranging.range_m * np.array(ranging.direction))
        for ranging in rangings
        if ranging.range_min_m <= ranging.range_m <= ranging.range_max_m
    ]
    ends = [end for end in ends if not -below_m <= end[2] <= above_m]
    return np.array(ends).reshape(-1, 3)
