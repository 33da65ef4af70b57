"""Registration by other libraries beside our odometry, on the same clouds: kiss-icp and small_gicp.

Neither is a dependency of the workspace: a flight has them beside it where they can be imported. They get the
clouds alone, with one thread, and the pose before the first cloud.
"""

from __future__ import annotations

import time
from typing import Protocol

import numpy as np

from flights.errors import FlightError

NAMES = ("kiss_icp", "small_gicp")
VOXEL_M = 0.5
"""Of both maps: for rooms. kiss-icp's own rule, a hundredth of the greatest range, gives 1 m for the Puck."""
REACH_M = 1.0
THINNED_M = 0.25
NEIGHBOURS = 10
"""Both by small_gicp's own defaults."""


class Registration(Protocol):
    """Follows clouds."""

    def follow(self, points: np.ndarray) -> np.ndarray:
        """Take a cloud (n, 3), float64. Return the lidar's pose (4, 4) in the frame of the first cloud."""


class KissIcp:
    """kiss-icp 1.3 with its defaults, but for the voxels."""

    def __init__(self) -> None:
        from kiss_icp.config import KISSConfig
        from kiss_icp.kiss_icp import KissICP

        config = KISSConfig()
        config.mapping.voxel_size = VOXEL_M
        config.registration.max_num_threads = 1
        config.data.deskew = False
        self._icp = KissICP(config)

    def follow(self, points: np.ndarray) -> np.ndarray:
        """See `Registration`."""
        self._icp.register_frame(points, np.zeros(0))
        pose: np.ndarray = self._icp.last_pose
        return pose


class SmallGicp:
    """small_gicp 1.0.1: cloud to a map of Gaussians (VGICP), with constant speed as the prediction."""

    def __init__(self) -> None:
        import small_gicp

        self._library = small_gicp
        self._map = small_gicp.GaussianVoxelMap(VOXEL_M)
        self._map.set_lru(horizon=1_000_000, clear_cycle=1_000_000)  # it forgets nothing
        self._pose, self._step = np.eye(4), np.eye(4)
        self._is_first = True

    def follow(self, points: np.ndarray) -> np.ndarray:
        """See `Registration`."""
        cloud, _ = self._library.preprocess_points(
            points, downsampling_resolution=THINNED_M, num_neighbors=NEIGHBOURS, num_threads=1
        )
        pose = self._pose
        if not self._is_first:
            found = self._library.align(
                self._map, cloud, self._pose @ self._step, max_correspondence_distance=REACH_M, num_threads=1
            )
            pose = found.T_target_source
        self._step, self._pose, self._is_first = np.linalg.inv(self._pose) @ pose, pose, False
        self._map.insert(cloud, pose)
        return pose


class Beside:
    """One library beside a flight.

    poses: (4, 4) of the lidar at each cloud, in the frame of the first. truth: the same in the world. cpu_ms:
    of each.

    Raises:
        FlightError: the library cannot be imported.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        try:
            self._registration: Registration = KissIcp() if name == "kiss_icp" else SmallGicp()
        except ImportError as error:
            raise FlightError(
                f"{name} is not installed ({error}): pip install kiss-icp==1.3.0 small_gicp==1.0.1 somewhere "
                "that PYTHONPATH names."
            ) from None
        self.poses: list[np.ndarray] = []
        self.truth: list[np.ndarray] = []
        self.cpu_ms: list[float] = []

    def take(self, points: np.ndarray, lidar_in_world: np.ndarray) -> None:
        """Take a cloud (n, 3) and the true pose (4, 4). Points that are not finite do not count."""
        used = points[np.isfinite(points).all(axis=1)].astype(float)
        began = time.process_time()  # a library may use other threads
        self.poses.append(self._registration.follow(used).copy())
        self.cpu_ms.append(1e3 * (time.process_time() - began))
        self.truth.append(lidar_in_world)

    def figures(self) -> dict[str, float]:
        """Return the errors in m, and the CPU time.

        ate_m, worst_m: with the first pose given. aligned_m: of the path that is turned and moved to fit the
        truth best, the root mean square.
        """
        truth = np.array(self.truth)
        found = truth[0] @ np.array(self.poses)
        off_m = np.linalg.norm(found[:, :3, 3] - truth[:, :3, 3], axis=1)
        return {
            "ate_m": float(np.sqrt(np.square(off_m).mean())),
            "worst_m": float(off_m.max()),
            "aligned_m": aligned_m(found[:, :3, 3], truth[:, :3, 3]),
            "cpu_ms": float(np.median(self.cpu_ms)),
        }


def aligned_m(found: np.ndarray, truth: np.ndarray) -> float:
    """Return the root mean square distance of two paths (n, 3), one moved to fit (Umeyama 1991)."""
    a, b = found - found.mean(axis=0), truth - truth.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    signs = np.diag((1.0, 1.0, np.sign(np.linalg.det(u @ vt))))
    return float(np.sqrt(np.square(a @ (u @ signs @ vt) - b).sum(axis=1).mean()))
