"""Finds what moves in planar scans, and how fast."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Sequence

import numpy as np

from cepa.dynamic.lookout import SIGHT_BINS, Seen
from cepa.errors import ParameterError
from cepa.kernels import movers as kernels
from cepa.kernels.evidence import are_free, have_moved
from cepa.kernels.sight import clear_of


@dataclass(frozen=True)
class MoverParameters:
    """What counts as moving. Raises ParameterError for a value that is not above 0."""

    cluster_gap_m: float = 0.3
    """Points that are farther apart belong to different things."""
    least_points: int = 3
    greatest_radius_m: float = 2.6
    """A larger thing, such as a wall, is taken as standing."""
    deviation_m: float = 0.05
    """Standard deviation of a thing's middle, with that of the odometry from scan to scan."""
    deviation_hidden_m: float = 0.3
    """The same where something hides a part of it."""
    acceleration_m_s2: float = 0.6
    """How much a velocity changes within 1 s, standard deviation."""
    speed_first_m_s: float = 1.0
    """Standard deviation of the velocity of what appears."""
    gate_m: float = 0.3
    """How far from its predicted place a thing is looked for, beyond three standard deviations."""
    free_gap_m: float = 0.2
    """A place was free if a beam went so much farther."""
    share: float = 0.2
    """Share of a thing's points that must be where it was free."""
    speed_min_m_s: float = 0.35
    """Slower things stand."""
    significance: float = 2.0
    """A velocity counts if it is so many times its standard deviation."""
    evidence_s: float = 0.07
    """How long the evidence must last."""
    floor_gap_m: float = 0.3
    """What is so near to floor or ceiling is not tracked: both seem to move when the lidar tilts."""
    floor_gap_share: float = 0.03
    """Added to that for each metre of distance, for the errors of the attitude."""
    forget_s: float = 1.0
    """What moves is predicted so long where nobody sees it."""

    def __post_init__(self) -> None:
        for field in fields(self):
            if not getattr(self, field.name) > 0.0:
                value = getattr(self, field.name)
                raise ParameterError(f"The movers' {field.name} must be above 0, not {value!r}.")


@dataclass(frozen=True, eq=False)
class MoverSet:
    """What moves at a scan, in the odometry's frame."""

    positions: np.ndarray
    """(k, 2) m: of the middles."""
    velocities: np.ndarray
    """(k, 2) m/s"""
    radii: np.ndarray
    """(k,) m"""
    covariances: np.ndarray
    """(k, 2, 2): of position and velocity along any axis."""
    is_moving: np.ndarray
    """(n,) bool: which of the scan's points belong to what moves."""

    def discs(self, origin_xy: np.ndarray, deviations: float = 2.0) -> np.ndarray:
        """Return what moves as growing discs (k, 6): x, y, vx, vy, radius, growth of the radius in m/s.

        The positions count from ``origin_xy``. A disc holds the thing with so many standard deviations.
        """
        spread = deviations * np.sqrt(self.covariances[:, [0, 1], [0, 1]])
        return np.column_stack(
            (self.positions - origin_xy, self.velocities, self.radii + spread[:, 0], spread[:, 1])
        )


TRACKS_MAX, CLUSTERS_MAX = 192, 256
FRAMES, FRAME_PERIOD_S, YOUNGEST_S = 12, 0.1, 0.15
"""Earlier scans that tell what was free, the time between them, and the least age."""
STANDING_FORGET_S, MISSED_S = 0.3, 0.15
"""How long what stands is kept unseen, and anything where the scan sees past its place."""
STANDING_MIN = 4
"""So many standing things tell how the odometry drifts."""
RADIUS_MEMORY_S, SIDES_LEARNING_S = 2.0, 1.0
EVIDENCE_MAX_S = 0.5
LOSS_OF_FAST, LOSS_OF_SLOW = 0.1, 0.5
"""What the evidence loses in a second in which something fast, or slow, does not show that it has moved."""
LONG_M = 0.6
"""Of a thing with a larger radius, only an end enters what was free."""
SAMPLES = 12
LONGEST_STEP_S = 0.5
NO_VECTORS, NO_RADII, NO_COVARIANCES = np.empty((0, 2)), np.empty(0), np.empty((0, 2, 2))
BESIDE_M = 0.15
"""A point so near to a moving thing's rim belongs to it."""


class Movers:
    """Tracks things from scan to scan with a Kalman filter of constant velocity each.

    A thing moves if its velocity is significant and a place shows it: the thing is where earlier scans saw
    nothing, or gone from where they saw it. The velocity alone does not tell, because the visible side of a
    trunk changes while the UAV passes.
    """

    def __init__(self, parameters: MoverParameters | None = None):
        self.parameters = parameters or MoverParameters()
        self._clusters = np.empty((CLUSTERS_MAX, kernels.CLUSTER_COLUMNS))
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._tracks = np.empty((0, kernels.TRACK_COLUMNS))
        self._surfaces = np.empty((0, FRAMES, 2))
        self._moving = np.empty(0, bool)
        self._stamp_s = math.nan
        self._frames_s = np.full(FRAMES, -math.inf)
        self._frames = np.zeros((FRAMES, 3))
        self._frames_bins = np.full((FRAMES, SIGHT_BINS), -1.0)
        self._frames_seen: dict[int, Seen] = {}
        self._frame, self._frame_s = 0, -math.inf
        self._waiting: deque[tuple[int, float, Sequence[float], Seen]] = deque(maxlen=FRAMES)
        self._turn, self._shift = 0.0, (0.0, 0.0)

    def clear_of_floor(self, points: np.ndarray, floor_m: float, ceiling_m: float) -> np.ndarray:
        """Return which ``points`` (n, 3), m, from the lidar, belong neither to floor nor ceiling (n,).

        floor_m, ceiling_m: their heights above the lidar.
        """
        p, is_level = self.parameters, np.empty(len(points), np.bool_)
        clear_of(points, floor_m, ceiling_m, p.floor_gap_m, p.floor_gap_share, is_level)
        return is_level

    def update(
        self,
        stamp_s: float,
        points_m: np.ndarray,
        sensor_xy: Sequence[float],
        seen: Seen,
        is_level: np.ndarray | None = None,
    ) -> MoverSet:
        """Return what moves at a scan.

        points_m: (n, 2 or 3), from the lidar along the odometry's axes, the ends of the beams that hit
        something, in the order of the beams; their height does not count. sensor_xy: m, the lidar in the
        odometry's frame. seen: how far the scan sees, and how far its beams stay near the lidar's height. A
        beam that passes over a thing shows neither that it is gone, nor that it was not there, nor how wide
        it is. is_level: (n,) bool, which points belong neither to floor nor ceiling (`clear_of_floor`); None:
        all. After a clock that went back, or LONGEST_STEP_S without a scan, everything is forgotten.
        """
        dt_s = stamp_s - self._stamp_s
        if not 0.0 < dt_s <= LONGEST_STEP_S:
            self.reset()
            dt_s = 0.0
        self._stamp_s = stamp_s
        p = self.parameters
        level = np.ones(len(points_m), bool) if is_level is None else is_level
        if not len(self._tracks) and not (len(level) and level.any()):
            if self._is_frame_due():
                self._waiting.append((self._next_frame(), stamp_s, sensor_xy, seen))
            return nothing_moves(len(level))
        self._take_in()
        points, (x_m, y_m), (shift_x_m, shift_y_m) = np.empty((len(level), 2)), sensor_xy, self._shift
        count = kernels.laid(points_m, level, x_m, y_m, self._turn, shift_x_m, shift_y_m, points)
        points = points[:count]
        pose, sight_m, level_m = self._pose(sensor_xy), seen.reach_m, seen.level_m
        labels = np.empty(len(points), np.int64)
        limits = p.cluster_gap_m, p.least_points, p.greatest_radius_m
        found = kernels.segment(points, pose, sight_m, level_m, *limits, self._clusters, labels)
        clusters = self._clusters[:found]
        kernels.predict(self._tracks, dt_s, p.acceleration_m_s2)
        matches = np.empty(len(clusters), np.int64)
        owners = np.empty(len(self._tracks), np.int64)
        kernels.associate(clusters, self._tracks, p.gate_m, matches, owners)
        self._align(dt_s, points, pose, clusters, owners)
        self._learn(dt_s, points, pose, seen, clusters, owners)
        owners = self._forget(pose, np.minimum(sight_m, level_m), owners)
        owners = self._begin(clusters, matches, owners)
        if self._moving.any():
            self._find_again()
        if self._is_frame_due():
            self._keep_surfaces(clusters, owners)
            self._keep_frame(self._next_frame(), stamp_s, pose, seen)
        if not self._moving.any():
            return nothing_moves(len(level))
        return self._answer(points, labels, level, owners)

    def _pose(self, sensor_xy: Sequence[float]) -> np.ndarray:
        """Return the lidar's place and the turn of the odometry's axes (3,), without its drift."""
        return np.array([*_moved(sensor_xy, self._turn, self._shift), self._turn])

    def _align(
        self, dt_s: float, points: np.ndarray, pose: np.ndarray, clusters: np.ndarray, owners: np.ndarray
    ) -> None:
        """Lay the scan on what stands, and keep what that says of the odometry's drift."""
        motion = np.empty(3)
        x, y, _ = pose.tolist()
        standing = clusters, self._tracks, owners, self._moving, points, pose
        if not kernels.align(*standing, dt_s, STANDING_MIN, motion):
            return
        along_x, along_y, turn = motion.tolist()
        from_lidar = self._shift[0] - x, self._shift[1] - y
        self._shift = _moved(from_lidar, turn, (x + along_x, y + along_y))
        self._turn += turn

    def _learn(
        self,
        dt_s: float,
        points: np.ndarray,
        pose: np.ndarray,
        seen: Seen,
        clusters: np.ndarray,
        owners: np.ndarray,
    ) -> None:
        p = self.parameters
        shares = math.exp(-dt_s / RADIUS_MEMORY_S), 1.0 - math.exp(-dt_s / SIDES_LEARNING_S)
        scan = clusters, owners, points, pose
        kernels.correct(self._tracks, *scan, p.deviation_m, p.deviation_hidden_m, *shares)
        tracks, is_fast = self._tracks, np.empty(len(owners), np.bool_)
        kernels.are_fast(tracks, owners, p.speed_min_m_s, p.significance, is_fast)
        shown = is_fast.copy()
        if is_fast.any():
            larger = np.maximum(1.0, tracks[:, kernels.RADIUS] / LONG_M)
            things = points, clusters[:, : kernels.MIDDLE_X], larger, owners, self._surfaces
            frames = self._frames, self._bins_of_frames(), self._stamp_s - self._frames_s
            have_moved(
                *things, pose, seen.shown_m, *frames, YOUNGEST_S, p.free_gap_m, p.share, SAMPLES, shown
            )
        losses, limits = (LOSS_OF_FAST, LOSS_OF_SLOW), (p.evidence_s, EVIDENCE_MAX_S, p.speed_min_m_s)
        kernels.weigh(tracks, owners, is_fast, shown, dt_s, losses, *limits, self._moving)

    def _forget(self, pose: np.ndarray, sight_m: np.ndarray, owners: np.ndarray) -> np.ndarray:
        """Drop what has not been seen for long, or is not where it should be seen.

        Returns the clusters (t,) of the tracks that stay, or -1.
        """
        unseen_s, free = self._tracks[:, kernels.UNSEEN], np.empty(len(owners), bool)
        are_free(self._tracks[:, : kernels.VX], pose, sight_m, self.parameters.free_gap_m, free)
        allowed_s = np.where(self._moving, self.parameters.forget_s, STANDING_FORGET_S)
        stays = unseen_s <= np.where(free, MISSED_S, allowed_s)
        if stays.all():
            return owners
        self._tracks, self._surfaces = self._tracks[stays], self._surfaces[stays]
        self._moving = self._moving[stays]
        return owners[stays]

    def _begin(self, clusters: np.ndarray, matches: np.ndarray, owners: np.ndarray) -> np.ndarray:
        """Begin a track for each cluster without one; return the clusters (t,) of all tracks, or -1."""
        new = np.flatnonzero(matches < 0)[: TRACKS_MAX - len(self._tracks)]
        if new.size == 0:
            return owners
        p = self.parameters
        tracks = np.zeros((new.size, kernels.TRACK_COLUMNS))
        tracks[:, kernels.X] = clusters[new, kernels.MIDDLE_X]
        tracks[:, kernels.Y] = clusters[new, kernels.MIDDLE_Y]
        tracks[:, kernels.PP] = p.deviation_m**2
        tracks[:, kernels.VV] = p.speed_first_m_s**2
        tracks[:, kernels.RADIUS] = clusters[new, kernels.SIZE]
        tracks[:, kernels.REACH :] = math.nan
        self._tracks = np.concatenate((self._tracks, tracks))
        self._surfaces = np.concatenate((self._surfaces, np.full((new.size, FRAMES, 2), math.nan)))
        self._moving = np.concatenate((self._moving, np.zeros(new.size, bool)))
        return np.concatenate((owners, new))

    def _find_again(self) -> None:
        """Let what appears near a moving thing that is out of sight move on as that did."""
        tracks = self._tracks
        unseen = tracks[:, kernels.UNSEEN] > 0.0
        unknown = ~unseen & ~self._moving & (tracks[:, kernels.VV] > 0.5 * self.parameters.speed_first_m_s**2)
        for lost in tracks[self._moving & unseen]:
            reach_m = lost[kernels.RADIUS] + self.parameters.gate_m + 3.0 * math.sqrt(lost[kernels.PP])
            apart_m = np.hypot(tracks[:, kernels.X] - lost[kernels.X], tracks[:, kernels.Y] - lost[kernels.Y])
            found = unknown & (apart_m < reach_m) & (tracks[:, kernels.RADIUS] < 1.5 * lost[kernels.RADIUS])
            tracks[found, kernels.VX : kernels.RADIUS + 1] = lost[kernels.VX : kernels.RADIUS + 1]
            tracks[found, kernels.EVIDENCE] = lost[kernels.EVIDENCE]
            self._moving |= found

    def _bins_of_frames(self) -> np.ndarray:
        """Return how far earlier scans have shown that nothing stands (FRAMES, SIGHT_BINS), m."""
        for frame, seen in self._frames_seen.items():
            self._frames_bins[frame] = seen.shown_m
        self._frames_seen.clear()
        return self._frames_bins

    def _is_frame_due(self) -> bool:
        return self._stamp_s - self._frame_s >= FRAME_PERIOD_S - 1e-6

    def _keep_surfaces(self, clusters: np.ndarray, owners: np.ndarray) -> None:
        """Keep where each track is seen, for the next frame."""
        is_seen = owners >= 0
        self._surfaces[:, self._frame] = math.nan
        surfaces = clusters[owners[is_seen], kernels.SURFACE_X : kernels.SURFACE_Y + 1]
        self._surfaces[is_seen, self._frame] = surfaces

    def _next_frame(self) -> int:
        frame, self._frame_s = self._frame, self._stamp_s
        self._frame = (frame + 1) % FRAMES
        return frame

    def _keep_frame(self, frame: int, stamp_s: float, pose: np.ndarray, seen: Seen) -> None:
        self._frames_s[frame], self._frames[frame], self._frames_seen[frame] = stamp_s, pose, seen

    def _take_in(self) -> None:
        """Take in the frames that waited while there was nothing to track. The drift stayed as it is."""
        for frame, stamp_s, sensor_xy, seen in self._waiting:
            self._keep_frame(frame, stamp_s, self._pose(sensor_xy), seen)
        self._waiting.clear()

    def _answer(
        self, points: np.ndarray, labels: np.ndarray, level: np.ndarray, owners: np.ndarray
    ) -> MoverSet:
        moving = self._tracks[self._moving]
        clusters = owners[self._moving]
        belongs = np.isin(labels, clusters[clusters >= 0])
        for track in moving:
            distances = np.hypot(points[:, 0] - track[kernels.X], points[:, 1] - track[kernels.Y])
            belongs |= distances < track[kernels.RADIUS] + BESIDE_M
        is_moving = np.zeros(len(level), bool)
        is_moving[level] = belongs
        covariances = moving[:, [kernels.PP, kernels.PV, kernels.PV, kernels.VV]].reshape(-1, 2, 2)
        c, s = math.cos(self._turn), math.sin(self._turn)
        back = np.array([[c, -s], [s, c]])  # a row times it is turned back
        positions = (moving[:, kernels.X : kernels.Y + 1] - self._shift) @ back
        velocities = moving[:, kernels.VX : kernels.VY + 1] @ back
        return MoverSet(positions, velocities, moving[:, kernels.RADIUS], covariances, is_moving)


@lru_cache(maxsize=1)
def nothing_moves(points: int) -> MoverSet:
    """Return that none of so many points moves; nobody changes it."""
    return MoverSet(NO_VECTORS, NO_VECTORS, NO_RADII, NO_COVARIANCES, np.zeros(points, bool))


def _moved(place_xy: Sequence[float], turn_rad: float, shift_m: tuple[float, float]) -> tuple[float, float]:
    """Return a place that is turned about the origin, and then shifted."""
    (x, y), c, s = place_xy, math.cos(turn_rad), math.sin(turn_rad)
    return c * x - s * y + shift_m[0], s * x + c * y + shift_m[1]
