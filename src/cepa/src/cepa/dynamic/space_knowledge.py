"""What a UAV knows of its surroundings in three dimensions: by clouds, or by a plane and range finders."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.candidates import climbing
from cepa.dynamic.cloud_watch import CloudWatch
from cepa.dynamic.constants.choice import SCAN_NOISE_M
from cepa.dynamic.constants.cost_to_go import HEIGHT_GAIN_S, OPEN_AHEAD_M, OPEN_AHEAD_S
from cepa.dynamic.constants.distance_fields import FIELD_WINDOW_M, LAYERS
from cepa.dynamic.constants.free_space import SEEN_CELL_M
from cepa.dynamic.constants.remembered import MOST_POINTS
from cepa.dynamic.constants.response import CLIMB_LAG_S
from cepa.dynamic.cost_to_go.course import Course, Reference
from cepa.dynamic.cost_to_go.height_search import HeightSearch
from cepa.dynamic.cost_to_go.search import CostToGoSearch, Found, Layers
from cepa.dynamic.free_space.slab import HaveStood
from cepa.dynamic.kernels.free_space import BY_REACH
from cepa.dynamic.kernels.rollout import DISCOMFORT, LOSS
from cepa.dynamic.kernels.surroundings import (
    NO_COST_TO_GO,
    CostToGo,
    DistanceField,
    FreeSpace,
    Surroundings,
)
from cepa.dynamic.knowledge import Knowledge, Observation, Outlook, Snapshot
from cepa.dynamic.obstacle_tracks.moving_obstacles import SegmentedScan
from cepa.dynamic.plane_knowledge import PlaneKnowledge, is_leading_away
from cepa.dynamic.remembered.field_grid import field_grid_of
from cepa.dynamic.remembered.space_memory import NO_POINTS, RecalledSpace, SpaceMemory
from cepa.dynamic.rollouts import Rollouts, cost_horizon_s
from cepa.dynamic.threats import is_within
from cepa.motion import Motion
from cepa.parameters import CepaParameters


class SpaceKnowledge(Knowledge):
    """Begins with the first cloud, or with the first ranges of range finders.

    While clouds come that look all around, a scan shows what moves, and nothing else. plane: what scans show
    otherwise. search: for the cost-to-go; None: it is not searched.
    """

    def __init__(
        self,
        parameters: CepaParameters,
        rollouts: Rollouts,
        search: CostToGoSearch | None,
        plane: PlaneKnowledge,
    ):
        self._p, self._rollouts, self._search, self._plane = parameters, rollouts, search, plane
        self._grid = field_grid_of(parameters)
        self._memory, self._heights, self._clouds = SpaceMemory(parameters), HeightSearch(), CloudWatch()
        self._full_s = -math.inf  # when there was no room left for points

    def take_over(self, earlier: SpaceKnowledge) -> None:
        """Take over what one with other parameters knows; it must not be used any longer."""
        self._memory.take_over(earlier._memory)
        self._clouds, self._full_s = earlier._clouds, earlier._full_s

    def take_in(self, observed: Observation) -> Snapshot:
        """Take in what came with a scan."""
        cloud, motion, p = observed.cloud, observed.motion, self._p
        self._clouds.take_in(cloud, motion.stamp_s)
        plane = self._plane.lidar_plane(observed) if self._needs_plane else None
        counts = self._needs_plane or cloud is None
        beam_ends = observed.points[~observed.is_moving] if counts else NO_POINTS
        if len(observed.walls):
            beam_ends = np.concatenate((beam_ends, observed.walls))
        came = observed.movers, plane, observed.rangings, beam_ends
        space = self._memory.take_in(cloud, motion, *came, observed.is_held)
        heights_m = space.points[:, 2]
        near = space.points[(-p.body_below <= heights_m) & (heights_m <= p.body_above), :2]
        state = observed.state.copy()
        state[2, 0] -= space.middle_m
        warnings = (*self._clouds.news(), *self._about_the_memory(motion))
        return Snapshot(observed, near, state, space, warnings)

    def _about_the_memory(self, motion: Motion) -> tuple[str, ...]:
        kept_m = self._memory.kept_m
        if kept_m is None:
            return ()
        was_full, self._full_s = motion.stamp_s - self._full_s <= self._p.memory_s, motion.stamp_s
        if was_full:
            return ()
        return (
            f"Clouds show more than {MOST_POINTS} cells within {0.5 * FIELD_WINDOW_M:g} m: what is farther "
            f"than {kept_m:.1f} m and out of sight is forgotten. Use fewer channels or a smaller memory_s.",
        )

    def have_stood(self, scan: SegmentedScan, motion: Motion) -> np.ndarray:
        """Return which movers (k,) of a scan have stood where they are; see `SpaceMemory.have_stood`."""
        return self._memory.have_stood(scan.movers, scan.points, motion)

    def has_stood(self, motion: Motion) -> HaveStood:
        """Return what tells at which points, from the UAV, clouds have shown something for long."""
        return self._memory.has_stood(motion)

    def columns(self, motion: Motion, is_open: bool) -> np.ndarray:
        """Return the discs (k, 8) that something comes down into, as the clouds until now have shown.

        is_open: no ceiling is over the UAV.
        """
        return self._memory.columns(motion, is_open)

    def forget_over(self, motion: Motion, way: float) -> None:
        """Forget what is over (way 1) or under (-1) the UAV: spots of what comes do not stand there."""
        self._memory.forget_over(motion, way)

    @property
    def has_clouds(self) -> bool:
        """Whether clouds come that look all around: then what stands need not be the same at all heights."""
        return not self._needs_plane

    @property
    def looks_up(self) -> bool:
        """Whether clouds look up so steeply that they show what comes down before the UAV is under it."""
        return self._clouds.looks_up

    @property
    def _needs_plane(self) -> bool:
        """Whether the planar scan counts: clouds stay away, or do not look all around."""
        return self._clouds.is_silent or not self._clouds.looks_all_around

    @property
    def knows_one_height(self) -> bool:
        """Whether ways are known at the height of flight only: all that clouds have shown is forgotten."""
        return self._needs_plane and self._clouds.silence_s > self._p.memory_s

    def clear_reference(self, snapshot: Snapshot, reference: Reference, commit_s: float) -> np.ndarray | None:
        """Return the reference as a command if its path is clear; see `Knowledge`."""
        space = _space(snapshot)
        command = reference.velocity.copy()
        command[2] = np.clip(command[2], -self._p.climb_max, self._p.climb_max)
        around = self._around(snapshot, NO_COST_TO_GO)
        assessed = self._rollouts.assess(command[None], snapshot.state, around, reference.direction, commit_s)
        (is_admissible,), (outcome,) = assessed.is_admissible, assessed.outcomes
        if not (is_admissible and outcome[DISCOMFORT] == outcome[LOSS] == 0.0):
            return None
        if self._open_height_m(space, reference) != space.asked_m:
            return None
        if self.knows_one_height and is_leading_away(self._search, reference, self._p):
            return None
        return command

    def outlook(self, snapshot: Snapshot, reference: Reference, course: Course) -> Outlook:
        """Return the clearances, the free space and the cost-to-go around the UAV.

        Where a plane and range finders have found no way, or only one that leads back, it tries other
        heights.
        """
        space, motion = _space(snapshot), snapshot.observed.motion
        is_under = is_within(snapshot.observed.columns)  # it leaves to the side, at its height
        height_m = 0.0 if is_under else self._open_height_m(space, reference)
        found, climb = Found(NO_COST_TO_GO, False), 0.0
        if self._search is not None and reference.speed >= self._p.reference_speed_min:
            found = self._search.search_layers(self._layers(space), course, motion)
            if is_under or not self._needs_plane or (found.cost_to_go is not None and not found.leads_back):
                self._heights.reset()
            else:
                climb = self._heights.climb(motion.position_m[2], self._next_layers_open(space)) or 0.0
        return Outlook(
            self._around(snapshot, found.cost_to_go or NO_COST_TO_GO),
            has_way=found.cost_to_go is not None,
            remembered=space.points,
            is_hidden=space.is_hidden,
            climb_m_s=height_m / HEIGHT_GAIN_S,
            height_m=self._aimed_m(snapshot, reference, height_m) - space.middle_m,
            search_climb=climb,
        )

    def with_climbs(self, level: np.ndarray, climb_m_s: float) -> np.ndarray:
        """Return ``level`` (n, 3), m/s, with climbs."""
        return climbing(level, climb_m_s, self._p.climb_max)

    def remembered(self, snapshot: Snapshot) -> tuple[np.ndarray, np.ndarray]:
        """Return all remembered points (n, 3), m, and which are hidden (n,)."""
        space = _space(snapshot)
        return space.points, space.is_hidden

    def give_up_height(self) -> None:
        """Take in that the UAV cannot climb, or sink, any further in search of a way."""
        self._heights.give_up()

    def _around(self, snapshot: Snapshot, cost_to_go: CostToGo) -> Surroundings:
        """Return what is around the UAV; what moves counts at all heights."""
        space = _space(snapshot)
        field = DistanceField(space.distance, self._grid.cell_m, self._grid.layer_m, self._memory.far_m)
        free_space = FreeSpace(space.own_reach_m, space.unseen, SEEN_CELL_M)
        return Surroundings(field, free_space, snapshot.observed.threats, cost_to_go)

    def _open_height_m(self, space: RecalledSpace, reference: Reference) -> float:
        """Return the height, m above the lidar, at which the way straight ahead is open.

        Where the reference leads up or down, nothing ahead need be open: a hole in a deck is a way. And it
        may be as narrow as here. Else a UAV that was led along a wall would seek heights at which it has not
        seen the wall yet.
        """
        if reference.is_steep:
            keep_m = min(self._p.r_lb, space.here_m) - SCAN_NOISE_M
            return space.open_height_m(reference.direction, 0.0, keep_m)
        ahead_m = max(OPEN_AHEAD_M, OPEN_AHEAD_S * reference.speed)
        return space.open_height_m(reference.direction, ahead_m, self._p.r_lb)

    def _aimed_m(self, snapshot: Snapshot, reference: Reference, open_m: float) -> float:
        """Return the height, m above the lidar, at which the horizon of the cost is to end.

        It is where the reference's climb leads by then if the height that it asks for is open. That height
        itself is nearer, and the UAV would climb more slowly than it is asked to.
        """
        if open_m != _space(snapshot).asked_m:
            return open_m
        climb = min(max(reference.velocity[2], -self._p.climb_max), self._p.climb_max)
        late_m = CLIMB_LAG_S * (climb - snapshot.state[2, 1])
        return float(climb * cost_horizon_s(self._p) - late_m)

    def _layers(self, space: RecalledSpace) -> Layers:
        """Return the layers that ways lead through.

        Without a cloud only the layer that the UAV is in counts. A plane that tilts shows a few cells of the
        layers above and below, and a way through these would end the search, though the UAV cannot fly it.
        """
        if self.knows_one_height:
            return Layers(space.distance[LAYERS // 2][None], self._grid.cell_m, np.zeros(1))
        return Layers(space.distance, self._grid.cell_m, space.detours_m)

    def _next_layers_open(self, space: RecalledSpace) -> tuple[bool, bool]:
        """Return whether the UAV may move into the next layer above, and into the next one below."""
        middle, seen_side, side = LAYERS // 2, space.unseen.shape[1] // 2, space.distance.shape[1] // 2
        here_m = space.distance[middle, side, side]
        above, below = (
            space.unseen[middle + step, seen_side, seen_side] in (0, BY_REACH)
            and space.distance[middle + step, side, side] >= min(self._p.r_lb, here_m)
            and math.isfinite(space.detours_m[middle + step])
            for step in (1, -1)
        )
        return bool(above), bool(below)


def _space(snapshot: Snapshot) -> RecalledSpace:
    assert snapshot.space is not None  # as SpaceKnowledge takes it in
    return snapshot.space
