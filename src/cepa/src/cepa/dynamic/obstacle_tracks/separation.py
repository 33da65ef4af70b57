"""What stands, and what moves, sinks or rises: an `Observation` of each scan."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple, Sequence

import numpy as np

from cepa.dynamic.constants.choice import EVASION_M_S, HURRIED_EVASION_M_S
from cepa.dynamic.constants.free_space import SLAB_RANGE_M
from cepa.dynamic.constants.obstacle_tracks import LATE_S
from cepa.dynamic.free_space.slab import Slab
from cepa.dynamic.knowledge import Observation, Snapshot
from cepa.dynamic.obstacle_tracks.moving_obstacles import MovingObstacles, SegmentedScan
from cepa.dynamic.obstacle_tracks.sinking import NO_COLUMNS, Sinking
from cepa.dynamic.space_knowledge import SpaceKnowledge
from cepa.dynamic.threats import evasion_speed, is_hurried, threats
from cepa.keep_out import KeepOut, at_heights
from cepa.motion import LEVEL, Cloud, Motion, Ranging
from cepa.parameters import CepaParameters
from cepa.scan import Beams

NOTHING = np.empty((0, 3))


class Came(NamedTuple):
    """What came with a scan."""

    beams: Beams
    range_max: float
    """m: of the lidar."""
    motion: Motion
    """At the scan's stamp."""
    age_s: float
    """So much older was the odometry."""
    state: np.ndarray
    """(3, 4): of the UAV when an answer shows its effect, see kernels/response.py."""
    cloud: Cloud | None
    rangings: Sequence[Ranging]
    reference_speed: float
    """m/s"""
    is_held: bool
    """Whether the UAV has got nowhere for long, see `HoldUp`."""


class Separation:
    """Separates in each scan what stands from what moves, sinks or rises, and keeps what has."""

    def __init__(self, parameters: CepaParameters):
        self._p, p = parameters, parameters
        self._moving, self._sinking = MovingObstacles(p), Sinking(p.body_below, p.body_above)
        self._slab, self._reads_clouds = Slab(p), p.climb_max > 0.0
        self.keep_out = KeepOut()

    def reset(self) -> None:
        """Forget what moves, sinks or rises."""
        self._moving.reset()
        self._sinking.reset()

    def take_over(self, earlier: Separation) -> None:
        """Take over what one with other parameters knows; it must not be used any longer."""
        self._moving.take_over(earlier._moving)
        self._sinking.take_over(earlier._sinking)
        self.keep_out = earlier.keep_out

    def tell(self, told: Motion) -> float:
        """Take in the odometry; return how far the UAV has turned since then, rad."""
        return self._moving.tell(told)

    def observe(self, came: Came, space: SpaceKnowledge | None) -> Observation:
        """Tell what moves from what stands; return it with all that came with the scan.

        space: what clouds and range finders have shown; None: none came yet.
        """
        now, rangings = came.motion, came.rangings
        scan = self._scan_of(came, space)
        if space is not None and len(scan.movers) and space.has_clouds:
            scan = scan.without(space.have_stood(scan, now))
        standing = NOTHING
        if len(scan.points):
            standing = scan.points[~scan.is_moving] if len(scan.movers) else scan.points.copy()
        walls = self.keep_out.walls(now.position_m)
        if len(walls):
            p = self._p
            standing = np.concatenate((standing, at_heights(walls, -p.body_below, p.body_above)))
        columns = self._sinking.take_in(rangings, now, self.clouds_show_loads(now, space))
        falling = self._falling(now, space)
        columns = np.concatenate((columns, falling))
        if space is not None and is_hurried(columns, self._p.body_radius):
            for way in np.unique(columns[:, 7]).tolist():
                rangings = [r for r in rangings if way * r.direction[2] <= 0.0]
                space.forget_over(now, way)
        return Observation(
            motion=now,
            state=came.state,
            beams=came.beams,
            range_max=came.range_max,
            points=scan.points,
            is_moving=scan.is_moving,
            standing=standing,
            free=scan.free,
            movers=scan.movers,
            columns=columns,
            falling=falling,
            walls=walls,
            threats=self._threats(scan.movers, columns, came.state, came.reference_speed),
            cloud=came.cloud,
            rangings=rangings,
            is_held=came.is_held,
        )

    def with_newest(
        self, snapshot: Snapshot, space: SpaceKnowledge | None, reference_speed: float
    ) -> Snapshot:
        """Return a snapshot with what its own cloud has just shown to come down."""
        observed = snapshot.observed
        if space is None or observed.cloud is None:
            return snapshot
        falling = self._falling(observed.motion, space)
        if np.array_equal(falling, observed.falling):
            return snapshot
        sinking = observed.columns[: len(observed.columns) - len(observed.falling)]
        columns = np.concatenate((sinking, falling))
        met = self._threats(observed.movers, columns, observed.state, reference_speed)
        return snapshot._replace(observed=observed._replace(columns=columns, falling=falling, threats=met))

    def clouds_show_loads(self, now: Motion, space: SpaceKnowledge | None) -> bool:
        """Return whether clouds come, and they show loads from afar, or none are to be expected here."""
        if space is None or not space.has_clouds:
            return False
        return space.looks_up or not self._sinking.is_in_the_open(now.stamp_s)

    def _falling(self, now: Motion, space: SpaceKnowledge | None) -> np.ndarray:
        """Return the discs (k, 8) that something comes down into, by clouds."""
        is_open = self._sinking.is_in_the_open(now.stamp_s)
        return space.columns(now, is_open) if space is not None else NO_COLUMNS

    def _threats(
        self, movers: np.ndarray, columns: np.ndarray, state: np.ndarray, reference_speed: float
    ) -> np.ndarray:
        """Return those of the movers and columns that the UAV may meet."""
        met = np.concatenate((movers, columns[:, :6])) if len(columns) else movers
        is_soon = is_hurried(columns, self._p.body_radius)
        evasion_m_s = evasion_speed(met, HURRIED_EVASION_M_S if is_soon else EVASION_M_S)
        fastest = max(evasion_m_s, reference_speed, math.hypot(state[0, 1], state[1, 1]))
        return threats(met, fastest, self._p.r_ub)

    def _scan_of(self, came: Came, space: SpaceKnowledge | None) -> SegmentedScan:
        """Return what moves and what stands in a scan.

        While clouds come that look all around, they tell what moves, for a planar scan passes over and under
        things. With late odometry the scan does: its pose is known later.
        """
        now, age_s, cloud = came.motion, came.age_s, came.cloud
        has_clouds = space is not None and space.has_clouds
        reads_clouds = self._reads_clouds and age_s <= LATE_S
        if cloud is not None and cloud.looks_all_around and reads_clouds:
            level = replace(now, orientation_xyzw=LEVEL)
            # With others what leans in and out of view would look like somebody who comes
            sees_past = space if space is not None and space.looks_up else None
            has_stood = sees_past.has_stood(now) if sees_past is not None else None
            slab = self._slab.beams(cloud, came.beams, now, has_stood), level, age_s, SLAB_RANGE_M
            return self._moving.take_in(*slab, False)
        counts = not (has_clouds and reads_clouds)
        return self._moving.take_in(came.beams, now, age_s, came.range_max, not has_clouds, counts)
