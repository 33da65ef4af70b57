"""The Rao-Blackwellised particle filter (Grisetti, Stachniss and Burgard 2005 and 2007)."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.errors import ParameterError, ScanError, StateError
from gridslam.filter import resampling
from gridslam.filter.earlier_map import EarlierMap, Pieces
from gridslam.filter.motion_model import Motion, Prediction, predict
from gridslam.filter.proposal import propose
from gridslam.filter.scan_evidence import MatchedScan, evidence_of
from gridslam.filter.scan_matcher import ScanMatcher
from gridslam.filter.scan_update import ScanUpdate
from gridslam.filter.state import FilterState
from gridslam.filter.step_check import StepCheck
from gridslam.filter.workers import Workers
from gridslam.kernels.matching import Matches
from gridslam.maps.beams import Beams
from gridslam.maps.new_map import MapDraft, begun
from gridslam.maps.rendering import Renderer
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan
from gridslam.tracking.evidence import Agreement
from gridslam.tracking.judgement import Judgement
from gridslam.trajectory import Trajectory, TrajectoryTree

START_DEVIATION = (0.1, 0.1, 0.05)
"""m, m, rad: uncertainty of a starting pose on a given map."""

WEIGHT_SMOOTHING = 15.0
"""Log-likelihoods are divided by ogain times this (gmapping: times the number of particles)."""


class GridSlam:
    """SLAM with a planar lidar and odometry. Give it every scan, with the odometry at the scan's stamp.

    Args:
        parameters: of the filter.
        starting_map: a known map; None: there is none.
        starting_pose: of the base in the map at the first scan, x, y in m and yaw in rad.
        localisation_only: the starting map stays as it is.
        keep_scans: keep every processed scan, which `adopt` needs; memory grows with the path.
    """

    def __init__(
        self,
        parameters: SlamParameters,
        starting_map: OccupancyGrid | None = None,
        starting_pose: Sequence[float] = (0.0, 0.0, 0.0),
        localisation_only: bool = False,
        keep_scans: bool = False,
    ):
        if localisation_only and starting_map is None:
            raise ParameterError("Localisation needs a starting map.")
        self.parameters = parameters
        self._starting_map, self.localisation_only = starting_map, localisation_only
        count = parameters.particles
        self._poses = np.tile(_finite_pose(starting_pose, "starting_pose"), (count, 1))
        self._log_weights = np.zeros(count)
        self._log_likelihoods = np.zeros(count)
        self._tree = TrajectoryTree(count)
        self._scans: list[PlanarScan] | None = [] if keep_scans else None
        self._beams: list[Beams] = []
        """Of the scans that are kept, without those for matching."""
        self._maps = begun(starting_map, count, parameters.delta)
        self._pieces = Pieces()
        self._motion: Motion | None = None
        self._step_check = StepCheck()
        self._rng = np.random.default_rng(parameters.seed)
        self._matcher = ScanMatcher(parameters)
        self._renderer = Renderer(parameters)
        self._workers = Workers(parameters.threads)
        self._smoothing = parameters.ogain * WEIGHT_SMOOTHING
        self.judgement = Judgement(known_map=localisation_only)
        """Whether the vehicle is where the best particle says."""

    # The filter

    def process(
        self,
        scan: PlanarScan,
        base_in_odom: Sequence[float] | np.ndarray,
        covariance: np.ndarray | None = None,
    ) -> ScanUpdate | None:
        """Take in a scan. Return None if it is not integrated.

        That is so if there was not enough motion (or time) since the last one, or if the scan contradicts
        the map, or if the pose was given and is not confirmed yet (see `judgement`).

        covariance: see `Motion`.

        Raises:
            ScanError: the odometry is not a finite pose.
            MapError: the map would become absurdly large; the scan is left out.
        """
        odometry = _finite_pose(base_in_odom, "base_in_odom")
        if self._motion is None:
            return self._begin(scan, odometry, covariance)
        is_enough = self.follow(odometry, scan.stamp_s, covariance)
        return self._step(scan, self._motion) if is_enough else None

    def follow(
        self,
        base_in_odom: Sequence[float] | np.ndarray,
        stamp_s: float,
        covariance: np.ndarray | None = None,
    ) -> bool:
        """Move with the odometry only. Return whether it was enough for a scan at this time.

        Raises:
            ScanError: the odometry is not a finite pose.
            StateError: there was no scan yet.
        """
        odometry = _finite_pose(base_in_odom, "base_in_odom")
        if self._motion is None:
            raise StateError("There is no pose before the first scan.")
        self._motion.add(odometry, self.parameters, covariance)
        return self._motion.is_enough(self.parameters, stamp_s)

    def refuse(self, stamp_s: float) -> None:
        """Do not use the scan at this time: the next one comes after as much motion as between two scans."""
        if self._motion is not None:
            self._motion.refuse(stamp_s)

    def _begin(
        self, scan: PlanarScan, odometry: np.ndarray, covariance: np.ndarray | None
    ) -> ScanUpdate | None:
        """Take in the first scan. It is matched only if there is a starting map."""
        self._motion = Motion(odometry, scan.stamp_s, covariance)
        if self._starting_map is not None:
            self._motion.deviations += START_DEVIATION
            return self._step(scan, self._motion)
        beams = Beams.from_scan(scan, self.parameters)
        self._maps.insert(self._poses, beams)
        self._step_check.remember(scan)
        self._remember(scan, beams)
        return self._update(scan, np.full(len(self._poses), 1.0 / len(self._poses)), False, True)

    def _step(self, scan: PlanarScan, motion: Motion) -> ScanUpdate | None:
        """One step of the filter; the names are those of algorithm 1 in the 2007 paper.

        A scan that contradicts the map is refused: particles and maps stay as they are.
        """
        beams = Beams.from_scan(scan, self.parameters)
        prediction = predict(self._poses, motion, self._rng)
        noise = self._rng.standard_normal(self._poses.shape)
        noise[self.best_particle] = 0.0
        uniform = self._rng.random()
        self._maps.prepare(np.vstack((prediction.predicted, prediction.drawn)), beams)

        matches, drawn = self._match(scan, beams, motion, prediction)
        best = int(np.argmax(self._log_likelihoods + matches.log_likelihoods))
        matched_scan = MatchedScan(scan.stamp_s, beams, motion, prediction, matches)
        evidence = evidence_of(matched_scan, self._maps, best, self.particle_weights, self.parameters)
        if not self.judgement.accepts(evidence):
            motion.refuse(scan.stamp_s)
            return None
        matched = matches.scores > self.parameters.minimumScore
        proposed = self._maps.to_metres(propose(matches, noise, self.parameters.delta))
        self._poses = np.where(matched[:, None], proposed, drawn)
        self._poses[:, 2] = se2.wrap(self._poses[:, 2])
        self._log_weights += matches.log_likelihoods
        self._log_likelihoods += matches.log_likelihoods
        self._log_likelihoods += self._smoothing * prediction.log_density(self._poses)

        weights = self.particle_weights
        resample = (
            resampling.effective_number(weights)
            < self.parameters.resampleThreshold * self.parameters.particles
        )
        best_matched = bool(matched[self.best_particle])
        self._motion = Motion(motion.now, scan.stamp_s, motion.covariance)
        self._step_check.remember(scan)
        if self.judgement.is_confirming and not self.localisation_only:
            return None
        self._remember(scan, beams)
        if resample:
            self._resample(resampling.systematic(weights, uniform))
        if not self.localisation_only:
            self._maps.insert(self._poses, beams)
        return self._update(scan, weights, resample, best_matched)

    def _match(
        self, scan: PlanarScan, beams: Beams, motion: Motion, prediction: Prediction
    ) -> tuple[Matches, np.ndarray]:
        """Match a scan; return also the poses (particles, 3) that count where it does not match.

        If odometry and the last scan contradict the best particle's step, it is matched once more where these
        two put it. A particle that still contradicts them gets a pose from them alone.
        """
        best = self.best_particle
        matches = self._matcher.match(self._maps, prediction, best, beams, self._workers)
        step = se2.between(self._poses[best], self._maps.to_metres(matches.poses[best]))
        link = self._step_check.wrong(scan, step, motion)
        if link is None:
            return matches, prediction.drawn
        by_link = link.predict(self._poses, self._rng)
        matches = self._matcher.match(self._maps, by_link, best, beams, self._workers)
        steps = se2.between(self._poses, self._maps.to_metres(matches.poses))
        for particle, step in enumerate(steps):
            if link.contradicts(step, motion.step):
                matches.scores[particle] = -math.inf
                matches.poses[particle] = self._maps.to_cells(by_link.drawn[particle])
        return matches, by_link.drawn

    def agreement(self, scan: PlanarScan, pose: Sequence[float] | np.ndarray) -> Agreement:
        """Compare a scan, taken at a pose of the base in the map, with the best particle's map."""
        beams = Beams.from_scan(scan, self.parameters)
        return self._maps.agreement(self.best_particle, np.asarray(pose, float), beams)

    def surface_points(self, scan: PlanarScan) -> np.ndarray:
        """Return the ends (n, 2) of the beams that hit something, thinned, m, in the base frame."""
        return Beams.from_scan(scan, self.parameters).matching[:, :2] * self.parameters.delta

    def relocate(self, pose: Sequence[float] | np.ndarray, covariance: np.ndarray, stamp_s: float) -> None:
        """Draw the particles around a pose of the base in the map. The first one is at the pose itself.

        All get the best particle's map and path. The next scan is processed at once.

        Args:
            pose: x, y in m and yaw in rad.
            covariance: (3, 3) of the pose, m2, m rad and rad2.
            stamp_s: time of the pose.
        """
        self._resample(np.full(len(self._poses), self.best_particle))
        self._poses = self._rng.multivariate_normal(np.asarray(pose, float), covariance, len(self._poses))
        self._poses[0] = pose
        self._poses[:, 2] = se2.wrap(self._poses[:, 2])
        self._log_likelihoods[:] = 0.0
        self._step_check.remember(None)
        if self._motion is not None:
            self._motion = Motion(self._motion.now, stamp_s, self._motion.covariance)
            self.widen(START_DEVIATION)

    def begin_map(self) -> None:
        """Begin a new map where odometry says the vehicle is. The present one becomes the `earlier` one."""
        pose = np.array(self.base_in_map)
        self._resample(np.full(len(self._poses), self.best_particle))
        nodes = len(self._tree.stamps_s)
        self._pieces.begin(self._maps, self.parameters, nodes)
        self._leave_out()
        self._maps = begun(None, len(self._poses), self.parameters.delta)
        self._renderer = Renderer(self.parameters)
        self._poses = np.tile(pose, (len(self._poses), 1))
        self._log_likelihoods[:] = 0.0
        self._step_check.remember(None)
        if self._motion is not None:
            self._motion = Motion(self._motion.now, self._motion.stamp_s, self._motion.covariance)
            self._motion.due = True

    def return_to_earlier(self, base_in_earlier: np.ndarray, covariance: np.ndarray) -> None:
        """Go on with the earlier map, at a pose of the base in it, with what was mapped since.

        Without the scans since then (see ``keep_scans``) their map is dropped.
        """
        moved = se2.compose(base_in_earlier, se2.inverse(self.base_in_map))
        if self._scans is None:
            self._maps = self._pieces.leave_own(len(self._tree.stamps_s))
            self._renderer = Renderer(self.parameters)
        else:
            poses, first = self.trajectory().poses_in_map, self._pieces.begun
            self.adopt(np.vstack([poses[:first], se2.compose(moved, poses[first:])]))
        self.relocate(base_in_earlier, covariance, math.nan if self._motion is None else self._motion.stamp_s)

    def _leave_out(self) -> None:
        """Let the scans that are in no map enter none."""
        if self._scans is not None:
            for first, last in self._pieces.left_out:
                self._beams[first:last] = [Beams.none()] * (last - first)

    def widen(self, deviations: Sequence[float]) -> None:
        """Process the next scan at once, with odometry more uncertain by these deviations (m, m, rad)."""
        if self._motion is not None:
            self._motion.deviations += deviations
            self._motion.due = True

    def _resample(self, parents: np.ndarray) -> None:
        self._poses = self._poses[parents]
        self._log_likelihoods = self._log_likelihoods[parents]
        self._log_weights[:] = 0.0
        self._tree.resample(parents)
        self._maps.resample(parents)

    def _remember(self, scan: PlanarScan, beams: Beams) -> None:
        self._tree.extend(scan.stamp_s, self._poses)
        if self._scans is not None:
            self._scans.append(scan.sharing(self._scans[-1]) if self._scans else scan)
            self._beams.append(beams.for_map())

    def _update(self, scan: PlanarScan, weights: np.ndarray, resampled: bool, matched: bool) -> ScanUpdate:
        return ScanUpdate(
            scan.stamp_s,
            self.base_in_map,
            resampling.effective_number(weights),
            resampled,
            matched,
            resampling.entropy(weights),
        )

    # Results

    @property
    def best_particle(self) -> int:
        """The particle whose whole path explains scans and odometry best."""
        return int(np.argmax(self._log_likelihoods))

    @property
    def has_own_map(self) -> bool:
        """Whether the map was made by this filter alone."""
        return self._starting_map is None

    @property
    def earlier(self) -> EarlierMap | None:
        """The map before the vehicle was lost in vain; None: there is none, or both are one again."""
        return self._pieces.earlier

    @property
    def pieces(self) -> Pieces:
        """Which scans are in which map."""
        return self._pieces

    @property
    def base_in_map(self) -> tuple[float, float, float]:
        """Pose of the best particle now: x, y in m and yaw in rad."""
        return tuple(self._now(self._poses[self.best_particle]).tolist())

    @property
    def map_to_odom(self) -> tuple[float, float, float]:
        """Pose of the odometry's frame in the map (x, y, yaw); the identity before the first scan."""
        if self._motion is None:
            return (0.0, 0.0, 0.0)
        pose = self._poses[self.best_particle]
        return tuple(se2.compose(pose, se2.inverse(self._motion.start)).tolist())

    @property
    def particle_poses(self) -> np.ndarray:
        """(particles, 3) poses of all particles now."""
        return self._now(self._poses)

    @property
    def particle_weights(self) -> np.ndarray:
        """(particles,) weights since the last resampling; their sum is one."""
        return resampling.normalised(self._log_weights, 1.0 / self._smoothing)

    @property
    def entropy(self) -> float:
        """Of the particles' weights."""
        return resampling.entropy(self.particle_weights)

    def trajectory(self) -> Trajectory:
        """Return the best particle's path, at the processed scans."""
        return Trajectory(np.array(self._tree.stamps_s), self._tree.path(self.best_particle))

    def grid(self) -> OccupancyGrid:
        """Return the best particle's map, or the earlier one if that holds more; its cells are read-only."""
        earlier = self._pieces.earlier
        if earlier is not None and earlier.scans >= len(self._tree.stamps_s) - self._pieces.begun:
            return earlier.grid()
        return self._renderer.render(self._maps, self.best_particle)

    def processed_scans(self) -> list[PlanarScan]:
        """Return the scans at the trajectory's poses; raises StateError if they were not kept."""
        if self._scans is None:
            raise StateError("The scans were not kept: construct GridSlam with keep_scans=True.")
        return list(self._scans)

    def _now(self, poses: np.ndarray) -> np.ndarray:
        return poses.copy() if self._motion is None else se2.compose(poses, self._motion.step)

    # Corrections from outside, and saved states

    def draft(self, first: int = 0) -> MapDraft:
        """Return a new map for `adopt`, of the scans from the ``first`` one on.

        Any thread may call this and fill the map.
        """
        return MapDraft(self.parameters, self._starting_map, self._beams, first)

    def adopt(self, poses_in_map: np.ndarray, draft: MapDraft | None = None) -> None:
        """Give all particles a corrected trajectory (k, 3), and a map of the scans along it.

        Args:
            poses_in_map: x, y in m and yaw in rad, for each processed scan.
            draft: a map that holds the first of these scans at these poses; None: an empty one. If there is
                an earlier map, and the draft holds its scans, both are one then.

        Raises:
            StateError: the scans were not kept, or the poses are not one finite pose for each of them.
        """
        scans = self.processed_scans()
        poses = np.array(poses_in_map, float)
        if poses.shape != (len(scans), 3) or not np.isfinite(poses).all():
            raise StateError(f"The corrected trajectory must be {len(scans)} finite poses x, y, yaw.")
        draft = draft or self.draft()
        if not self.localisation_only:
            draft.add(poses[draft.scans :])
        draft.maps.resample(np.zeros(self.parameters.particles, int))
        self._maps, self._renderer = draft.maps, Renderer(self.parameters)
        if draft.first == 0:
            self._pieces.join()
        self._tree.replace(poses)
        self._poses = np.tile(poses[-1], (self.parameters.particles, 1))
        self._log_weights[:] = 0.0
        self._log_likelihoods[:] = 0.0

    def state(self) -> FilterState:
        """Return the complete state. A filter made from it continues as if it was never interrupted."""
        return FilterState(
            self.parameters,
            self._starting_map,
            self.localisation_only,
            self._poses,
            self._log_weights,
            self._log_likelihoods,
            self._tree.to_arrays(),
            self._maps.to_arrays(),
            self._pieces.to_arrays(),
            self._motion,
            self._step_check.before,
            self._scans,
            self._rng.bit_generator.state,
        )

    @classmethod
    def from_state(cls, state: FilterState) -> GridSlam:
        """Return the filter that goes on from a state.

        Raises:
            StateError, ValueError, LookupError: the state contradicts itself.
        """
        slam = cls(
            state.parameters,
            state.starting_map,
            localisation_only=state.localisation_only,
            keep_scans=state.scans is not None,
        )
        slam._poses, slam._log_weights = state.poses, state.log_weights
        slam._log_likelihoods = state.log_likelihoods
        slam._tree = TrajectoryTree.from_arrays(**state.tree)
        slam._maps.restore(state.maps)
        slam._pieces.restore(state.pieces, state.parameters, len(slam._tree.stamps_s))
        slam._motion = state.motion
        slam._step_check.remember(state.before)
        slam._rng.bit_generator.state = state.random
        if state.scans is not None and len(state.scans) != len(slam._tree.stamps_s):
            raise ValueError("there are not as many scans as stamps")
        slam._scans = state.scans
        slam._beams = [
            Beams.from_scan(scan, state.parameters, is_matched=False) for scan in state.scans or ()
        ]
        slam._leave_out()
        return slam

    def take_over_map(self, other: GridSlam) -> None:
        """Give all particles the map of another filter's best one.

        The caller must not use the other filter again.
        """
        other._maps.resample(np.full(other.parameters.particles, other.best_particle))
        self._maps = other._maps


def _finite_pose(values: Sequence[float] | np.ndarray, name: str) -> np.ndarray:
    pose = np.array(values, float)
    if pose.shape != (3,) or not all(math.isfinite(value) for value in pose):
        raise ScanError(f"{name} must be finite x, y, yaw, not {values}.")
    return pose
