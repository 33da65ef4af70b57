"""The free space in three dimensions: cells that are stamped when they are seen."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from cepa.dynamic.constants.distance_fields import LAYERS
from cepa.dynamic.constants.free_space import (
    BODY_SHARE_SEEN,
    COARSE_ROWS,
    NEAR_M,
    OWN_PLACE_M,
    OWN_REACH_M,
    PICTURE_ROW_TAN,
    PICTURE_ROWS,
    SEEN_CELL_M,
    SEEN_CELLS,
    SEEN_LEVEL_M,
    SEEN_LEVELS,
    SEEN_REACH_UP_M,
    SEEN_WINDOW_M,
)
from cepa.dynamic.free_space.kernels.clouds import stamp_seen
from cepa.dynamic.free_space.kernels.unseen import unseen_layers
from cepa.dynamic.free_space.own_place import OwnPlace
from cepa.dynamic.free_space.planar_sensors import (
    Body,
    Cells,
    LidarPlane,
    cells_around,
    stamp_plane,
    stamp_ranges,
)
from cepa.dynamic.kernels.free_space import BY_REACH
from cepa.dynamic.remembered.field_grid import field_grid_of
from cepa.motion import Motion, Ranging
from cepa.parameters import CepaParameters

CELL = np.array([SEEN_CELL_M, SEEN_LEVEL_M])
REACH_M = np.array([0.5 * SEEN_WINDOW_M + SEEN_CELL_M, SEEN_REACH_UP_M])


class SeenCells:
    """Keeps when each cell was seen last, fixed to the odometry's frame."""

    def __init__(self, parameters: CepaParameters):
        self._p, self._layer_m = parameters, field_grid_of(parameters).layer_m
        self._stamps_s = np.empty((SEEN_CELLS, SEEN_CELLS, SEEN_LEVELS))
        side = 2 * round(0.5 * SEEN_WINDOW_M / SEEN_CELL_M) - 1
        self._unseen = np.empty((LAYERS, side, side), np.uint8)
        self.reset()

    def reset(self) -> None:
        """Forget what was seen."""
        self._stamps_s[:] = -math.inf
        self._own_place = OwnPlace(OWN_PLACE_M)

    def take_over(self, earlier: SeenCells) -> None:
        """Take over what one with other parameters knows; it must not be used any longer."""
        self._stamps_s, self._own_place = earlier._stamps_s, earlier._own_place

    def take_in_cloud(self, free: np.ndarray, motion: Motion, oldest_s: float, has_own_place: bool) -> None:
        """Stamp what a cloud's picture shows free (COARSE_ROWS, COARSE_BINS), m, and the body's own place.

        has_own_place: around the body, so much counts as seen where nobody has looked.
        """
        p = self._p
        ends = p.body_below + SEEN_LEVEL_M, p.body_above + SEEN_LEVEL_M
        own = np.array([p.body_radius + OWN_PLACE_M if has_own_place else 0.0, *ends])
        row_tan, when = PICTURE_ROW_TAN * (PICTURE_ROWS // COARSE_ROWS), (motion.stamp_s, oldest_s)
        origin = np.array(motion.position_m)
        stamp_seen(free, row_tan, origin, *when, CELL, REACH_M, own, NEAR_M, self._stamps_s)

    def take_in_plane_and_ranges(
        self, plane: LidarPlane | None, rangings: Sequence[Ranging], motion: Motion, middle_m: float
    ) -> None:
        """Stamp what a planar scan and range finders show. middle_m: see `Body`."""
        body = self._body(middle_m)
        if plane is not None:
            stamp_plane(self._cells, plane, motion, body)
        stamp_ranges(self._cells, rangings, motion, body, body.radius + OWN_PLACE_M)

    def unseen_since(self, oldest_s: float, origin: np.ndarray) -> np.ndarray:
        """Return where a body in each layer would be in the unseen; see `RecalledSpace`. It is overwritten.

        origin: (3,) m, of the middle layer in the odometry's frame.
        """
        self._fill_unseen(oldest_s, origin, 0, self._unseen.shape[1])
        return self._unseen

    def open_own_place(
        self, unseen: np.ndarray, motion: Motion, middle_m: float, oldest_s: float, origin: np.ndarray
    ) -> np.ndarray:
        """Mark with BY_REACH where the body would be in its own place only; return its reach, m.

        unseen: what `unseen_since` has just returned. The reach is that in equal directions.
        """
        middle = unseen.shape[1] // 2
        body = self._body(middle_m)
        is_seen = not unseen[LAYERS // 2, middle, middle]
        place = cells_around(body, body.radius + OWN_REACH_M, self._cells, motion)
        reach = math.ceil((body.radius + OWN_REACH_M + body.radius) / SEEN_CELL_M) + 2
        first, last = (
            max(0, middle - reach),
            middle + reach + 1,
        )  # no other cell of ``unseen`` meets the place
        window = unseen[:, first:last, first:last]
        before, seen_s = window.copy(), self._stamps_s[place]
        self._stamps_s[place] = motion.stamp_s  # for the next line only: nobody has seen it
        self._fill_unseen(oldest_s, origin, first, last)
        self._stamps_s[place] = seen_s
        is_own = before > window
        window[:] = before
        window[is_own] = BY_REACH
        return self._own_place.follow(origin[:2].copy(), is_seen)

    def _fill_unseen(self, oldest_s: float, origin: np.ndarray, first: int, last: int) -> None:
        p = self._p
        body = np.array([p.body_radius, BODY_SHARE_SEEN * p.body_below, BODY_SHARE_SEEN * p.body_above])
        heights = np.array([p.height_min, p.height_max])
        where = CELL, self._layer_m, body, heights, self._unseen
        unseen_layers(self._stamps_s, origin, oldest_s, *where, first, last)

    @property
    def _cells(self) -> Cells:
        return Cells(self._stamps_s, SEEN_CELL_M, SEEN_LEVEL_M)

    def _body(self, middle_m: float) -> Body:
        p = self._p
        return Body(p.body_radius, BODY_SHARE_SEEN * p.body_below, BODY_SHARE_SEEN * p.body_above, middle_m)
