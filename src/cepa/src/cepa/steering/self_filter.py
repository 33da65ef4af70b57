"""Returns of the UAV itself in scans and clouds: they are told, and left out if that is asked."""

from __future__ import annotations

import dataclasses
import math
from typing import Callable

import numpy as np

from cepa.parameters import CepaParameters
from cepa.scan import LaserScan2D
from cepa.steering.mount import Mount, into_body
from cepa.steering.own_motion import OwnState, yaw_of
from input_checks.own_returns import OwnReturns

LOOKED_S = 0.09
"""So often it looks for them: every tenth of a second."""


class SelfFilter:
    """Looks for the UAV's own arms, legs and cables in what its sensors see.

    warn: takes a sentence whenever they are seen. on_left_out: called when a part of the UAV is left out from
    now on, so that what was remembered of it can be forgotten.
    """

    def __init__(self, warn: Callable[[str], None], on_left_out: Callable[[], None]) -> None:
        self._warn, self._on_left_out = warn, on_left_out
        self._returns: OwnReturns | None = None
        self._leaves_out = False
        self._left_out = 0  # parts that were told as left out
        self._looked_s: dict[str, float] = {}

    def restart(self) -> None:
        """Forget everything, as after a clock that jumped back."""
        self._returns, self._left_out = None, 0
        self._looked_s.clear()

    @property
    def obstructs(self) -> bool:
        """Whether the UAV itself counts as an obstacle, so that nobody can say what holds it up."""
        return self._sees_itself and not self._leaves_out

    @property
    def _sees_itself(self) -> bool:
        return self._returns is not None and self._returns.is_seen

    def move(self, state: OwnState | None, parameters: CepaParameters) -> None:
        """Take in the UAV's pose for the next scan, and whether its own returns are to be left out."""
        p, self._leaves_out = parameters, parameters.self_filter
        body_m = p.body_radius, p.body_below, p.body_above
        if self._returns is None or self._returns.body_m != body_m:
            self._returns = OwnReturns(*body_m)
        yaw_rad = yaw_of(state)
        if state is not None and yaw_rad is not None and all(map(math.isfinite, state.position_m)):
            self._returns.move(state.position_m, yaw_rad)

    def scan(self, time_s: float, scan: LaserScan2D, mount: Mount) -> LaserScan2D:
        """Return the scan, in which beams that end on the UAV itself are unseen if that is asked."""
        assert self._returns is not None  # since move
        assert scan.seen is not None  # since __post_init__
        if not self._is_due("scan", time_s):
            return scan
        reach_m = self._returns.near_m + math.hypot(*mount.position_m[:2])
        near = np.flatnonzero(scan.ranges < reach_m)
        near = near[scan.seen[near] & ((scan.ranges[near] > 0.0) | (scan.ranges[near] == -math.inf))]
        if not (len(near) or self._sees_itself):
            return scan
        angles, ranges = scan.angle_min + near * scan.angle_increment, scan.ranges[near]
        ranges = np.where(ranges > 0.0, ranges, scan.range_min)  # too near for the lidar
        points = np.stack((ranges * np.cos(angles), ranges * np.sin(angles), np.zeros(len(near))), axis=1)
        is_own = self._own(time_s, points, mount, _at_edge(scan, near))
        if self._returns.is_seen:
            self._tell(self._returns)
        if not (self._leaves_out and is_own.any()):
            return scan
        seen = scan.seen.copy()
        seen[near[is_own]] = False
        return dataclasses.replace(scan, seen=seen)

    def cloud(
        self, time_s: float, points_m: np.ndarray, mount: Mount
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """Return the points (n, 3) of a sensor that looks all around, and those that are the UAV's own.

        points_m: in the frame of the lidar with this mount. Left out are none if that is not asked.
        """
        assert self._returns is not None
        if not self._is_due("cloud", time_s):
            return points_m, None
        reach_m = self._returns.near_m + math.hypot(*mount.position_m[:2])
        near = np.flatnonzero(np.einsum("ij,ij->i", points_m, points_m) < reach_m**2)
        if not len(near):
            return points_m, None
        own = near[self._own(time_s, points_m[near], mount)]
        if not (self._leaves_out and len(own)):
            return points_m, None
        others = points_m.copy()
        others[own] = math.nan
        return others, points_m[own]

    def _is_due(self, source: str, time_s: float) -> bool:
        """Whether to look at what a source shows: at every message only while something is left out."""
        leaves_out = self._leaves_out and self._sees_itself
        if not leaves_out and abs(time_s - self._looked_s.get(source, -math.inf)) < LOOKED_S:
            return False
        self._looked_s[source] = time_s
        return True

    def _own(
        self, time_s: float, points_m: np.ndarray, mount: Mount, is_edge: np.ndarray | None = None
    ) -> np.ndarray:
        """Return which points (n, 3) of the lidar's frame are the UAV's own (n,)."""
        assert self._returns is not None
        points = into_body(points_m, mount) - (0.0, 0.0, mount.position_m[2])
        is_near = np.einsum("ij,ij->i", points, points) < self._returns.near_m**2
        is_own = np.zeros(len(points), bool)
        edge = None if is_edge is None else is_edge[is_near]
        is_own[is_near] = self._returns.take(time_s, points[is_near], edge)
        return is_own

    def _tell(self, found: OwnReturns) -> None:
        is_new, self._left_out = found.finds > self._left_out, found.finds if self._leaves_out else 0
        what = (
            f"The lidar sees something within the UAV's own body or moving with it, {found.nearest_m:.2f} m "
            f"away at {', '.join(map(str, found.bearings_deg))} degrees (0: ahead, 90: left)"
        )
        if not self._leaves_out:
            self._warn(
                f"{what}: an arm, a leg, a cable? It counts as an obstacle. Set self_filter to true to leave "
                "it out, or mount the lidar so that it does not see it."
            )
        elif is_new:
            self._on_left_out()
            self._warn(f"{what}. It is left out (self_filter), and what is behind it is unseen.")


def _at_edge(scan: LaserScan2D, beams: np.ndarray) -> np.ndarray:
    """Return which of these beams (n,) have a neighbour that sees nothing because no sensor looks there."""
    assert scan.seen is not None
    count = scan.ranges.size
    is_edge = ~(scan.seen[beams - 1] & scan.seen[(beams + 1) % count])
    if count < scan.beams_per_turn:
        is_edge |= (beams == 0) | (beams == count - 1)
    return is_edge
