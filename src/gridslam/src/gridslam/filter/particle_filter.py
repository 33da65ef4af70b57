"""The Rao-Blackwellised particle filter (Grisetti, Stachniss and Burgard 2005 and 2007)."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.errors import ParameterError, ScanError, StateError
from gridslam.filter import resampling
from gridslam.filter.kept.known_places import adds_nothing
from gridslam.filter.kept.light_poses import LightPose, LightPoses
from gridslam.filter.motion_model import Motion, Prediction, predict
from gridslam.filter.particles import Particles
from gridslam.filter.proposal import propose
from gridslam.filter.scan_evidence import MatchedScan, evidence_of
from gridslam.filter.scan_matcher import ScanMatcher
from gridslam.filter.scan_update import ScanUpdate
from gridslam.filter.slam_map import SlamMap
from gridslam.filter.step_check import StepCheck
from gridslam.filter.workers import Workers
from gridslam.kernels.matching import Matches
from gridslam.maps.beams import Beams
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan
from gridslam.tracking.evidence import Evidence
from gridslam.tracking.monitor import TrackingMonitor
from gridslam.tracking.self_check import UNCERTAIN_FROM_M

START_DEVIATION = (0.1, 0.1, 0.05)
"""m, m, rad: uncertainty of a starting pose on a given map."""

WEIGHT_SMOOTHING = 15.0
"""Log-likelihoods are divided by ogain times this (gmapping: times the number of particles)."""


class ParticleFilter:
    """SLAM with a planar lidar and odometry. Give it every scan, with the odometry at the scan's stamp.

    Args:
        parameters: of the filter.
        starting_map: a known map; None: there is none.
        starting_pose: of the base in the map at the first scan, x, y in m and yaw in rad.
        localisation_only: the starting map stays as it is.
        keep_scans: keep every processed scan, which `snapshot` and `adopt` need; memory grows with the path.
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
        self.parameters, self.localisation_only = parameters, localisation_only
        pose, smoothing = _finite_pose(starting_pose, "starting_pose"), parameters.ogain * WEIGHT_SMOOTHING
        self._particles = Particles(pose, parameters.particles, smoothing)
        self._map = SlamMap(parameters, starting_map, localisation_only, keep_scans)
        self._motion: Motion | None = None
        self._step_check = StepCheck()
        self._rng = np.random.default_rng(parameters.seed)
        self._matcher = ScanMatcher(parameters)
        self._workers = Workers(parameters.threads)
        self.tracking = TrackingMonitor(known_map=localisation_only)
        """Whether the vehicle is where the best particle says."""
        self.odometry_in_space = False
        """Whether odometry is matched in space, as by clouds. Then it tells a place better than level scans
        do, which see another slice at each height. So the filter follows it, wherever its covariance alone
        says how uncertain a motion is; scans make the map, and loop closure corrects the path."""
        self.skips_known = False
        """Whether a scan that agrees in a place that enough passes have mapped is not kept. It enters the
        map, so that what changes is seen. Loop closure must have found that the path is right."""
        self._light = LightPoses()
        self._shift: np.ndarray | None = None
        """(3,) odometry's frame in that of the nodes' odometry. In known places the map tells the motion, so
        that odometry's drift there is not held against the next node's step. None: there was none."""
        self.evidence: Evidence | None = None
        """What the scan that was given last says of the pose; None: it was not compared with the map."""

    # The filter

    def process(
        self,
        scan: PlanarScan,
        base_in_odom: Sequence[float] | np.ndarray,
        covariance: np.ndarray | None = None,
    ) -> ScanUpdate | None:
        """Take in a scan. Return None if it is not integrated.

        That is so if there was not enough motion (or time) since the last one, or if the scan contradicts
        the map, or if the pose was given and is not confirmed yet (see `tracking`).

        covariance: see `Motion`.

        Raises:
            ScanError: the odometry is not a finite pose.
            MapError: the map would become absurdly large; the scan is left out.
        """
        self.evidence = None
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
        enough_m: float = math.inf,
    ) -> bool:
        """Move with the odometry only. Return whether it was enough for a scan at this time.

        enough_m: so much way is enough, too, if it is less than `linearUpdate`.

        Raises:
            ScanError: the odometry is not a finite pose.
            StateError: there was no scan yet.
        """
        odometry = _finite_pose(base_in_odom, "base_in_odom")
        if self._motion is None:
            raise StateError("There is no pose before the first scan.")
        self._motion.add(odometry, self.parameters, covariance)
        return self._motion.is_enough(self.parameters, stamp_s, enough_m)

    def refuse(self, stamp_s: float) -> None:
        """Do not use the scan at this time: the next one comes after as much motion as between two scans."""
        if self._motion is not None:
            self._motion.refuse(stamp_s)

    def _begin(
        self, scan: PlanarScan, odometry: np.ndarray, covariance: np.ndarray | None
    ) -> ScanUpdate | None:
        """Take in the first scan. It is matched only if there is a starting map."""
        self._motion = Motion(odometry, scan.stamp_s, covariance)
        if not self.has_own_map:
            self._motion.deviations += START_DEVIATION
            return self._step(scan, self._motion)
        beams, count = Beams.from_scan(scan, self.parameters), len(self._particles)
        self._map.tiles.insert(self._particles.poses, beams)
        self._step_check.remember(scan)
        self._add_node(scan, odometry)
        return self._update(scan, np.full(count, 1.0 / count), False, True)

    def _step(self, scan: PlanarScan, motion: Motion) -> ScanUpdate | None:
        """One step of the filter; the names are those of algorithm 1 in the 2007 paper.

        A scan that contradicts the map is refused: particles and maps stay as they are.
        """
        particles, maps, parameters = self._particles, self._map.tiles, self.parameters
        beams, before = Beams.from_scan(scan, parameters), particles.poses
        prediction = predict(particles.poses, motion, particles.best, self._rng)
        noise = self._rng.standard_normal(particles.poses.shape)
        noise[particles.best] = 0.0
        uniform = self._rng.random()
        maps.prepare(np.vstack((prediction.predicted, prediction.drawn)), beams)

        matches, drawn = self._match(scan, beams, motion, prediction)
        best = int(np.argmax(particles.log_likelihoods + matches.log_likelihoods))
        matched_scan = MatchedScan(scan.stamp_s, beams, motion, prediction, matches)
        is_witness = not self.is_told_in_space
        self.evidence = evidence_of(matched_scan, maps, best, particles.weights(), parameters, is_witness)
        if not self.tracking.accepts(self.evidence):
            motion.refuse(scan.stamp_s)
            return None
        matched = matches.scores > parameters.minimumScore
        if self.odometry_in_space and motion.is_as_told:
            matched[:], drawn = False, prediction.predicted
        proposed = maps.to_metres(propose(matches, noise, parameters.delta))
        particles.move(np.where(matched[:, None], proposed, drawn))
        particles.weigh(matches.log_likelihoods, prediction.log_density(particles.poses))

        weights = particles.weights()
        resample = resampling.effective_number(weights) < parameters.resampleThreshold * parameters.particles
        best_matched = bool(matched[particles.best])
        self._motion = Motion(motion.now, scan.stamp_s, motion.covariance)
        self._step_check.remember(scan)
        if self.tracking.is_confirming and not self.localisation_only:
            return None
        is_node = not (best_matched and self._is_known(scan, beams, motion, before))
        if is_node:
            self._add_node(scan, motion.now)
        if resample:
            self._resample(resampling.systematic(weights, uniform))
        if not self.localisation_only:
            maps.insert(particles.poses, beams)
        return self._update(scan, weights, resample, best_matched, is_node)

    def _is_known(self, scan: PlanarScan, beams: Beams, motion: Motion, before: np.ndarray) -> bool:
        """Return whether the scan adds nothing in a known place. Then its pose is noted instead of a node.

        before: (particles, 3) where the particles were at the scan before.
        """
        if not self.skips_known or self.evidence is None or not self.tracking.is_on_the_map:
            return False
        if not adds_nothing(self.evidence.agreement, beams):
            return False
        best, path = self.best_particle, self._particles.trajectory().poses_in_map
        pose = self._particles.poses[best]
        anchor = self._map.known_node(path, pose, scan)
        if anchor is None:
            return False
        climb_m = scan.height_m + self._map.kept.rise_m - float(self._map.kept.heights_m[anchor])
        base_in_anchor = se2.between(path[anchor], pose)
        x_m, y_m, yaw_rad = base_in_anchor.tolist()
        self._light.add(LightPose(scan.stamp_s, len(path), anchor, x_m, y_m, yaw_rad, climb_m))
        self._map.add_known(anchor, base_in_anchor, scan)
        by_map = se2.compose(self._shifted(motion.start), se2.between(before[best], pose))
        self._shift = se2.compose(by_map, se2.inverse(motion.now))
        return True

    def _shifted(self, base_in_odom: np.ndarray) -> np.ndarray:
        return base_in_odom if self._shift is None else se2.compose(self._shift, base_in_odom)

    def _match(
        self, scan: PlanarScan, beams: Beams, motion: Motion, prediction: Prediction
    ) -> tuple[Matches, np.ndarray]:
        """Match a scan; return also the poses (particles, 3) that count where it does not match.

        If odometry and the last scan contradict the best particle's step, it is matched once more where these
        two put it. A particle that still contradicts them gets a pose from them alone.
        """
        best, poses, maps = self.best_particle, self._particles.poses, self._map.tiles
        matches = self._matcher.match(maps, prediction, best, beams, self._workers)
        step = se2.between(poses[best], maps.to_metres(matches.poses[best]))
        link = self._step_check.wrong(scan, step, motion)
        if link is None:
            return matches, prediction.drawn
        by_link = link.predict(poses, best, self._rng)
        matches = self._matcher.match(maps, by_link, best, beams, self._workers)
        for particle, step in enumerate(se2.between(poses, maps.to_metres(matches.poses))):
            if link.contradicts(step, motion.step):
                matches.scores[particle] = -math.inf
                matches.poses[particle] = maps.to_cells(by_link.drawn[particle])
        return matches, by_link.drawn

    def _resample(self, parents: np.ndarray) -> None:
        self._particles.resample(parents)
        self._map.tiles.resample(parents)

    def _add_node(self, scan: PlanarScan, base_in_odom: np.ndarray) -> None:
        self._particles.tree.extend(scan.stamp_s, self._particles.poses)
        self._map.add_node(scan, self._shifted(base_in_odom))

    def _update(
        self, scan: PlanarScan, weights: np.ndarray, resampled: bool, matched: bool, is_node: bool = True
    ) -> ScanUpdate:
        neff, entropy = resampling.effective_number(weights), resampling.entropy(weights)
        return ScanUpdate(scan.stamp_s, self.base_in_map, neff, resampled, matched, entropy, is_node)

    # Where it is

    @property
    def best_particle(self) -> int:
        """The particle whose whole path explains scans and odometry best."""
        return self._particles.best

    @property
    def base_in_map(self) -> tuple[float, float, float]:
        """Pose of the best particle now: x, y in m and yaw in rad."""
        return tuple(self._now(self._particles.poses[self.best_particle]).tolist())

    @property
    def particle_weights(self) -> np.ndarray:
        """(particles,) weights since the last resampling; their sum is one."""
        return self._particles.weights()

    def _now(self, poses: np.ndarray) -> np.ndarray:
        return poses.copy() if self._motion is None else se2.compose(poses, self._motion.step)

    @property
    def is_told_in_space(self) -> bool:
        """Whether odometry in space knows the motion since the last scan, to less than `UNCERTAIN_FROM_M`.

        Then level scans are no witness against it.
        """
        motion = self._motion
        if motion is None or not self.odometry_in_space:
            return False
        return motion.is_as_told and bool(motion.told[:2].max() < UNCERTAIN_FROM_M)

    @property
    def has_own_map(self) -> bool:
        """Whether the map was made by this filter alone."""
        return self._map.starting_map is None

    def widen(self, deviations: Sequence[float]) -> None:
        """Process the next scan at once, with odometry more uncertain by these deviations (m, m, rad)."""
        if self._motion is not None:
            self._motion.deviations += deviations
            self._motion.due = True


def _finite_pose(values: Sequence[float] | np.ndarray, name: str) -> np.ndarray:
    pose = np.array(values, float)
    if pose.shape != (3,) or not all(math.isfinite(value) for value in pose):
        raise ScanError(f"{name} must be finite x, y, yaw, not {values}.")
    return pose
