"""Finds returns of the UAV itself, such as its arms, legs or a cable: they move with it."""

from __future__ import annotations

import math

import numpy as np
from scipy import ndimage

REACH_M = 0.5
"""So far beyond the body's radius parts of the UAV are looked for."""
CELL_M = 0.05
MOST_CELLS = 20
"""Edge of the cells, fixed to the body, in which returns are counted: some times a lidar's noise. From the
middle to `near_m` there are so many at most, so they are larger for a large UAV.
"""
GAP_S = 0.5
"""A cell without a return for longer begins anew."""
STEADY_S = 2.0
"""Returns must have come from the same cell for so long."""
WAY_M, TURN_RAD, ON_THE_SPOT_M = 0.3, 0.5, 0.2
"""Meanwhile the UAV must have come so much nearer to the cell's place or gone away from it, or have turned so
far on the spot. Whatever stands would have left the cell. Flight along a wall, or around a pole, is neither.
"""
WAY_SHARE = 0.5
"""And by this share of the whole way. The edge of a column is up to 30 degrees from its middle."""
ANCHOR_S = 10.0
"""Within so long. The drift of an odometry is slower. A step of ON_THE_SPOT_M between two scans is a jump."""
JUDGED_S = 0.5
BEARINGS_APART_RAD = math.radians(10.0)


class OwnReturns:
    """Takes in what is near the body, and tells which of it belongs to the UAV.

    Within the body itself it need not move for that, because nothing else can be there. What goes on beyond
    `REACH_M`, as a wall does, is never the UAV's own. Neither is what ends where the sensor's view ends,
    unless it is within the body.

    Points are along the body's axes (x ahead, y left), from its middle at the height of the lidar.

    body_radius_m, below_m, above_m: how far the body reaches from there.
    """

    def __init__(self, body_radius_m: float, below_m: float, above_m: float) -> None:
        self.body_m, self.near_m = (body_radius_m, below_m, above_m), body_radius_m + REACH_M
        """Only returns within `near_m` are of interest."""
        self._cell_m = max(CELL_M, self.near_m / MOST_CELLS)
        self._side = 2 * math.ceil(self.near_m / self._cell_m) + 2
        middles = self._cell_m * (np.arange(self._side) + 0.5 - 0.5 * self._side)
        self._middles = np.stack(np.meshgrid(middles, middles, middles, indexing="ij"), -1).reshape(-1, 3)
        self._away_m = np.linalg.norm(self._middles, axis=1)
        x, y, z = self._middles.T
        self._is_inside = (np.hypot(x, y) < body_radius_m) & (-below_m <= z) & (z <= above_m)
        self.restart()

    def restart(self) -> None:
        """Forget everything, as after a clock that jumped back."""
        cells = self._side**3
        self._since_s, self._last_s = np.zeros(cells), np.full(cells, -math.inf)
        self._edge_s = np.full(cells, -math.inf)  # when a return came there from the edge of the view
        self._anchored_s = np.zeros(cells)
        self._anchors = np.zeros((cells, 7))  # way, place and heading then, as `_moved`
        self._is_own = np.zeros(cells, bool)
        self._beside_own: np.ndarray | None = None  # with the cells next to them
        self._found = np.zeros(cells, bool)  # all that were ever among these
        self.finds = 0
        """How often a part was found that was not known before."""
        self._moved = (0.0,) * 7  # way along the body's axes, place and heading in the odometry's frame
        self._judged_s = -math.inf
        self.bearings_deg: tuple[int, ...] = ()
        """Where the UAV sees itself, from its front to the left."""
        self.nearest_m = math.inf

    @property
    def is_seen(self) -> bool:
        """Whether the UAV sees itself."""
        return self._beside_own is not None

    def move(self, place_m: tuple[float, float, float], yaw_rad: float) -> None:
        """Take in the body's pose, before `take`. Without one only what is within the body is found."""
        last = self._moved
        turn_rad = math.remainder(yaw_rad - last[6], 2.0 * math.pi)
        c, s = math.cos(yaw_rad - 0.5 * turn_rad), math.sin(yaw_rad - 0.5 * turn_rad)
        x, y, z = (now - before for now, before in zip(place_m, last[3:6]))
        if math.hypot(x, y, z) > ON_THE_SPOT_M:
            x = y = z = 0.0
        way = last[0] + c * x + s * y, last[1] + c * y - s * x, last[2] + z
        self._moved = (*way, *place_m, last[6] + turn_rad)

    def take(self, time_s: float, points_m: np.ndarray, is_edge: np.ndarray | None = None) -> np.ndarray:
        """Take in points (n, 3) within `near_m`; return which of them belong to the UAV (n,).

        is_edge (n,): which are at the edge of what the sensor sees.
        """
        cells = self._cells(points_m)
        begin = cells[self._last_s[cells] < time_s - GAP_S]
        if len(begin):
            self._since_s[begin], self._is_own[begin], self._anchored_s[begin] = time_s, False, -math.inf
        late = cells[self._anchored_s[cells] < time_s - ANCHOR_S]
        if len(late):
            self._anchored_s[late], self._anchors[late] = time_s, self._moved
        self._last_s[cells] = time_s
        if is_edge is not None and is_edge.any():
            self._edge_s[cells[is_edge]] = time_s
        if abs(time_s - self._judged_s) >= JUDGED_S:
            self._judged_s = time_s
            self._judge(time_s)
        return np.zeros(len(cells), bool) if self._beside_own is None else self._beside_own[cells]

    def _cells(self, points_m: np.ndarray) -> np.ndarray:
        x, y, z = (points_m / self._cell_m + 0.5 * self._side).astype(np.intp).T
        cells: np.ndarray = (x * self._side + y) * self._side + z
        return cells

    def _judge(self, time_s: float) -> None:
        seen = np.flatnonzero(self._last_s >= time_s - GAP_S)
        steady = seen[time_s - self._since_s[seen] >= STEADY_S]
        if len(steady):
            new = self._is_inside[steady] | self._has_moved_with(steady)
            if (new & ~self._is_own[steady]).any():
                self._is_own[steady[new]] = self._ends(seen, time_s)[steady[new]]
        own = steady[self._is_own[steady]]
        self._tell(own)

    def _has_moved_with(self, cells: np.ndarray) -> np.ndarray:
        """Whether the UAV has moved so that what stands would have left these cells."""
        moved = np.array(self._moved) - self._anchors[cells]
        along_m = np.einsum("ij,ij->i", moved[:, :3], self._middles[cells]) / self._away_m[cells]
        is_on_the_spot = np.linalg.norm(moved[:, 3:6], axis=1) < ON_THE_SPOT_M
        turned_rad = np.abs((moved[:, 6] + math.pi) % (2.0 * math.pi) - math.pi)
        least_m = np.maximum(WAY_M, WAY_SHARE * np.linalg.norm(moved[:, :3], axis=1))
        has_moved: np.ndarray = (np.abs(along_m) > least_m) | is_on_the_spot & (turned_rad > TURN_RAD)
        return has_moved

    def _ends(self, seen: np.ndarray, time_s: float) -> np.ndarray:
        """Return of which cells (side**3,) the things end nearby, and within what the sensor sees."""
        shape = (self._side,) * 3
        is_seen = np.zeros(shape, bool)
        is_seen.ravel()[seen] = True
        parts = ndimage.label(is_seen, np.ones((3, 3, 3)))[0].ravel()
        goes_on = parts[seen[self._away_m[seen] > self.near_m - 2.0 * self._cell_m]]
        at_edge = parts[seen[self._edge_s[seen] >= time_s - GAP_S]]
        ends: np.ndarray = ~np.isin(parts, goes_on) & (self._is_inside | ~np.isin(parts, at_edge))
        return ends

    def _tell(self, own: np.ndarray) -> None:
        if not len(own):
            self._beside_own, self.bearings_deg, self.nearest_m = None, (), math.inf
            return
        grid = np.zeros((self._side,) * 3, bool)
        grid.ravel()[own] = True
        self._beside_own = ndimage.binary_dilation(grid, np.ones((3, 3, 3))).ravel()
        self.finds += not self._found[own].all()
        self._found |= self._beside_own
        x, y, _ = self._middles[own].T
        bearings = np.sort(np.arctan2(y, x))
        groups = np.split(bearings, np.flatnonzero(np.diff(bearings) > BEARINGS_APART_RAD) + 1)
        self.bearings_deg = tuple(round(math.degrees(float(group.mean()))) for group in groups)
        self.nearest_m = float(np.hypot(x, y).min())
