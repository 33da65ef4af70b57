"""The filter's path as a chain of nodes: each step with its measurement and covariance.

A step's covariance describes its error in the frame of its later node (x, y in m, yaw in rad).
"""

from __future__ import annotations

from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.kernels.least_squares import inverses
from gridslam.loop_closure.edge import Edges
from gridslam.loop_closure.local_map import LocalMap, SurfacePoints, build_local_map, surface_points
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.refinement import normal_matrix
from gridslam.scan import PlanarScan

STEP_SIGMA_MIN_M, STEP_SIGMA_MIN_RAD = 0.002, 0.0005
STEPS_MIN, CHI_SQUARE_75, SHARE_MIN = 20, 4.108, 0.04
"""To learn how good odometry is: least number of steps, the chi-square (3 degrees of freedom) that three
quarters of them stay below, and the least share of the assumed covariance.
"""
SCAN_SPACING_M = 0.25  # closer scans add nothing to a local map


class Chain:
    """Follows a filter's best path. It keeps the measured steps, without corrections."""

    def __init__(self, parameters: LoopClosureParameters) -> None:
        self._parameters = parameters
        self.stamps_s = np.empty(0)
        self.poses = np.empty((0, 3))
        """(k, 3) the nodes' present poses in the map."""
        self.steps = np.empty((0, 3))
        """(k - 1, 3) each node but the first, in the frame of the one before it."""
        self.covariances = np.empty((0, 3, 3))
        """(k - 1, 3, 3) of the steps' errors; see `loosen`."""
        self.matched_covariances = np.empty((0, 3, 3))
        """(k - 1, 3, 3) of the steps' errors if every scan was matched rightly."""
        self.odometry = np.empty((0, 3))
        """(k, 3) pose of the base in the odometry's frame, at the nodes."""
        self.way_m = np.zeros(0)
        """(k,) length of the path up to each node."""
        self._scans: list[PlanarScan] = []
        self._surfaces: list[SurfacePoints] = []
        self._informations: list[np.ndarray] = []
        self._measured, self._loose, self._scale = np.empty((0, 3)), np.empty((0, 3, 3)), 1.0
        self._opened, self._is_open = np.empty((0, 3, 3)), np.zeros(0, dtype=bool)
        self._settled = 0

    def __len__(self) -> int:
        return len(self.poses)

    def follow(
        self,
        stamps_s: np.ndarray,
        poses_in_map: np.ndarray,
        scans: list[PlanarScan],
        odometry: np.ndarray,
    ) -> None:
        """Take over the filter's path (k, 3), scans and odometry (k, 3).

        Steps since the last correction may have changed.
        """
        self.odometry = odometry
        for scan in scans[len(self._surfaces) :]:
            surface = surface_points(scan, self._parameters.range_m)
            self._surfaces.append(surface)
            self._informations.append(
                match_information(normal_matrix(surface), len(surface.points_xy_m), self._parameters)
            )
        self._scans = scans
        first = self._first_changed(poses_in_map)
        steps = se2.between(poses_in_map[first:-1], poses_in_map[first + 1 :])
        covariances = self._step_covariances(steps, first + 1)
        self.steps = np.concatenate([self.steps[:first], steps])
        self.matched_covariances = np.concatenate([self.matched_covariances[:first], covariances])
        self.covariances = self.matched_covariances.copy()
        self.stamps_s, self.poses = np.asarray(stamps_s), np.array(poses_in_map, dtype=float)
        self.way_m = np.concatenate([[0.0], np.cumsum(np.hypot(self.steps[:, 0], self.steps[:, 1]))])

    def to_arrays(self) -> dict[str, np.ndarray]:
        """Return the input of `from_arrays`, without the scans, which come with the next `follow`."""
        return {
            "stamps_s": self.stamps_s,
            "poses": self.poses,
            "steps": self.steps,
            "covariances": self.matched_covariances,
            "way_m": self.way_m,
            "odometry": self.odometry,
            "settled": np.array(self._settled),
        }

    def from_arrays(
        self,
        stamps_s: np.ndarray,
        poses: np.ndarray,
        steps: np.ndarray,
        covariances: np.ndarray,
        way_m: np.ndarray,
        odometry: np.ndarray,
        settled: np.ndarray,
    ) -> None:
        """Go on from what `to_arrays` has returned.

        Raises:
            ValueError: it is no chain.
        """
        nodes, between = len(poses), max(0, len(poses) - 1)
        for name, array, shape in (
            ("stamps", stamps_s, (nodes,)),
            ("poses", poses, (nodes, 3)),
            ("way", way_m, (nodes,)),
            ("odometry", odometry, (nodes, 3)),
            ("steps", steps, (between, 3)),
            ("covariances", covariances, (between, 3, 3)),
        ):
            if array.shape != shape:
                raise ValueError(f"the chain's {name} are of shape {array.shape}, not {shape}")
        self.stamps_s, self.poses, self.steps = stamps_s, poses, steps
        self.matched_covariances, self.way_m, self._settled = covariances, way_m, int(settled)
        self.covariances = covariances.copy()
        self.odometry = odometry

    def _first_changed(self, poses_in_map: np.ndarray) -> int:
        """Return the first changed step. Steps change when another particle becomes the best one."""
        known = len(self.poses)
        changed = np.flatnonzero((np.asarray(poses_in_map)[:known] != self.poses).any(axis=1))
        first = known if not len(changed) else int(changed[0])
        return max(0, self._settled - 1, first - 1)

    def settle(self, poses_in_map: np.ndarray) -> None:
        """Note that the filter has adopted corrected poses (k, 3). The steps measured so far stay."""
        self.poses = np.array(poses_in_map, dtype=float)
        self._settled = len(self.poses)

    def _step_covariances(self, steps: np.ndarray, first: int) -> np.ndarray:
        """Return the covariances of the steps to nodes from `first` on, by odometry and matching.

        Along a bare wall matching measures nothing, so the covariance of odometry remains.
        """
        information = np.array(self._informations[first : first + len(steps)]).reshape(-1, 3, 3)
        prior = np.diagonal(self._odometry_covariances(steps), axis1=1, axis2=2)
        informations = information + np.eye(3) / prior[:, None, :]
        return inverses(informations)

    def _odometry_covariances(self, steps: np.ndarray) -> np.ndarray:
        p = self._parameters
        way, turned = np.hypot(steps[:, 0], steps[:, 1]), np.abs(steps[:, 2])
        covariances = np.zeros((len(steps), 3, 3))
        covariances[:, 0, 0] = p.odometry_m_per_sqrt_m**2 * way + STEP_SIGMA_MIN_M**2
        covariances[:, 1, 1] = covariances[:, 0, 0]
        heading = p.odometry_rad_per_sqrt_m**2 * way + p.odometry_rad_per_sqrt_rad**2 * turned
        covariances[:, 2, 2] = heading + STEP_SIGMA_MIN_RAD**2
        return covariances

    def loosen(
        self,
        is_seen: np.ndarray,
        unmatched: Sequence[int],
        contradicted: Sequence[int],
        scale: float = 1.0,
        guessed: Sequence[int] = (),
    ) -> None:
        """Let the steps that no scan has measured be as uncertain as odometry is there.

        Its error is at least its difference from the filter's step, for example where the vehicle has been
        found elsewhere on the map. It is of unknown size where scans contradicted odometry, as when wheels
        slip. A step that a link spans is measured, whatever is known of its node.

        The steps to and from a guessed pose are known together, because the scan after it was matched again.
        So they are uncertain among the `edges` only.

        Args:
            is_seen: (k - 1,) whether a link that measures every direction spans the step.
            unmatched: nodes whose scan could not be compared with the map, or at which the vehicle was found.
            contradicted: nodes before which the vehicle was lost, and was not found on the map.
            scale: odometry's ways are multiplied by this; see `odometry_scale`.
            guessed: nodes to which the step begins or ends at a guessed pose.
        """
        p, nodes = self._parameters, np.arange(1, len(self.poses))
        measured = se2.between(self.odometry[:-1], self.odometry[1:]) * (scale, scale, 1.0)
        is_wrong = ~is_seen & np.isin(nodes, contradicted)
        is_unknown = is_wrong | ~is_seen & np.isin(nodes, unmatched)
        self._is_open = is_unknown | ~is_seen & np.isin(nodes, guessed)
        self._scale, self._measured = scale, measured
        self._loose = self._odometry_covariances(measured)
        self._loose[is_wrong] += np.diag([p.slip_m, p.slip_m, p.slip_rad]) ** 2
        off = se2.between(measured, self.steps)
        self._opened = self._loose + off[:, :, None] * off[:, None, :]
        self.covariances = np.where(is_unknown[:, None, None], self._opened, self.matched_covariances)

    def edges(self, links: np.ndarray, poses: np.ndarray) -> Edges:
        """Return each step twice: as the filter has it, and as odometry measured it. Call `loosen` before.

        A filter's step is as firm as all links of its scan with those before it together: ``links``
        (k - 1, 3, 3), their information. These scans are the map that it was matched with, and show how much
        of it the scan has met. Matches against one map have similar errors; `step_share` tells how firmly
        the steps hold. Where links say nothing, it is trusted only like odometry.

        Odometry may be better than assumed. How good it is, the present path ``poses`` (k, 3) tells. But
        where no link joins a step's scan, it stays as assumed, beside the filter's step.
        """
        p, measured = self._parameters, self._measured
        is_linked = links.any(axis=(1, 2))
        share = np.where(is_linked & ~self._is_open, self._odometry_share(poses), 1.0)
        held = self._loose.copy()
        held[is_linked] = p.step_share**2 * inverses(links[is_linked] + inverses(self._loose[is_linked]))
        held[self._is_open] = self._opened[self._is_open]
        older = np.tile(np.arange(len(measured)), 2)
        loose = share[:, None, None] * self._loose
        steps = np.concatenate([self._scaled_steps(held), measured])
        return Edges(older, older + 1, steps, np.concatenate([held, loose]))

    def _scaled_steps(self, held: np.ndarray) -> np.ndarray:
        """Return the filter's steps (k - 1, 3) as if its odometry had had the right scale.

        Where scans measured nothing, the filter took a step as odometry had it. ``held``: the covariances of
        its steps, from scans and odometry together.
        """
        wrong = self._measured * (1.0 - 1.0 / self._scale) * (1.0, 1.0, 0.0)
        wrong[:, :2] = se2.transform_each(self.steps * (0.0, 0.0, -1.0), wrong[:, :2])
        taken = np.einsum("nij,njk,nk->ni", held, inverses(self._loose), wrong)
        taken[:, :2] = se2.transform_each(self.steps * (0.0, 0.0, 1.0), taken[:, :2])
        return self.steps + np.where(self._is_open[:, None], 0.0, taken)

    def _odometry_share(self, poses: np.ndarray) -> float:
        """Return by how much odometry's covariance is too large, from its differences to a path (k, 3).

        Three quarters of them must be as expected. So the few great ones do not count, which the robust
        kernel takes care of.
        """
        error = se2.between(self._measured, se2.between(poses[:-1], poses[1:]))[~self._is_open]
        if len(error) < STEPS_MIN:
            return 1.0
        spread = np.diagonal(self._loose[~self._is_open], axis1=1, axis2=2)
        return float(
            np.clip(np.quantile((error**2 / spread).sum(axis=1), 0.75) / CHI_SQUARE_75, SHARE_MIN, 1.0)
        )

    def local_map(self, anchor: int, behind_m: float, ahead_m: float) -> LocalMap:
        """Build the local map of the path from `behind_m` before a node to `ahead_m` after it."""
        way, p = self.way_m - self.way_m[anchor], self._parameters
        nodes = np.flatnonzero((way >= -behind_m) & (way <= ahead_m))
        return self.map_of(nodes, anchor, SCAN_SPACING_M, p.resolution_m, p.blur_m)

    def map_of(
        self, nodes: np.ndarray, anchor: int, spacing_m: float, resolution_m: float, blur_m: float
    ) -> LocalMap:
        """Build the map that nodes saw, in the anchor's frame, from scans about `spacing_m` apart."""
        kept = self._thinned(nodes, anchor, spacing_m)
        return build_local_map(
            anchor,
            [self._surfaces[node] for node in kept],
            [self._scans[node] for node in kept],
            se2.between(self.poses[anchor], self.poses[kept]),
            resolution_m,
            blur_m,
            2.0 * resolution_m,
            self._parameters.range_m,
        )

    def _thinned(self, nodes: np.ndarray, anchor: int, spacing_m: float) -> list[int]:
        kept: list[int] = []
        for node in nodes:
            turned = abs(se2.wrap(self.poses[node, 2] - self.poses[kept[-1], 2])) > 0.2 if kept else True
            if turned or node == anchor or self.way_m[node] - self.way_m[kept[-1]] >= spacing_m:
                kept.append(int(node))
        return kept


def match_information(matrix: np.ndarray, points: int, parameters: LoopClosureParameters) -> np.ndarray:
    """Return the information (3, 3) of a match from its sum of J^T J over this many points."""
    independent = min(1.0, parameters.match_points / max(1, points))
    return independent * matrix / parameters.match_sigma_m**2
