"""Surroundings in three dimensions and the height to fly at, by clouds, or by one plane and range finders."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from cepa.dynamic.cloud_lookout import LAYER_M, LAYERS, SEEN_CELL_M, CloudLookout, Space
from cepa.dynamic.lookout import FIELD_CELL_M
from cepa.dynamic.pseudo_3d import HeightSearch, Plane
from cepa.dynamic.voxel_memory import MOST_POINTS, REACH_M
from cepa.dynamic.ways_out import CELL_M as WAY_CELL_M
from cepa.dynamic.ways_out import NO_WAY_SEARCHED, Course, Layers, Ways, WaysOut
from cepa.kernels.rollout import BY_SIGHT
from cepa.kernels.surroundings import Surroundings
from cepa.motion import Cloud, Motion, Ranging
from cepa.parameters import CepaParameters

AHEAD_M, AHEAD_S = 2.0, 1.6
"""It climbs to a height at which at least so much straight ahead is open, or what it flies in this time."""
SILENCE_PERIODS, SILENCE_S, PERIOD_SHARE = 3.0, (0.3, 1.0), 0.1
"""The planar scan counts after so many periods without a cloud, within these limits."""


class Way(NamedTuple):
    """Where to go on."""

    around: Surroundings
    is_open: bool
    """Whether there is a way out."""
    height_m: float
    """To fly at, above the lidar."""
    climbs: float
    """1.0 or -1.0: it climbs or sinks on the spot, to look for a way at other heights; 0.0: it flies on."""


class CloudWatch:
    """Knows whether clouds come with the scans: a cloud's topic may die in flight while the scan goes on."""

    def __init__(self) -> None:
        self._newest_s = self._now_s = -math.inf
        self._period_s: float | None = None
        self.looks_all_around = False

    def watch(self, cloud: Cloud | None, stamp_s: float) -> None:
        """Take in the cloud of a scan with this stamp; None: none came."""
        self._now_s = stamp_s
        if cloud is None:
            return
        if math.isfinite(self._newest_s):
            period_s = self._period_s or self.silence_s
            self._period_s = period_s + PERIOD_SHARE * (self.silence_s - period_s)
        self._newest_s, self.looks_all_around = stamp_s, cloud.looks_all_around

    @property
    def silence_s(self) -> float:
        """How old the newest cloud is, s; inf: none has come."""
        return self._now_s - self._newest_s if math.isfinite(self._newest_s) else math.inf

    @property
    def is_silent(self) -> bool:
        """Whether more clouds are missing than may get lost now and then."""
        shortest_s, longest_s = SILENCE_S
        return self.silence_s > min(max(SILENCE_PERIODS * (self._period_s or 0.0), shortest_s), longest_s)


class Spatial:
    """Begins with the first cloud, or with the first ranges of range finders."""

    def __init__(self, parameters: CepaParameters):
        self._p = parameters
        self._lookout = CloudLookout(parameters)
        self._search = HeightSearch()
        self._by_plane = False
        self._watch = CloudWatch()
        self._was_silent, self._full_s = False, -math.inf
        self.warnings: tuple[str, ...] = ()  # that begin with the newest look

    def take_over(self, earlier: Spatial) -> None:
        """Take over what one with other parameters remembers; it must not be used any longer."""
        self._lookout.take_over(earlier._lookout)
        self._watch = earlier._watch
        self._was_silent, self._full_s = earlier._was_silent, earlier._full_s

    @property
    def knows_one_height(self) -> bool:
        """Whether ways are known at the height of flight only: all that clouds have shown is forgotten."""
        return self._by_plane and self._watch.silence_s > self._p.memory_s

    def watch(self, cloud: Cloud | None, stamp_s: float) -> None:
        """Take in the cloud that came with the scan of this stamp; None: none did."""
        self._watch.watch(cloud, stamp_s)

    @property
    def wants_plane(self) -> bool:
        """Whether the planar scan shows where it is free: no clouds come that look all around."""
        return self._watch.is_silent or not self._watch.looks_all_around

    def look(
        self,
        cloud: Cloud | None,
        motion: Motion,
        discs: np.ndarray,
        plane: Plane | None,
        rangings: Sequence[Ranging],
        beam_ends: np.ndarray,
    ) -> Space:
        """Return what is known; arguments as for `CloudLookout.look`."""
        self._by_plane = plane is not None
        space = self._lookout.look(cloud, motion, discs, plane, rangings, beam_ends)
        self.warnings = (*self._about_clouds(), *self._about_the_memory(motion.stamp_s))
        return space

    def _about_clouds(self) -> list[str]:
        is_silent = self._watch.is_silent and math.isfinite(self._watch.silence_s)
        changed, self._was_silent = is_silent != self._was_silent, is_silent
        if not changed:
            return []
        if not is_silent:
            return ["Clouds come with the scans again."]
        return [
            f"No cloud has come with the scans for {self._watch.silence_s:.2f} s: the UAV flies by the "
            "planar scan and by what clouds showed before. Check the cloud's topic and its stamps."
        ]

    def _about_the_memory(self, now_s: float) -> list[str]:
        kept_m = self._lookout.kept_m
        if kept_m is None:
            return []
        was_full, self._full_s = now_s - self._full_s <= self._p.memory_s, now_s
        if was_full:
            return []
        return [
            f"Clouds show more than {MOST_POINTS} cells within {REACH_M[0]:g} m: what is farther than "
            f"{kept_m:.1f} m and out of sight is forgotten. Use fewer channels or a smaller memory_s."
        ]

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
