"""What a planar lidar gets wrong: rain, a part of the view that is lost, and glass."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flights.worlds.drawn.barriers import GLASS
from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Box, World
from simulation_tools.sensors.lidar import Lidar, Rays

ALL_ANGLES_DEG = 90.0
"""A pane that answers at all angles is like any other wall."""
TURNS_S = 0.1, 0.5
"""So long the same part of the view is lost, before another part is."""
_SAME_M = 0.03
_PANES_IN_A_ROW = 6


@dataclass(frozen=True)
class Pane:
    """An upright pane that is higher than the flight, from above, in the world."""

    middle_xy: np.ndarray
    """(2,) m"""
    normal_xy: np.ndarray
    """(2,): a unit vector."""
    half_m: float
    """Half its length."""

    def ranges(self, origin_xy: np.ndarray, directions_xy: np.ndarray) -> np.ndarray:
        """Return how far along each direction (n, 2) the pane is (n,), m; inf where a beam misses it."""
        towards = directions_xy @ self.normal_xy
        along = np.array((-self.normal_xy[1], self.normal_xy[0]))
        with np.errstate(divide="ignore", invalid="ignore"):
            ranges = ((self.middle_xy - origin_xy) * self.normal_xy).sum(axis=-1) / towards
            places = origin_xy + ranges[:, None] * directions_xy
            hits = (ranges > 0.0) & (np.abs((places - self.middle_xy) @ along) <= self.half_m)
        return np.where(hits, ranges, np.inf)


def panes_of(world: World) -> list[Pane]:
    """Return the panes of a world: the boxes of models whose names begin with GLASS."""
    panes = []
    for model in world.models:
        if not model.name.startswith(GLASS):
            continue
        for link in model.links:
            for collision in link.collisions:
                if isinstance(collision.geometry, Box):
                    pose = model.pose @ link.pose @ collision.pose
                    length_m, depth_m, _ = collision.geometry.size_m
                    normal = pose.rotation[:2, 1] if length_m > depth_m else pose.rotation[:2, 0]
                    middle = np.array(pose.position_m[:2])
                    panes.append(Pane(middle, normal, max(length_m, depth_m) / 2))
    return panes


class LidarFaults:
    """Spoils the scans of one flight.

    rain: share of the beams that end somewhere before what stands there. lost_view: share of the view in
    which nothing returns, by turns. glass_deg: greatest angle between a beam and a pane's normal at which the
    pane answers; other beams pass through.
    """

    def __init__(
        self,
        rain: float,
        lost_view: float,
        glass_deg: float,
        panes: list[Pane],
        lidar: Lidar,
        rng: np.random.Generator,
    ):
        """panes: of the world. rng: of rain and view."""
        self._rain, self._lost_view = rain, lost_view
        self._least_cos = math.cos(math.radians(glass_deg))
        self._panes = panes if glass_deg < ALL_ANGLES_DEG else []
        self._lidar, self._rng = lidar, rng
        self._until_s, self._lost = -math.inf, slice(0, 0)

    @property
    def are_any(self) -> bool:
        """Whether a scan changes at all."""
        return bool(self._rain or self._lost_view or self._panes)

    def spoiled(
        self, ranges: np.ndarray, t_s: float, rays: Rays, body: Pose, own_model: str | None
    ) -> np.ndarray:
        """Return what the lidar gives in place of ``ranges`` (beams,), m. body: the UAV's true pose."""
        ranges = ranges.copy()
        if self._panes:
            self._see_through(ranges, rays, body @ self._lidar.pose_in_body, own_model)
        if self._rain:
            wet = np.flatnonzero(self._rng.random(len(ranges)) < self._rain)
            ends_m = np.clip(ranges[wet], self._lidar.range_min, self._lidar.range_max)
            ranges[wet] = self._rng.uniform(self._lidar.range_min, ends_m)
        if self._lost_view:
            if t_s >= self._until_s:
                width = round(self._lost_view * len(ranges))
                first = int(self._rng.integers(0, len(ranges) - width + 1))
                self._lost = slice(first, first + width)
                self._until_s = t_s + self._rng.uniform(*TURNS_S)
            ranges[self._lost] = np.inf
        return ranges

    def _see_through(self, ranges: np.ndarray, rays: Rays, pose: Pose, own_model: str | None) -> None:
        """Give the beams that no pane answers the range of what stands behind."""
        directions = self._lidar.directions @ pose.rotation.astype(np.float32).T
        origins = np.broadcast_to(np.array(pose.position_m, np.float32), directions.shape).copy()
        farthest_m, way_m = self._lidar.range_max, np.zeros(len(ranges), np.float32)
        passing = np.arange(len(ranges))
        for _ in range(_PANES_IN_A_ROW):
            pane_m, towards = self._nearest_panes(origins[passing], directions[passing])
            at_pane = np.isfinite(pane_m)
            passing, pane_m, towards = passing[at_pane], pane_m[at_pane], towards[at_pane]
            if not len(passing):
                return
            first_m = rays.cast(origins[passing], directions[passing], farthest_m, own_model)
            unseen = (np.abs(first_m - pane_m) < _SAME_M) & (towards < self._least_cos)
            passing, first_m, towards = passing[unseen], first_m[unseen], towards[unseen]
            beyond_m = first_m + _SAME_M / np.maximum(towards, 0.05)
            origins[passing] += beyond_m[:, None] * directions[passing]
            way_m[passing] += beyond_m
            behind_m = way_m[passing] + rays.cast(
                origins[passing], directions[passing], farthest_m, own_model
            )
            ranges[passing] = np.where(behind_m < farthest_m, behind_m, np.inf)

    def _nearest_panes(self, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the range (n,) m of the nearest pane on each beam, and the cosine (n,) of its incidence."""
        nearest_m, towards = np.full(len(origins), np.inf), np.ones(len(origins))
        for pane in self._panes:
            pane_m = pane.ranges(origins[:, :2], directions[:, :2])
            nearer = pane_m < nearest_m
            nearest_m[nearer] = pane_m[nearer]
            towards[nearer] = np.abs(directions[nearer, :2] @ pane.normal_xy)
        return nearest_m, towards
