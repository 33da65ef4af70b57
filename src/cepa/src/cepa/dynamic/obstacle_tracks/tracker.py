"""Tracks things from scan to scan, and tells which of them move."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from cepa.dynamic.constants.obstacle_tracks import (
    BESIDE_DISC_M,
    CLUSTERS_MAX,
    EVIDENCE_LEFT,
    EVIDENCE_LOSS_OF_FAST,
    EVIDENCE_LOSS_OF_SLOW,
    EVIDENCE_MAX_S,
    EVIDENCE_SAMPLES,
    EVIDENCE_SCANS,
    EVIDENCE_YOUNGEST_S,
    FORGET_BEHIND_S,
    LONG_M,
    LONGEST_SCAN_GAP_S,
    MISSED_S,
    RADIUS_MEMORY_S,
    SIDES_LEARNING_S,
    STANDING_FORGET_S,
    STANDING_MIN,
    TRACKS_MAX,
)
from cepa.dynamic.free_space.free_ranges import FreeRanges
from cepa.dynamic.free_space.kernels.beams import clear_of
from cepa.dynamic.obstacle_tracks.drift import RecentDrift
from cepa.dynamic.obstacle_tracks.frames import Frames, plane_of
from cepa.dynamic.obstacle_tracks.kernels import columns
from cepa.dynamic.obstacle_tracks.kernels.clusters import placed, segment
from cepa.dynamic.obstacle_tracks.kernels.drift import align
from cepa.dynamic.obstacle_tracks.kernels.evidence import are_behind, are_free, have_moved
from cepa.dynamic.obstacle_tracks.kernels.tracks import are_fast, associate, correct, predict, weigh
from cepa.dynamic.obstacle_tracks.tracks import MovingTracks, TrackerParameters, nothing_moves
from cepa.motion import DOUBTED, Doubt

UPRIGHT = np.array([1.0, 0.0, 0.0])
"""Times a scan's plane: only the lidar's height is left."""


class ObstacleTracker:
    """Tracks things from scan to scan with a Kalman filter of constant velocity each.

    A thing moves if its velocity is significant and a place shows it: the thing is where earlier scans saw
    nothing, or gone from where they saw it. The velocity alone does not tell, because the visible side of a
    trunk changes while the UAV passes.
    """

    def __init__(self, parameters: TrackerParameters | None = None):
        self.parameters = parameters or TrackerParameters()
        self._clusters = np.empty((CLUSTERS_MAX, columns.CLUSTER_COLUMNS))
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._tracks = np.empty((0, columns.TRACK_COLUMNS))
        self._surfaces = np.empty((0, EVIDENCE_SCANS, 2))  # of each track: where the frames saw it, m
        self._moving = np.empty(0, bool)  # which tracks move
        self._stamp_s = math.nan
        self._frames = Frames()
        self._turn, self._shift = 0.0, (0.0, 0.0)  # the odometry's drift: rad and m
        self._drift = RecentDrift()

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
        free: FreeRanges,
        is_level: np.ndarray | None = None,
        height_m: float = 0.0,
        are_upright: bool = True,
        doubt: Doubt = DOUBTED,
        speed_m_s: float = math.inf,
    ) -> MovingTracks:
        """Return what moves at a scan.

        points_m: (n, 2 or 3), from the lidar along the odometry's axes, the ends of the beams that hit
        something, in the order of the beams; their height does not count. sensor_xy: m, the lidar in the
        odometry's frame. free: how far the scan sees free, and how far its beams stay near the lidar's
        height. A beam that passes over a thing shows neither that it is gone, nor that it was not there, nor
        how wide it is. is_level: (n,) bool, which points belong neither to floor nor ceiling
        (`clear_of_floor`); None: all. height_m: of the lidar in the odometry's frame. are_upright: things
        are taken to be the same at all heights, so an earlier scan that leant otherwise tells, too. doubt:
        what of the odometry may be drift; the rest is taken as it is. speed_m_s: of the UAV. After a clock
        that went back, or LONGEST_SCAN_GAP_S without a scan, everything is forgotten.
        """
        dt_s = stamp_s - self._stamp_s
        if not 0.0 < dt_s <= LONGEST_SCAN_GAP_S:
            self.reset()
            dt_s = 0.0
        self._stamp_s = stamp_s
        p = self.parameters
        level = np.ones(len(points_m), bool) if is_level is None else is_level
        if not len(self._tracks) and not (len(level) and level.any()):
            self._frames.hold(stamp_s, height_m, sensor_xy, free)
            return nothing_moves(len(level))
        self._frames.take_in_held(self._pose)
        points, (x_m, y_m), (shift_x_m, shift_y_m) = np.empty((len(level), 2)), sensor_xy, self._shift
        count = placed(points_m, level, x_m, y_m, self._turn, shift_x_m, shift_y_m, points)
        points = points[:count]
        pose, sight_m, level_m = self._pose(sensor_xy), free.free_m, free.level_m
        labels = np.empty(len(points), np.int64)
        limits = p.cluster_gap_m, p.least_points, p.greatest_radius_m
        found = segment(points, pose, sight_m, level_m, *limits, self._clusters, labels)
        clusters = self._clusters[:found]
        unwatched = self._unwatched(pose, sight_m)  # at the scan before: now all tracks wait for a cluster
        predict(self._tracks, dt_s, p.acceleration_m_s2)
        matches = np.empty(len(clusters), np.int64)
        owners = np.empty(len(self._tracks), np.int64)
        associate(clusters, self._tracks, p.gate_m, unwatched, matches, owners)
        self._align(dt_s, points, pose, clusters, owners, doubt)
        plane = plane_of(height_m, free) * (UPRIGHT if are_upright else 1.0)
        planes = self._frames.planes * (UPRIGHT if are_upright else 1.0)
        self._learn(dt_s, points, pose, (plane, planes), free, clusters, owners, p.least(speed_m_s))
        owners = self._forget(pose, np.minimum(sight_m, level_m), owners)
        owners = self._begin(clusters, matches, owners)
        if self._moving.any():
            owners = self._find_again(owners, self._unwatched(pose, sight_m))
        if self._frames.is_due(stamp_s):
            frame = self._frames.keep(stamp_s, height_m, pose, free)
            self._keep_surfaces(frame, clusters, owners)
        if not self._moving.any():
            return nothing_moves(len(level))
        return self._answer(points, labels, level, owners)

    def _pose(self, sensor_xy: Sequence[float]) -> np.ndarray:
        """Return the lidar's place and the turn of the odometry's axes (3,), without its drift."""
        return np.array([*_moved(sensor_xy, self._turn, self._shift), self._turn])

    def _align(
        self,
        dt_s: float,
        points: np.ndarray,
        pose: np.ndarray,
        clusters: np.ndarray,
        owners: np.ndarray,
        doubt: Doubt,
    ) -> None:
        """Align the scan with what stands, and keep what that says of the odometry's drift."""
        limits = self._drift.limits_after(dt_s, doubt)
        if not any(doubt):
            return
        motion = np.empty(3)
        x, y, _ = pose.tolist()
        standing = clusters, self._tracks, owners, self._moving, points, pose
        if not align(*standing, dt_s, STANDING_MIN, limits, motion):
            return
        self._drift.take_in(motion)
        along_x, along_y, turn = motion.tolist()
        from_lidar = self._shift[0] - x, self._shift[1] - y
        self._shift = _moved(from_lidar, turn, (x + along_x, y + along_y))
        self._turn += turn

    def _learn(
        self,
        dt_s: float,
        points: np.ndarray,
        pose: np.ndarray,
        planes: tuple[np.ndarray, np.ndarray],
        free: FreeRanges,
        clusters: np.ndarray,
        owners: np.ndarray,
        least: tuple[float, float],
    ) -> None:
        """Take in the clusters; planes: of this scan (3,) and of the frames, see `Frames.planes`.

        least: see `TrackerParameters.least`.
        """
        p = self.parameters
        shares = math.exp(-dt_s / RADIUS_MEMORY_S), 1.0 - math.exp(-dt_s / SIDES_LEARNING_S)
        scan = clusters, owners, points, pose
        correct(self._tracks, *scan, p.deviation_m, p.deviation_hidden_m, *shares)
        tracks, is_fast = self._tracks, np.empty(len(owners), np.bool_)
        are_fast(tracks, owners, *least, is_fast)
        shown = is_fast.copy()
        if is_fast.any():
            larger = np.maximum(1.0, tracks[:, columns.RADIUS] / LONG_M)
            things = points, clusters[:, : columns.MIDDLE_X], larger, owners, self._surfaces
            frames = self._frames.poses, planes[1], self._frames.shown_m, self._frames.ages_s(self._stamp_s)
            have_moved(
                *things,
                pose,
                planes[0],
                free.shown_m,
                *frames,
                EVIDENCE_YOUNGEST_S,
                p.free_gap_m,
                p.share,
                EVIDENCE_SAMPLES,
                shown,
            )
        losses, limits = (
            (EVIDENCE_LOSS_OF_FAST, EVIDENCE_LOSS_OF_SLOW),
            (p.evidence_s, EVIDENCE_MAX_S, least[0]),
        )
        weigh(tracks, owners, is_fast, shown, dt_s, losses, *limits, self._moving)

    def _forget(self, pose: np.ndarray, sight_m: np.ndarray, owners: np.ndarray) -> np.ndarray:
        """Drop what has not been seen for long, or is not where it should be free.

        Returns the clusters (t,) of the tracks that stay, or -1.
        """
        unseen_s, free = self._tracks[:, columns.UNSEEN], np.empty(len(owners), bool)
        are_free(self._tracks[:, : columns.VX], pose, sight_m, self.parameters.free_gap_m, free)
        behind = np.empty(len(owners), bool)
        are_behind(self._tracks[:, : columns.VX], pose, sight_m, behind)
        moving_s = np.where(behind, FORGET_BEHIND_S, self.parameters.forget_s)
        allowed_s = np.where(self._moving, moving_s, STANDING_FORGET_S)
        stays = unseen_s <= np.where(free, MISSED_S, allowed_s)
        if stays.all():
            return owners
        self._keep(stays)
        return owners[stays]

    def _keep(self, stays: np.ndarray) -> None:
        """Drop all tracks but those that stay (t,)."""
        self._tracks, self._surfaces = self._tracks[stays], self._surfaces[stays]
        self._moving = self._moving[stays]

    def _begin(self, clusters: np.ndarray, matches: np.ndarray, owners: np.ndarray) -> np.ndarray:
        """Begin a track for each cluster without one; return the clusters (t,) of all tracks, or -1."""
        new = np.flatnonzero(matches < 0)[: TRACKS_MAX - len(self._tracks)]
        if new.size == 0:
            return owners
        p = self.parameters
        tracks = np.zeros((new.size, columns.TRACK_COLUMNS))
        tracks[:, columns.X] = clusters[new, columns.MIDDLE_X]
        tracks[:, columns.Y] = clusters[new, columns.MIDDLE_Y]
        tracks[:, columns.PP] = p.deviation_m**2
        tracks[:, columns.VV] = p.speed_first_m_s**2
        tracks[:, columns.RADIUS] = clusters[new, columns.SIZE]
        tracks[:, columns.REACH :] = math.nan
        self._tracks = np.concatenate((self._tracks, tracks))
        self._surfaces = np.concatenate((self._surfaces, np.full((new.size, EVIDENCE_SCANS, 2), math.nan)))
        self._moving = np.concatenate((self._moving, np.zeros(new.size, bool)))
        return np.concatenate((owners, new))

    def _unwatched(self, pose: np.ndarray, sight_m: np.ndarray) -> np.ndarray:
        """Return which tracks (t,) move on where no beam looks."""
        unwatched = self._moving & (self._tracks[:, columns.UNSEEN] > 0.0)
        if unwatched.any():
            behind = np.empty(len(unwatched), bool)
            are_behind(self._tracks[:, : columns.VX], pose, sight_m, behind)
            unwatched &= behind
        return unwatched

    def _find_again(self, owners: np.ndarray, unwatched: np.ndarray) -> np.ndarray:
        """Let what appears near a moving thing that is out of sight be that thing, and move on as it did.

        Each becomes the nearest one only. Otherwise all that appears in a narrow place would soon seem to
        move. What moves on where no beam looks (t,) is not looked for far from there: see `associate`.
        Returns the clusters (t,) of the tracks that stay, or -1.
        """
        tracks, p = self._tracks, self.parameters
        unseen = tracks[:, columns.UNSEEN] > 0.0
        unknown = ~unseen & ~self._moving & (tracks[:, columns.VV] > 0.5 * p.speed_first_m_s**2)
        found = np.zeros(len(tracks), bool)
        for number in np.flatnonzero(self._moving & unseen):
            lost = tracks[number]
            spread_m = 0.0 if unwatched[number] else 3.0 * math.sqrt(lost[columns.PP])
            reach_m = lost[columns.RADIUS] + p.gate_m + spread_m
            apart_m = np.hypot(tracks[:, columns.X] - lost[columns.X], tracks[:, columns.Y] - lost[columns.Y])
            apart_m[~unknown | (tracks[:, columns.RADIUS] >= 1.5 * lost[columns.RADIUS])] = math.inf
            nearest = int(np.argmin(apart_m))
            if apart_m[nearest] >= reach_m:
                continue
            kept = [columns.VX, columns.VY, columns.VV, columns.RADIUS]
            tracks[nearest, kept], tracks[nearest, columns.PV] = lost[kept], 0.0
            tracks[nearest, columns.EVIDENCE] = EVIDENCE_LEFT * lost[columns.EVIDENCE]
            self._moving[nearest], unknown[nearest], found[number] = True, False, True
        if not found.any():
            return owners
        self._keep(~found)
        return owners[~found]

    def _keep_surfaces(self, frame: int, clusters: np.ndarray, owners: np.ndarray) -> None:
        """Keep where each track is seen in a frame."""
        is_seen = owners >= 0
        self._surfaces[:, frame] = math.nan
        surfaces = clusters[owners[is_seen], columns.SURFACE_X : columns.SURFACE_Y + 1]
        self._surfaces[is_seen, frame] = surfaces

    def _answer(
        self, points: np.ndarray, labels: np.ndarray, level: np.ndarray, owners: np.ndarray
    ) -> MovingTracks:
        moving = self._tracks[self._moving]
        clusters = owners[self._moving]
        belongs = np.isin(labels, clusters[clusters >= 0])
        for track in moving:
            distances = np.hypot(points[:, 0] - track[columns.X], points[:, 1] - track[columns.Y])
            belongs |= distances < track[columns.RADIUS] + BESIDE_DISC_M
        is_moving = np.zeros(len(level), bool)
        is_moving[level] = belongs
        covariances = moving[:, [columns.PP, columns.PV, columns.PV, columns.VV]].reshape(-1, 2, 2)
        c, s = math.cos(self._turn), math.sin(self._turn)
        back = np.array([[c, -s], [s, c]])  # a row times it is turned back
        positions = (moving[:, columns.X : columns.Y + 1] - self._shift) @ back
        velocities = moving[:, columns.VX : columns.VY + 1] @ back
        return MovingTracks(positions, velocities, moving[:, columns.RADIUS], covariances, is_moving)


def _moved(place_xy: Sequence[float], turn_rad: float, shift_m: tuple[float, float]) -> tuple[float, float]:
    """Return a place that is turned about the origin, and then shifted."""
    (x, y), c, s = place_xy, math.cos(turn_rad), math.sin(turn_rad)
    return c * x - s * y + shift_m[0], s * x + c * y + shift_m[1]
