"""Surroundings in three dimensions and the height to fly at, by clouds, or by one plane and range finders."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from cepa.dynamic.cloud_lookout import LAYER_M, LAYERS, SEEN_CELL_M, CloudLookout, Space
from cepa.dynamic.lookout import FIELD_CELL_M
from cepa.dynamic.pseudo_3d import HeightSearch, Plane
from cepa.dynamic.ways_out import CELL_M as WAY_CELL_M
from cepa.dynamic.ways_out import NO_WAY_SEARCHED, Course, Layers, Ways, WaysOut
from cepa.kernels.rollout import BY_SIGHT
from cepa.kernels.surroundings import Surroundings
from cepa.motion import Cloud, Motion, Ranging
from cepa.parameters import CepaParameters

AHEAD_M, AHEAD_S = 2.0, 1.6
"""It climbs to a height at which at least so much straight ahead is open, or what it flies in this time."""


class Way(NamedTuple):
    """Where to go on."""

    around: Surroundings
    is_open: bool
    """Whether there is a way out."""
    height_m: float
    """To fly at, above the lidar."""
    climbs: float
    """1.0 or -1.0: it climbs or sinks on the spot, to look for a way at other heights; 0.0: it flies on."""


class Spatial:
    """Begins with the first cloud, or with the first ranges of range finders."""

    def __init__(self, parameters: CepaParameters):
        self._p = parameters
        self._lookout = CloudLookout(parameters)
        self._search = HeightSearch()
        self._by_plane = False
        self._had_cloud = False

    def take_over(self, earlier: Spatial) -> None:
        """Take over what one with other parameters remembers; it must not be used any longer."""
        self._lookout.take_over(earlier._lookout)
        self._had_cloud = earlier._had_cloud

    @property
    def knows_one_height(self) -> bool:
        """Whether ways are known at the height of flight only: no cloud has come yet."""
        return self._by_plane and not self._had_cloud

    def wants_plane(self, cloud: Cloud | None) -> bool:
        """Whether the planar scan counts: no cloud has looked all around yet, nor does this one."""
        return not (self._lookout.sees_all_around or (cloud is not None and cloud.looks_all_around))

    def look(
        self,
        cloud: Cloud | None,
        motion: Motion,
        discs: np.ndarray,
        plane: Plane | None,
        rangings: Sequence[Ranging],
    ) -> Space:
        """Return what is known; arguments as for `CloudLookout.look`."""
        self._by_plane = plane is not None
        self._had_cloud |= cloud is not None
        return self._lookout.look(cloud, motion, discs, plane, rangings)

    def around(self, space: Space, discs: np.ndarray, ways: Ways = NO_WAY_SEARCHED) -> Surroundings:
        """Return what is around the UAV; what moves (k, 6) counts at all heights."""
        field = space.distance, FIELD_CELL_M, LAYER_M, self._lookout.far_m
        length, *offset = ways
        return Surroundings(
            *field, space.own_reach, space.unseen, SEEN_CELL_M, discs, length[None], WAY_CELL_M, *offset
        )

    def open_height_m(self, space: Space, direction: np.ndarray, speed: float) -> float:
        """Return the height, m above the lidar, at which the way straight ahead is open."""
        return space.open_height_m(direction, max(AHEAD_M, AHEAD_S * speed), self._p.r_lb)

    def way(
        self,
        space: Space,
        discs: np.ndarray,
        course: Course,
        height_m: float,
        motion: Motion,
        ways_out: WaysOut | None,
    ) -> Way:
        """Return the way out; ``ways_out`` None: none is searched.

        Where a plane and range finders have found none, or only one that leads back, it tries other heights.
        Without a cloud only the layer that the UAV is in counts. A plane that tilts shows a few cells of the
        layers above and below, and a way through these would end the search, though the UAV cannot fly it.
        """
        if ways_out is None:
            return Way(self.around(space, discs), True, height_m, 0.0)
        layers = Layers(space.distance, FIELD_CELL_M, space.detours_m)
        if self.knows_one_height:
            layers = Layers(space.distance[LAYERS // 2][None], FIELD_CELL_M, np.zeros(1))
        ways = ways_out.search_layers(layers, course, motion)
        climbs = 0.0
        if not self._by_plane or (ways is not None and not ways_out.leads_back):
            self._search.reset()
        else:
            climbs = self._search.climb(motion.position_m[2], self._next_layers_open(space)) or 0.0
        around = self.around(space, discs, ways or NO_WAY_SEARCHED)
        return Way(around, ways is not None, height_m, climbs)

    def give_up_height(self) -> None:
        """Take in that the UAV cannot climb, or sink, any further in search of a way."""
        self._search.give_up()

    def _next_layers_open(self, space: Space) -> tuple[bool, bool]:
        """Return whether the UAV may move into the next layer above, and into the next one below."""
        middle, seen_side, side = LAYERS // 2, space.unseen.shape[1] // 2, space.distance.shape[1] // 2
        here_m = space.distance[middle, side, side]
        above, below = (
            space.unseen[middle + step, seen_side, seen_side] in (0, BY_SIGHT)
            and space.distance[middle + step, side, side] >= min(self._p.r_lb, here_m)
            and math.isfinite(space.detours_m[middle + step])
            for step in (1, -1)
        )
        return bool(above), bool(below)
