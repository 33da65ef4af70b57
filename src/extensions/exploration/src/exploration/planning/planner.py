"""The shortest safe path through known free space."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Sequence

import numpy as np

from exploration.planning import refusals
from exploration.planning.clearance import ClearanceMap
from exploration.planning.closures import Closure, Closures
from exploration.planning.if_free import clearances_if_free
from exploration.planning.kernels.distances import REACH_MAX
from exploration.planning.kernels.neighbours import STEPS
from exploration.planning.kernels.pulling import pull
from exploration.planning.kernels.search import DONE, START, TIE, UNREACHED, search
from exploration.planning.landmarks import Landmarks
from exploration.planning.parameters import PlannerParameters
from exploration.planning.room_above import room_above_m
from exploration.planning.space import Space
from exploration.planning.unseen import unseen_obstacle
from exploration.planning.voxel_grid import UNKNOWN, AssumedFree, VoxelGrid
from flight_basics.errors import NoPathError, PoseError
from flight_limits import KeepOutBox, Limits

WINDOW = 150
"""Voxels of a path that one leg may skip."""
OVERSHOOT_M = 0.15
"""A UAV that takes off may rise so much beyond its height."""
RISE_MARGIN_M = 0.5
"""Wind of up to 3 m/s carried a UAV less to the side in eleven of twelve take-offs, and once by 0.65 m."""
FAR_VOXELS, FAR_GREED = 250, 1.2
"""A way farther than the first may cost so many times as much as the cheapest, which takes long in halls."""
HALF_DIAGONAL = math.sqrt(3.0) / 2.0
"""Of a voxel: its centre is at most so far from a place in it."""


@dataclass(frozen=True)
class Plan:
    """A path.

    Attributes:
        points_m: (n, 3) x, y, z in the map's frame, from the start to the goal.
        length_m: of its legs.
        searched_m: length of the path from voxel to voxel that string pulling began with.
        beyond_m: (n, 3) of `onward`: how the way would lead on, from voxel to voxel.
    """

    points_m: np.ndarray
    length_m: float
    searched_m: float
    beyond_m: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))


class PathPlanner:
    """Plans on a map that it is given tile by tile.

    A path runs through voxels that are known to be free and keep `clearance_m`. A UAV that is nearer to
    something may leave it, but not come still nearer. A* finds the cheapest path from voxel to voxel; string
    pulling then takes the shortcuts that keep the clearance.

    Args:
        parameters: of the UAV. limits: keep-out boxes and ceiling.
    """

    def __init__(self, parameters: PlannerParameters | None = None, limits: Limits | None = None):
        self._parameters, self._limits = parameters or PlannerParameters(), limits or Limits()
        self._map: ClearanceMap | None = None
        self._landmarks: Landmarks | None = None
        self._closures = Closures()
        self._unseen: tuple[KeepOutBox, ...] = ()
        self._held_m: list[np.ndarray] = []
        """Where the UAV came no nearer."""
        self._ventured: list[AssumedFree | None] = []

    @property
    def parameters(self) -> PlannerParameters:
        """Setting them computes all distances anew."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: PlannerParameters) -> None:
        self._parameters = parameters
        if self._map is not None:
            self._begin_on(self._map.grid)

    def lower_ceiling(self, height_m: float) -> None:
        """Let the UAV's centre come no higher than this in the map's frame, nor than the limits say."""
        self._limits = replace(self._limits, ceiling_m=min(self._limits.ceiling_m, height_m))

    @property
    def has_map(self) -> bool:
        """Whether it knows anything."""
        return self._map is not None

    def known_m3(self) -> float:
        """Return the volume that is known, free or occupied."""
        grid = None if self._map is None else self._map.grid
        return 0.0 if grid is None else float(grid.known) * grid.resolution_m**3

    def update_map(self, resolution_m: float, side: int, tiles: np.ndarray, voxels: np.ndarray) -> None:
        """Take over tiles of the map: see `VoxelGrid.update`. Another size of voxels begins a new map.

        Raises:
            MapError: they make no sense; the map stays as it was.
        """
        known = self._map
        if known is not None and (known.grid.resolution_m, known.grid.side) == (resolution_m, side):
            has_changed = known.grid.update(tiles, voxels)
            known.note(np.asarray(tiles)[has_changed])
            if self._landmarks is not None:
                self._landmarks.note()
            return
        grid = VoxelGrid(resolution_m, side)
        grid.update(tiles, voxels)
        self._begin_on(grid)
        self._ventured = []

    def assume_free(self, place_m: np.ndarray, radius_m: float) -> None:
        """Let what is unknown around a place (x, y, z) count as free: where the UAV is, or takes off.

        A level lidar does not see what is above and below it. Occupied voxels stay occupied.

        Raises:
            PoseError: the place is not finite.
            MapError: the place is too far from the map.
        """
        if self._map is not None:
            self._map.assume_free(_place("place", place_m), radius_m)

    def venture(self, places_m: np.ndarray, radius_m: float) -> None:
        """Take what is unknown around places (n, 3) as free, until `settle` tells where the UAV has been.

        Raises:
            PoseError, MapError: as `assume_free`.
        """
        if self._map is not None:
            grid = self._map
            self._ventured = [grid.assume_free(_place("place", place_m), radius_m) for place_m in places_m]

    def settle(self, is_flown: Sequence[bool]) -> None:
        """Take nothing more as free around those places of `venture` that were not flown to."""
        ventured, self._ventured = self._ventured, []
        for assumed, was_there in zip(ventured, is_flown):
            if self._map is not None and assumed is not None and not was_there:
                self._map.withdraw(assumed)

    def clear_map(self) -> None:
        """Forget the map, but not what is closed."""
        self._map, self._landmarks, self._ventured, self._unseen = None, None, [], ()

    def close(self, place_m: np.ndarray, stamp_s: float) -> None:
        """Close a place (x, y, z) that CEPA did not fly, for `closed_time`; each time for twice as long.

        Raises:
            PoseError: the place is not finite.
        """
        self._closures.close(place_m, self._parameters.closed_radius, self._parameters.closed_time, stamp_s)

    def note_held_off(
        self, here_m: np.ndarray, next_m: np.ndarray, stamp_s: float, close_m: np.ndarray | None = None
    ) -> None:
        """Take that a UAV at a place (x, y, z) comes no nearer to the next one of its way.

        If nothing that is known keeps it off, see `meets_unseen`. Else CEPA refuses it for now, and a place
        is closed as by `close`. close_m: this place; None: the next one.
        """
        if not self.meets_unseen(here_m, next_m, stamp_s):
            self.close(next_m if close_m is None else close_m, stamp_s)

    def meets_unseen(self, here_m: np.ndarray, next_m: np.ndarray, stamp_s: float) -> bool:
        """Return whether a UAV that comes no nearer is held by what no beam shows: then that is kept out of.

        See `unseen_obstacle`. It counts until the map begins anew, or no other way leads home.
        """
        if self._map is None:
            return False
        p, space = self._parameters, self.space(stamp_s, here_m, with_closed=False)
        again = any(math.dist(here_m, held_m) <= p.closed_radius for held_m in self._held_m)
        self._held_m.append(np.array(here_m, float))
        unseen = unseen_obstacle(space, here_m, next_m, p, again)
        if unseen is not None:
            self._keep_off((*self._unseen, unseen))
        return unseen is not None

    @property
    def unseen(self) -> tuple[KeepOutBox, ...]:
        """What has held the UAV and no beam has shown."""
        return self._unseen

    def _keep_off(self, unseen: tuple[KeepOutBox, ...]) -> None:
        self._unseen = unseen
        if self._map is not None:
            self._map.keep_out(self._all_limits.boxes)

    @property
    def _all_limits(self) -> Limits:
        return replace(self._limits, boxes=self._limits.boxes + self._unseen)

    def reopen(self, stamp_s: float, times_max: float = math.inf) -> bool:
        """Open what is closed at a stamp and was so at most so often. Return whether anything was.

        Without a limit, obstacles that no beam has shown count no longer either.
        """
        has_unseen = bool(self._unseen) and math.isinf(times_max)
        if has_unseen:
            self._keep_off(())
        return (bool(self._closures.at(stamp_s)) and self._closures.reopen(times_max)) or has_unseen

    def plan(self, start_m: np.ndarray, goal_m: np.ndarray, stamp_s: float = 0.0) -> Plan:
        """Return the path from a start to a goal, each (x, y, z) in the map's frame.

        Raises:
            PoseError: a place is not finite.
            NoPathError: there is no path; the sentence says what blocks it.
        """
        start_m, goal_m = _place("start", start_m), _place("goal", goal_m)
        space = self.space(stamp_s, start_m)
        refusals.require_start(space, start_m)
        refusals.require_goal(space, goal_m)
        cost, came = _search(space, start_m, goal_m)
        if math.isinf(cost):
            raise NoPathError(self._why(space, came, start_m, goal_m))
        way = _way_back(came, np.array(space.grid.index_of(goal_m))) + 0.5
        chain = np.concatenate(([space.inner(start_m)], way, [space.inner(goal_m)]))
        kept = pull(space.squares, space.need, space.factors, chain, WINDOW)
        points_m = space.outer(chain[kept])
        return Plan(points_m, _length(points_m), _length(space.outer(chain)))

    def onward(self, start_m: np.ndarray, goal_m: np.ndarray, stamp_s: float = 0.0) -> Plan:
        """Return the path to where the known part ends of the way to a goal that the map does not show yet.

        This way is the cheapest if all that is unknown is free (Koenig and Likhachev, D* Lite, 2002: the
        free-space assumption). The path itself keeps what `plan` promises. What is unknown counts only from
        the lower to the higher end, so that a UAV does not try the space above each wall first.

        Raises:
            PoseError: a place is not finite.
            MapError: the goal is too far from the map.
            NoPathError: there is no way, even if all that is unknown is free.
        """
        start_m, goal_m = _place("start", start_m), _place("goal", goal_m)
        if self._map is None:
            raise NoPathError("There is no map yet.")
        self._map.assume_free(goal_m, self._map.grid.resolution_m)  # the grid then reaches there
        space, reach = self.space(stamp_s, start_m), self._map.reach
        refusals.require_start(space, start_m)
        if_free = clearances_if_free(space, reach).astype(np.uint16)
        if_free[_beyond(space, start_m[2], goal_m[2]) & (space.grid.kinds == UNKNOWN)] = 0
        ideal = Space.of(space.grid, if_free, self._parameters, space.limits, space.closed, start_m[2])
        cost, came = _search(ideal, start_m, goal_m)
        if math.isinf(cost):
            raise NoPathError(self._why(ideal, came, start_m, goal_m))
        way = _way_back(came, np.array(space.grid.index_of(goal_m))).astype(np.int64)
        _, reached = _search(space, start_m, goal_m)
        voxels = tuple(way.T)
        known = np.flatnonzero((reached[voxels] != UNREACHED) & (space.squares[voxels] >= space.need))
        if not len(known):
            raise NoPathError("Around the UAV too little is known to fly on towards the goal.")
        way_m = space.grid.centres_m(way)
        plan = self.plan(start_m, way_m[known[-1]], stamp_s)
        return replace(plan, beyond_m=way_m[known[-1] :])

    def is_clear(self, points_m: np.ndarray, stamp_s: float = 0.0) -> bool:
        """Return whether a path's legs (n, 3), begun at the UAV, still keep what `plan` promises."""
        space = self.space(stamp_s, points_m[0])
        return all(space.is_clear(*leg) for leg in zip(points_m, points_m[1:]))

    def room_above_m(self, place_m: np.ndarray, rise_max_m: float) -> float:
        """Return how far a UAV that stands at a place (x, y, z) may rise, at most `rise_max_m`.

        See `room_above.room_above_m`. The ceiling counts, too. Without a map nothing is in the way.

        Raises:
            PoseError: the place is not finite.
        """
        place_m = _place("place", place_m)
        rise_max_m = max(min(rise_max_m, self._limits.ceiling_m - place_m[2]), 0.0)
        if self._map is None:
            return rise_max_m
        p = self._parameters
        clearance_m = p.radius + max(p.margin, OVERSHOOT_M)
        drift_m = max(p.radius + RISE_MARGIN_M - clearance_m, 0.0)
        return room_above_m(self._map.grid, place_m, rise_max_m, p.radius, clearance_m, drift_m)

    def _begin_on(self, grid: VoxelGrid) -> None:
        p = self._parameters
        reach = min(math.ceil((p.clearance_m + p.comfort) / grid.resolution_m) + 1, REACH_MAX)
        self._map = ClearanceMap(grid, reach, self._all_limits.boxes)
        self._landmarks = Landmarks(grid, p.landmark_reach) if p.landmark_reach > 0.0 else None

    def space(
        self, stamp_s: float, start_m: np.ndarray, with_closed: bool = True, with_far: bool = True
    ) -> Space:
        """Return what the UAV may fly through from a start (x, y, z); raises NoPathError without a map.

        with_closed: whether what is closed counts. with_far: whether `landmark_reach` does.
        """
        if self._map is None:
            raise NoPathError("There is no map yet.")
        grid, closures = self._map.grid, self._closures.at(stamp_s) if with_closed else []
        closed = tuple(_ahead_of(closure, start_m, grid) for closure in closures)
        squares = self._map.squares()
        far = self._landmarks.far(start_m) if self._landmarks is not None and with_far else None
        return Space.of(grid, squares, self._parameters, self._all_limits, closed, start_m[2], far)

    def _why(self, space: Space, came: np.ndarray, start_m: np.ndarray, goal_m: np.ndarray) -> str:
        """Return the sentence that says what blocks the way."""
        if space.closed and self._map is not None:
            opened = self.space(0.0, start_m, with_closed=False)
            if math.isfinite(_search(opened, start_m, goal_m)[0]):
                return refusals.closed_ways(space)
        return refusals.no_way(space, came, goal_m)


def _search(space: Space, start_m: np.ndarray, goal_m: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the cost between two places in the grid, in voxels, and the step that led to each voxel."""
    ends = np.array([space.grid.index_of(start_m), space.grid.index_of(goal_m)])
    came = np.full(space.squares.shape, UNREACHED, np.int8)
    greed = FAR_GREED if np.ptp(ends, axis=0).max() > FAR_VOXELS else TIE
    return search(space.squares, space.need, space.factors, ends, came, greed), came


def _beyond(space: Space, one_m: float, other_m: float) -> np.ndarray:
    """Return which layers (d, 1, 1) are more than the clearance above or below both heights."""
    heights_m = (np.arange(space.squares.shape[0]) + space.corner[2] + 0.5) * space.grid.resolution_m
    low_m, high_m = min(one_m, other_m) - space.clearance_m, max(one_m, other_m) + space.clearance_m
    return ((heights_m < low_m) | (heights_m > high_m))[:, None, None]


def _place(name: str, place_m: np.ndarray) -> np.ndarray:
    place_m = np.asarray(place_m, float)
    if place_m.shape != (3,) or not np.isfinite(place_m).all():
        raise PoseError(f"The {name} is not three finite numbers.")
    return place_m


def _ahead_of(closure: Closure, start_m: np.ndarray, grid: VoxelGrid) -> Closure:
    """Return a closure that does not hold the UAV itself, so that it can always leave."""
    away_m = math.dist(closure.place_m, start_m) - HALF_DIAGONAL * grid.resolution_m
    return replace(closure, radius_m=min(closure.radius_m, away_m))


def _way_back(came: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """Return the voxels (n, 3), z, y, x, from the start to the goal, by the steps that led to each."""
    voxel = tuple(goal.tolist())
    way = [voxel]
    while came[voxel] % DONE != START:
        voxel = tuple((np.array(voxel) - STEPS[came[voxel] % DONE]).tolist())
        way.append(voxel)
    return np.array(way[::-1], float)


def _length(points_m: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points_m, axis=0), axis=1).sum())
