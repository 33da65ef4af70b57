"""Matches a cloud with the map of planes, weighed against a prediction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gridslam.cloud_odometry.kernels.planes import normal_equations
from gridslam.cloud_odometry.parameters import CloudOdometryParameters
from gridslam.cloud_odometry.plane_map import PlaneMap
from gridslam.cloud_odometry.rotations import matrix_of, vector_of

STEPS_MAX = 12
SHRINKS = 0.6
"""The reach of one step, of the one before it."""
LEAST_INFORMATION = 1e-2
"""1/m2 and 1/rad2: of any direction."""
STILL = 2e-4
"""m and rad: a smaller step is the last one."""


@dataclass(frozen=True)
class PoseInSpace:
    """place: (3,) m, and rotation: (3, 3), base to map."""

    place: np.ndarray
    rotation: np.ndarray

    def difference(self, other: PoseInSpace) -> np.ndarray:
        """Return (6,): the move and the turn, in the map's axes, from the other pose to this one."""
        turn = vector_of(self.rotation @ other.rotation.T)
        return np.concatenate((self.place - other.place, turn))

    def moved(self, step: np.ndarray) -> PoseInSpace:
        """Return the pose after a move and a turn (6,), in the map's axes."""
        return PoseInSpace(self.place + step[:3], matrix_of(step[3:]) @ self.rotation)


@dataclass(frozen=True)
class CloudMatch:
    """Result of a match."""

    pose: PoseInSpace
    information: np.ndarray
    """(6, 6) of the cloud alone: move and turn in the map's axes."""
    points: int
    """That were matched."""
    found: int
    """Points in voxels that hold a plane."""
    near: int
    """Those that lie on it, within `last_reach_m`."""
    pull: np.ndarray
    """(6,) information times the step that the cloud alone would take from here."""

    @property
    def known(self) -> float:
        """Share of the points where the map has a plane."""
        return self.found / max(self.points, 1)

    @property
    def agreement(self) -> float:
        """Share of the points where the map has a plane that lie on it."""
        return self.near / max(self.found, 1)

    def height_alone(self) -> tuple[float, float]:
        """Return the height in m that the cloud alone tells, without the prediction, and its variance."""
        spread = np.linalg.inv(self.information + LEAST_INFORMATION * np.eye(6))
        return float(self.pose.place[2] + spread[2] @ self.pull), float(spread[2, 2])

    def untold(self, told_m: float) -> np.ndarray:
        """Return the directions (k, 3) along which the cloud alone does not tell the place."""
        turn = self.information[3:, 3:] + 1e-9 * np.eye(3)
        across = self.information[:3, 3:]
        of_place: np.ndarray = self.information[:3, :3] - across @ np.linalg.solve(turn, across.T)
        strengths, axes = np.linalg.eigh(of_place)
        return axes.T[strengths < told_m**-2]


def match(
    planes: PlaneMap,
    points: np.ndarray,
    weights: np.ndarray,
    origin: np.ndarray,
    predicted: PoseInSpace,
    prior: np.ndarray,
    p: CloudOdometryParameters,
) -> CloudMatch:
    """Find the pose by Gauss and Newton: point to plane (Chen and Medioni 1992), and the prediction.

    Args:
        planes: the map.
        points: (n, 3) in the base frame, m.
        weights: (n,) of the points, 1/m2.
        origin: (3,) of the lidar in the base frame, m.
        predicted: the pose before.
        prior: (6, 6) information of the prediction: move and turn in the map's axes.
        p: parameters.

    References: Vizzo et al. 2023 (KISS-ICP) for a robust kernel that shrinks; Yuan et al. 2022 for planes in
    voxels of several sizes.
    """
    information, pull = np.empty((6, 6)), np.empty(6)
    pose, reach_m, found, near = predicted, p.first_reach_m, 0, 0
    for _ in range(STEPS_MAX):
        found, near = normal_equations(
            points,
            weights,
            origin,
            pose.rotation,
            pose.place,
            planes.levels_m,
            reach_m,
            planes.keys,
            planes.planes,
            information,
            pull,
        )
        step = np.linalg.solve(information + prior, pull - prior @ pose.difference(predicted))
        pose = pose.moved(step)
        if reach_m <= p.last_reach_m and np.abs(step).max() < STILL:
            break
        reach_m = max(SHRINKS * reach_m, p.last_reach_m)
    return CloudMatch(pose, information, len(points), found, near, pull)
