"""The filter's path as steps: each with its measurement and its covariance if its scan was matched rightly.

A step's covariance describes its error in the frame of its later node (x, y in m, yaw in rad).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gridslam import se2
from gridslam.kernels.least_squares import inverses
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.snapshot import Snapshot

STEP_SIGMA_MIN_M, STEP_SIGMA_MIN_RAD = 0.002, 0.0005


@dataclass(frozen=True, eq=False)
class MeasuredPath:
    """A path of k nodes. Its steps stay as they were measured when the poses are corrected.

    Raises:
        ValueError: the arrays' shapes contradict each other.
    """

    stamps_s: np.ndarray
    """(k,) s."""
    poses: np.ndarray
    """(k, 3) the nodes' present poses in the map."""
    steps: np.ndarray
    """(k - 1, 3) each node but the first, in the frame of the one before it."""
    covariances: np.ndarray
    """(k - 1, 3, 3) of the steps' errors, if every scan was matched rightly."""
    odometry: np.ndarray
    """(k, 3) pose of the base in the odometry's frame, at the nodes."""
    way_m: np.ndarray
    """(k,) length of the path up to each node."""
    heights_m: np.ndarray
    """(k,) the nodes' present heights in the map; NaN: not known."""
    climbs_m: np.ndarray
    """(k - 1,) how much higher each node but the first is than the one before it, as odometry measured it."""
    corrected: int = 0
    """Number of nodes, the first ones, whose poses were corrected last. Their steps stay."""

    def __post_init__(self) -> None:
        nodes, between = len(self.poses), max(0, len(self.poses) - 1)
        for name, shape in (
            ("stamps_s", (nodes,)),
            ("poses", (nodes, 3)),
            ("way_m", (nodes,)),
            ("heights_m", (nodes,)),
            ("odometry", (nodes, 3)),
            ("steps", (between, 3)),
            ("covariances", (between, 3, 3)),
            ("climbs_m", (between,)),
        ):
            if getattr(self, name).shape != shape:
                raise ValueError(f"the path's {name} are of shape {getattr(self, name).shape}, not {shape}")

    def __len__(self) -> int:
        return len(self.poses)

    @classmethod
    def empty(cls) -> MeasuredPath:
        """Return a path without nodes."""
        rows = np.empty((0, 3))
        none = np.empty(0)
        return cls(none, rows, rows, np.empty((0, 3, 3)), rows, none, none, none)

    @property
    def way_in_space_m(self) -> np.ndarray:
        """(k,) length of the path up to each node, climbs included as far as they are known."""
        steps_m = np.hypot(np.diff(self.way_m), np.nan_to_num(self.climbs_m))
        return np.concatenate([[0.0], np.cumsum(steps_m)])[: len(self)]

    def followed(
        self, snapshot: Snapshot, informations: np.ndarray, parameters: LoopClosureParameters
    ) -> MeasuredPath:
        """Return the path of a later snapshot. Steps since the last correction may have changed.

        informations: (k, 3, 3) of each scan's match with a map of its own surfaces.
        """
        poses = snapshot.poses_in_map
        first = self._first_changed(poses)
        steps = se2.between(poses[first:-1], poses[first + 1 :])
        covariances = _step_covariances(steps, informations[first + 1 : first + 1 + len(steps)], parameters)
        steps = np.concatenate([self.steps[:first], steps])
        return MeasuredPath(
            snapshot.stamps_s,
            np.array(poses, dtype=float),
            steps,
            np.concatenate([self.covariances[:first], covariances]),
            snapshot.odometry,
            np.concatenate([[0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))]),
            np.array(snapshot.heights_m, dtype=float),
            np.concatenate([self.climbs_m[:first], np.diff(snapshot.heights_m[first:])]),
            self.corrected,
        )

    def corrected_to(self, poses: np.ndarray, heights_m: np.ndarray) -> MeasuredPath:
        """Return the path with corrected poses (k, 3) and heights (k,). What was measured stays."""
        poses, heights_m = np.array(poses, dtype=float), np.array(heights_m, dtype=float)
        return replace(self, poses=poses, heights_m=heights_m, corrected=len(poses))

    def _first_changed(self, poses_in_map: np.ndarray) -> int:
        """Return the first changed step. Steps change when another particle becomes the best one."""
        known = len(self.poses)
        changed = np.flatnonzero((poses_in_map[:known] != self.poses).any(axis=1))
        first = known if not len(changed) else int(changed[0])
        return max(0, self.corrected - 1, first - 1)


def _step_covariances(
    steps: np.ndarray, informations: np.ndarray, parameters: LoopClosureParameters
) -> np.ndarray:
    """Return the covariances of steps (n, 3) by odometry and by matching (n, 3, 3).

    Along a bare wall matching measures nothing, so the covariance of odometry remains.
    """
    prior = np.diagonal(odometry_covariances(steps, parameters), axis1=1, axis2=2)
    return inverses(informations.reshape(-1, 3, 3) + np.eye(3) / prior[:, None, :])


def chained(start: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return the poses (n + 1, 3) along steps (n, 3) from a pose on."""
    yaw = start[2] + np.concatenate([[0.0], np.cumsum(steps[:, 2])])
    cos, sin = np.cos(yaw[:-1]), np.sin(yaw[:-1])
    moved = np.column_stack([cos * steps[:, 0] - sin * steps[:, 1], sin * steps[:, 0] + cos * steps[:, 1]])
    xy = start[:2] + np.concatenate([np.zeros((1, 2)), np.cumsum(moved, axis=0)])
    return np.column_stack([xy, se2.wrap(yaw)])


def odometry_covariances(steps: np.ndarray, parameters: LoopClosureParameters) -> np.ndarray:
    """Return the covariances (n, 3, 3) of steps (n, 3) by odometry, as the parameters assume it."""
    p = parameters
    way, turned = np.hypot(steps[:, 0], steps[:, 1]), np.abs(steps[:, 2])
    covariances = np.zeros((len(steps), 3, 3))
    covariances[:, 0, 0] = p.odometry_m_per_sqrt_m**2 * way + STEP_SIGMA_MIN_M**2
    covariances[:, 1, 1] = covariances[:, 0, 0]
    heading = p.odometry_rad_per_sqrt_m**2 * way + p.odometry_rad_per_sqrt_rad**2 * turned
    covariances[:, 2, 2] = heading + STEP_SIGMA_MIN_RAD**2
    return covariances
