"""SLAM with the particle filter: results, corrections from outside, and the state to save."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Sequence

import numpy as np

from gridslam import se2
from gridslam.filter import resampling
from gridslam.filter.kept.earlier_map import EarlierMap
from gridslam.filter.motion_model import Motion
from gridslam.filter.particle_filter import START_DEVIATION, ParticleFilter
from gridslam.filter.state import FilterState
from gridslam.level_cloud import LevelCloud
from gridslam.loop_closure.snapshot import Snapshot
from gridslam.maps.beams import Beams
from gridslam.maps.new_map import Band, MapDraft
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.scan import PlanarScan
from gridslam.tracking.evidence import Agreement
from gridslam.trajectory import Trajectory, TrajectoryTree

if TYPE_CHECKING:
    from gridslam.loop_closure.correction import Correction  # which slows the start


class GridSlam(ParticleFilter):
    """SLAM with a planar lidar and odometry. Give it every scan, with the odometry at the scan's stamp."""

    # Results

    @property
    def earlier(self) -> EarlierMap | None:
        """The map before the vehicle was lost in vain; None: there is none, or both are one again."""
        return self._map.pieces.earlier

    @property
    def map_to_odom(self) -> tuple[float, float, float]:
        """Pose of the odometry's frame in the map (x, y, yaw); the identity before the first scan."""
        if self._motion is None:
            return (0.0, 0.0, 0.0)
        pose = self._particles.poses[self.best_particle]
        return tuple(se2.compose(pose, se2.inverse(self._motion.start)).tolist())

    @property
    def particle_poses(self) -> np.ndarray:
        """(particles, 3) poses of all particles now."""
        return self._now(self._particles.poses)

    @property
    def entropy(self) -> float:
        """Of the particles' weights."""
        return resampling.entropy(self.particle_weights)

    def trajectory(self) -> Trajectory:
        """Return the best particle's path, at the processed scans; those in known places are among them."""
        path = self._particles.trajectory()
        if self._map.has_kept_scans:
            path = replace(path, heights_m=self._map.kept.heights_m)
        return self._light.merged(path)

    def node_poses(self) -> np.ndarray:
        """Return the poses (k, 3) of the best particle's path at the scans that are kept."""
        return self._particles.trajectory().poses_in_map

    @property
    def newest_odometry(self) -> np.ndarray:
        """(3,) odometry at the newest kept scan, as loop closure gets it; StateError: none are kept."""
        return self._map.kept.newest_odometry

    @property
    def rise_m(self) -> float:
        """How much higher the base is in the map now than odometry says."""
        return self._map.kept.rise_m if self._map.has_kept_scans else 0.0

    def add_cloud(self, cloud: LevelCloud) -> None:
        """Keep what the lidar saw in space with the scan that was processed last, for loop closure.

        Raises:
            StateError: the scans are not kept.
        """
        self._map.kept.add_cloud(cloud)

    def grid(self) -> OccupancyGrid:
        """Return the best particle's map, or the earlier one if that holds more; its cells are read-only."""
        return self._map.grid(self.best_particle, self._particles.nodes)

    def agreement(self, scan: PlanarScan, pose: Sequence[float] | np.ndarray) -> Agreement:
        """Compare a scan, taken at a pose of the base in the map, with the best particle's map."""
        beams = Beams.from_scan(scan, self.parameters)
        return self._map.tiles.agreement(self.best_particle, np.asarray(pose, float), beams)

    def surface_points(self, scan: PlanarScan) -> np.ndarray:
        """Return the ends (n, 2) of the beams that hit something, thinned, m, in the base frame."""
        return Beams.from_scan(scan, self.parameters).matching[:, :2] * self.parameters.delta

    def processed_scans(self) -> list[PlanarScan]:
        """Return the scans at the nodes' poses; raises StateError if they were not kept."""
        return list(self._map.kept.scans)

    # The vehicle is put elsewhere

    def relocate(self, pose: Sequence[float] | np.ndarray, covariance: np.ndarray, stamp_s: float) -> None:
        """Draw the particles around a pose of the base in the map. The first one is at the pose itself.

        All get the best particle's map and path. The next scan is processed at once.

        Args:
            pose: x, y in m and yaw in rad.
            covariance: (3, 3) of the pose, m2, m rad and rad2.
            stamp_s: time of the pose.
        """
        count = len(self._particles)
        self._resample(np.full(count, self.best_particle))
        poses = self._rng.multivariate_normal(np.asarray(pose, float), covariance, count)
        poses[0] = pose
        poses[:, 2] = se2.wrap(poses[:, 2])
        self._particles.place(poses)
        self._step_check.remember(None)
        if self._motion is not None:
            self._motion = Motion(self._motion.now, stamp_s, self._motion.covariance)
            self.widen(START_DEVIATION)

    def begin_map(self) -> None:
        """Begin a new map where odometry says the vehicle is. The present one becomes the `earlier` one."""
        pose, count = np.array(self.base_in_map), len(self._particles)
        self._resample(np.full(count, self.best_particle))
        self._map.begin_anew(self._particles.nodes)
        self._particles.place(np.tile(pose, (count, 1)))
        self._step_check.remember(None)
        if self._motion is not None:
            self._motion = Motion(self._motion.now, self._motion.stamp_s, self._motion.covariance)
            self._motion.due = True

    def return_to_earlier(self, base_in_earlier: np.ndarray, covariance: np.ndarray) -> None:
        """Go on with the earlier map, at a pose of the base in it, with what was mapped since.

        Without the scans since then (see ``keep_scans``) their map is dropped.
        """
        moved = se2.compose(base_in_earlier, se2.inverse(self.base_in_map))
        if not self._map.has_kept_scans:
            self._map.drop_own(self._particles.nodes)
        else:
            poses, first = self.node_poses(), self._map.pieces.first_in_map
            self.adopt(np.vstack([poses[:first], se2.compose(moved, poses[first:])]))
        self.relocate(base_in_earlier, covariance, math.nan if self._motion is None else self._motion.stamp_s)

    @property
    def has_bands(self) -> bool:
        """Whether there may be a map for each height: it is this filter's own and whole, with all scans."""
        return self._map.has_kept_scans and self.has_own_map and self.earlier is None

    def change_band(self, band: Band) -> None:
        """Go on with the map of other heights, which the scans there give along the best particle's path.

        That map may tell a better place, because other slices lead odometry from a planar lidar astray. Where
        there is none yet, or with odometry in space, odometry alone tells the place, and is as sure as it
        says.
        """
        count = len(self._particles)
        self._resample(np.full(count, self.best_particle))
        pose = self._particles.poses[0].copy()
        self._map.change_band(band, self.node_poses())
        self._particles.place(np.tile(pose, (count, 1)))
        is_known = any(map(self._tells, self._map.scans_in_map))
        is_misled = is_known and not self.odometry_in_space
        self.widen(START_DEVIATION if is_misled else (0.0, 0.0, 0.0))

    def _tells(self, scan: PlanarScan | None) -> bool:
        """Return whether a scan enters anything into a map."""
        return scan is not None and len(Beams.from_scan(scan, self.parameters, is_matched=False).hits) > 0

    # Loop closure gets snapshots and gives corrections

    def snapshot(self) -> Snapshot:
        """Return path, scans and odometry as they are now.

        Raises:
            StateError: the scans were not kept.
        """
        path, kept, pieces = self._particles.trajectory(), self._map.kept, self._map.pieces
        return Snapshot(
            path.stamps_s,
            path.poses_in_map,
            kept.odometry,
            kept.heights_m,
            tuple(kept.scans),
            tuple(each.cloud for each in kept.in_space),
            tuple(self._map.scans_in_map),
            pieces.first_in_map,
            pieces.is_usable(len(kept)),
            self.parameters,
            self._map.starting_map,
            self._map.band,
            self._map.newest.all(),
        )

    def correct(self, correction: Correction) -> None:
        """Take over the corrected poses of the path's first nodes. The nodes since then follow as measured.

        Raises:
            StateError: the scans were not kept.
        """
        path, poses = self.node_poses(), correction.poses
        since = se2.between(path[len(poses) - 1], path[len(poses) :])
        if correction.draft is None:  # its map is drawn in the place of the old one
            self._map.drop()
        first, band = correction.first_in_map, self._map.band
        draft = correction.drawn().draft
        if draft is None:
            draft = MapDraft(self.parameters, self._map.starting_map, first, band)
        self.adopt(np.vstack([poses, se2.compose(poses[-1], since)]), draft)
        if correction.heights_m is not None:
            self._map.kept.correct_heights(correction.heights_m)

    def adopt(self, poses_in_map: np.ndarray, draft: MapDraft | None = None) -> None:
        """Give all particles a corrected trajectory (k, 3), and a map of the scans along it.

        Args:
            poses_in_map: x, y in m and yaw in rad, for each processed scan.
            draft: see `SlamMap.adopt`.

        Raises:
            StateError: the scans were not kept, or the poses are not one finite pose for each of them.
        """
        poses = np.array(poses_in_map, float)
        self._map.adopt(poses, draft)
        self._particles.adopt(poses, self._light.now(poses))

    # Saved states

    def state(self) -> FilterState:
        """Return the complete state. A filter made from it continues as if it was never interrupted."""
        kept = self._map.kept if self._map.has_kept_scans else None
        return FilterState(
            self.parameters,
            self._map.starting_map,
            self.localisation_only,
            self._particles.poses,
            self._particles.log_weights,
            self._particles.log_likelihoods,
            self._particles.tree.state(),
            self._map.tiles.state(),
            self._map.pieces.state(),
            self._map.band,
            None if self._motion is None else self._motion.state(),
            self._step_check.before,
            None if kept is None else kept.scans,
            None if kept is None else kept.odometry,
            [] if kept is None else kept.in_space,
            self._light.rows,
            self._map.newest.all(),
            self._shift,
            self._rng.bit_generator.state,
        )

    @classmethod
    def from_state(cls, state: FilterState, threads: int | None = None) -> GridSlam:
        """Return the filter that goes on from a state.

        Args:
            state: of a filter.
            threads: number for the filter; None: as many as when it was saved. The result does not depend on
                it.

        Raises:
            StateError, ValueError, LookupError: the state contradicts itself.
        """
        parameters = state.parameters
        slam = cls(
            parameters if threads is None else replace(parameters, threads=threads),
            state.starting_map,
            localisation_only=state.localisation_only,
            keep_scans=state.scans is not None,
        )
        particles = slam._particles
        particles.poses, particles.log_weights = state.poses, state.log_weights
        particles.log_likelihoods = state.log_likelihoods
        particles.tree = TrajectoryTree.from_state(state.tree)
        slam._map.restore(state)
        slam._light.restore(state.light_poses, len(state.tree.stamps_s))
        slam._shift = state.odometry_shift
        slam._motion = None if state.motion is None else Motion.from_state(state.motion)
        slam._step_check.remember(state.before)
        slam._rng.bit_generator.state = state.random
        return slam

    def take_over_map(self, other: GridSlam) -> None:
        """Give all particles the map of another filter's best one.

        The caller must not use the other filter again.
        """
        other._map.tiles.resample(np.full(other.parameters.particles, other.best_particle))
        self._map.tiles = other._map.tiles
