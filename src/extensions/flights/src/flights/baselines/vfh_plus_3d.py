"""3DVFH+ (Vanneste, Bellekens and Weyn, "Real-Time Three-Dimensional Obstacle Avoidance", MORSE 2014).

It is VFH+ in three dimensions: a polar histogram over azimuth and elevation, masking by what the vehicle can
fly, a binary histogram with hysteresis, a window that looks for openings, and the direction of least cost.
As published, what was never seen is free. Three things differ from the paper:

- A short memory of voxels takes the octomap's place. It forgets by age, not by seeing free space.
- A voxel fills the bins by their true angle to it, because bins are narrow near the poles.
- A multirotor can fly in any direction at once. So turning circles mask nothing, but climb and sink rates do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cepa import CepaParameters, Decision, LaserScan2D, Motion, Reason
from cepa.algorithm import Algorithm
from cepa.decision import Vector2
from cepa.motion import Cloud
from flight_basics.checks import check_limits, limited
from flights.errors import FlightError

HOVER = (0.0, 0.0)
_KEY_BITS = 20  # of a voxel's number along each axis


@dataclass(frozen=True)
class VfhPlus3dParameters:
    """The paper's parameters.

    alpha_deg: width of a bin. window_m: radius of the sphere around the vehicle that counts. voxel_m: edge of
    a voxel. memory_s: how long a voxel is kept. enlargement_m: r_{r+s+v}, the vehicle's radius plus the
    distance to keep plus a voxel's. near_weight: a, weight of a voxel at the vehicle; at the window's edge it
    is 1. low, high: thresholds tau of the binary histogram. opening: bins along each side of the window that
    must be free. mu: mu_1 to mu_3, cost of a direction's angle to the goal, to the direction of travel, and
    to the last choice. climb_m_s, sink_m_s: greatest rates, by default PX4's. lowest_m: least height over the
    odometry's origin; what is below the lidar's view is not known.
    """

    alpha_deg: float = limited(6.0, 2.0, 15.0)
    window_m: float = limited(4.0, above=0.0, most=100.0)
    voxel_m: float = limited(0.2, above=0.0)
    memory_s: float = limited(3.0, 0.0)
    enlargement_m: float = limited(0.8, above=0.0)
    near_weight: float = limited(5.0, 1.0)
    low: float = limited(1.0, above=0.0)
    high: float = limited(1.5, above=0.0)
    opening: int = 3
    mu: tuple[float, float, float] = (5.0, 2.0, 2.0)
    climb_m_s: float = limited(3.0, 0.0)
    sink_m_s: float = limited(1.0, 0.0)
    lowest_m: float = limited(0.8)

    def __post_init__(self) -> None:
        check_limits(self, FlightError, "3DVFH+'s {}")
        if 180.0 % self.alpha_deg:
            raise FlightError(f"3DVFH+ needs bins whose degrees divide 180, not {self.alpha_deg:g}.")
        if not self.voxel_m < self.enlargement_m < self.window_m:
            raise FlightError("3DVFH+ needs voxel_m < enlargement_m < window_m.")
        if self.low > self.high or not min(self.mu) >= 0.0:
            raise FlightError("3DVFH+ needs low <= high, and no negative mu.")
        if self.opening not in (1, 3, 5, 7):
            raise FlightError(f"3DVFH+ needs an opening of 1, 3, 5 or 7 bins, not {self.opening}.")


class VfhPlus3d(Algorithm):
    """Steers the reference velocity into the best opening, at its full speed, or stops when there is none.

    Without a cloud it steers by the scan alone, and stays level.
    """

    wants_cloud = True

    def __init__(
        self, parameters: CepaParameters | None = None, vfh_plus_3d: VfhPlus3dParameters | None = None
    ) -> None:
        """parameters: CEPA's, for what all algorithms do alike to a scan (dropouts, levelling)."""
        self._p = vfh_plus_3d or VfhPlus3dParameters()
        self._directions = bin_directions(self._p.alpha_deg)
        super().__init__(parameters)

    def reset(self) -> None:
        """Forget the voxels, the binary histogram and the last choice."""
        super().reset()
        self._blocked = np.zeros(self._directions.shape[:2], dtype=bool)
        self._memory = VoxelMemory(self._p)
        self._last: np.ndarray | None = None

    def _steer(
        self, scan: LaserScan2D, v_ref: Vector2, v_uav: Vector2, motion: Motion | None, cloud: Cloud | None
    ) -> Decision:
        points = self._points(scan, cloud)
        voxels = points if motion is None else self._memory.around(points, motion)
        self._blocked = self.binary(self.density(voxels), self._blocked)
        climb_ref, climbs = (0.0, 0.0) if motion is None else (motion.climb_ref_m_s, motion.velocity_m_s[2])
        reference, travel = np.array((*v_ref, climb_ref)), np.array((*v_uav, climbs))
        if not any(v_ref):
            return Decision(HOVER, False, 0.0, 0, Reason.NO_REFERENCE)
        if cloud is None:
            reference[2] = travel[2] = 0.0
        speed = float(np.linalg.norm(reference))
        goal = reference / speed
        can_fly = self.flyable(speed, motion) if cloud is not None else self._level()
        candidates = self.candidates(~self._blocked & can_fly, goal)
        if cloud is None:
            candidates = _levelled(candidates)
        if not len(candidates):
            self._last = None
            return Decision(HOVER, False, math.inf, 0, Reason.BLOCKED, climb_m_s=0.0)
        costs = self.costs(candidates, goal, travel)
        best = int(np.argmin(costs))
        self._last = candidates[best]
        x, y, z = (speed * self._last).tolist()
        reason = Reason.CUSHION_CLEAR if self._last @ goal > 1.0 - 1e-12 else Reason.STEERED
        climb = None if cloud is None else z
        return Decision((x, y), False, float(costs[best]), len(candidates), reason, climb_m_s=climb)

    def _points(self, scan: LaserScan2D, cloud: Cloud | None) -> np.ndarray:
        """Return the points of the cloud, or of the scan (n, 3), in the lidar's frame."""
        if cloud is not None:
            points = np.asarray(cloud.points_m, dtype=float)
            return points[np.isfinite(points).all(axis=1)]
        beams = self.beams(scan)
        met = beams.seen & np.isfinite(beams.ranges) & (beams.ranges < scan.range_max)
        r, angles = beams.ranges[met], beams.angles[met]
        return np.column_stack((r * np.cos(angles), r * np.sin(angles), np.zeros_like(r)))

    def density(self, points: np.ndarray) -> np.ndarray:
        """Return the primary polar histogram (elevations, azimuths) of points (n, 3), levelled.

        A voxel at distance d weighs a - b (d - r_{r+s+v}). It fills all bins within asin(r_{r+s+v} / d) of
        its direction, so that the vehicle may be thought of as a point.
        """
        p = self._p
        distances = np.linalg.norm(points, axis=1)
        near = (distances < p.window_m) & (distances > 1e-6)
        points, distances = points[near], distances[near]
        gaps = np.maximum(distances - p.enlargement_m, 0.0)
        weights = p.near_weight - (p.near_weight - 1.0) * gaps / (p.window_m - p.enlargement_m)
        sines = np.minimum(p.enlargement_m / distances, 1.0)
        towards = (points / distances[:, None]).astype(np.float32)
        cosines = self._directions.reshape(-1, 3).astype(np.float32) @ towards.T
        fills = cosines >= np.sqrt(1.0 - sines**2).astype(np.float32)
        return (fills.astype(np.float32) @ weights.astype(np.float32)).reshape(self._blocked.shape)

    def binary(self, density: np.ndarray, before: np.ndarray) -> np.ndarray:
        """Return which bins are blocked: above high yes, below low no, in between as before."""
        return (density > self._p.high) | ((density >= self._p.low) & before)

    def flyable(self, speed_m_s: float, motion: Motion | None) -> np.ndarray:
        """Return the bins in which the vehicle can fly at a speed: its rates, and its height in a second."""
        climb = speed_m_s * self._directions[:, :, 2]
        can = (climb <= self._p.climb_m_s) & (climb >= -self._p.sink_m_s)
        if motion is not None:
            can &= (climb >= 0.0) | (motion.position_m[2] + climb >= self._p.lowest_m)
        return can

    def _level(self) -> np.ndarray:
        half = math.radians(0.5 * (self._p.opening + 1) * self._p.alpha_deg)
        return np.abs(self._directions[:, :, 2]) < math.sin(half)

    def candidates(self, free: np.ndarray, goal: np.ndarray) -> np.ndarray:
        """Return the unit vectors (n, 3) in the middle of free windows; first the goal's, if it is free."""
        half = self._p.opening // 2
        rows, columns = free.shape
        open_ = np.zeros_like(free)
        wrapped = np.concatenate((free[:, columns - half :], free, free[:, :half]), axis=1)
        views = np.lib.stride_tricks.sliding_window_view(wrapped, (self._p.opening, self._p.opening))
        open_[half : rows - half] = views.all(axis=(2, 3))
        found = self._directions[open_]
        row, column = self._bin(goal)
        return np.vstack((goal, found)) if open_[row, column] else found

    def _bin(self, direction: np.ndarray) -> tuple[int, int]:
        rows, columns = self._blocked.shape
        alpha = math.pi / rows
        elevation = math.asin(min(max(direction[2], -1.0), 1.0))
        azimuth = math.atan2(direction[1], direction[0])
        row = min(int((elevation + 0.5 * math.pi) / alpha), rows - 1)
        return row, int((azimuth + math.pi) / alpha) % columns

    def costs(self, candidates: np.ndarray, goal: np.ndarray, travel_m_s: np.ndarray) -> np.ndarray:
        """Return the path weight of each direction (n,)."""
        speed = float(np.linalg.norm(travel_m_s))
        travel = travel_m_s / speed if speed > 0.1 else goal
        last = goal if self._last is None else self._last
        angles = np.arccos(np.clip(candidates @ np.stack((goal, travel, last)).T, -1.0, 1.0))
        return angles @ np.array(self._p.mu)


class VoxelMemory:
    """The voxels of the odometry's frame in which something was seen lately."""

    def __init__(self, parameters: VfhPlus3dParameters) -> None:
        self._p = parameters
        self._keys = np.empty(0, dtype=np.int64)
        self._stamps_s = np.empty(0)

    def around(self, points_m: np.ndarray, motion: Motion) -> np.ndarray:
        """Add points (n, 3) in the lidar's frame; return the voxels (m, 3) near it in its levelled frame."""
        p = self._p
        near = points_m[np.linalg.norm(points_m, axis=1) < p.window_m]
        here = np.array(motion.position_m)
        seen = _keys(np.floor((near @ motion.rotation().T + here) / p.voxel_m).astype(np.int64))
        keys = np.concatenate((seen, self._keys))
        stamps_s = np.concatenate((np.full(len(seen), motion.stamp_s), self._stamps_s))
        self._keys, newest = np.unique(keys, return_index=True)  # the first of equal keys: of this cloud
        self._stamps_s = stamps_s[newest]
        centres = (_indices(self._keys) + 0.5) * p.voxel_m - here
        kept = (motion.stamp_s - self._stamps_s <= p.memory_s) & (
            np.linalg.norm(centres, axis=1) < p.window_m
        )
        self._keys, self._stamps_s = self._keys[kept], self._stamps_s[kept]
        c, s = math.cos(motion.yaw_rad), math.sin(motion.yaw_rad)
        x, y, z = centres[kept].T
        return np.column_stack((c * x + s * y, c * y - s * x, z))


def bin_directions(alpha_deg: float) -> np.ndarray:
    """Return the unit vectors in the middle of the bins, (elevations, azimuths, 3), from -90 and -180 deg."""
    alpha = math.radians(alpha_deg)
    rows = round(180.0 / alpha_deg)
    elevations = (np.arange(rows) + 0.5) * alpha - 0.5 * math.pi
    azimuths = (np.arange(2 * rows) + 0.5) * alpha - math.pi
    level, up = np.cos(elevations)[:, None], np.sin(elevations)[:, None]
    return np.stack(
        np.broadcast_arrays(level * np.cos(azimuths), level * np.sin(azimuths), up + 0.0 * azimuths), axis=2
    )


def _levelled(directions: np.ndarray) -> np.ndarray:
    """Return the horizontal unit vectors below unit vectors (n, 3)."""
    flat = directions * (1.0, 1.0, 0.0)
    return flat / np.linalg.norm(flat, axis=1)[:, None]


def _keys(indices: np.ndarray) -> np.ndarray:
    """Pack voxel numbers (n, 3) into one whole number each, (n,)."""
    x, y, z = (indices + (1 << (_KEY_BITS - 1))).T
    return (x << (2 * _KEY_BITS)) | (y << _KEY_BITS) | z


def _indices(keys: np.ndarray) -> np.ndarray:
    mask = (1 << _KEY_BITS) - 1
    parts = (keys >> (2 * _KEY_BITS), (keys >> _KEY_BITS) & mask, keys & mask)
    return np.column_stack(parts) - (1 << (_KEY_BITS - 1))
