"""The map of voxels that a flight without ROS makes, and the planner that follows it."""

from __future__ import annotations

import numpy as np

from exploration.planning import PathPlanner
from gridslam.volume import CorrectedMap, Pose, ShownMap, VolumeParameters
from gridslam.volume.correction.rebuilding import Rebuilding
from gridslam.volume.kernels.tiles import SIDE
from inspection.flight import PriorMap


class VolumeOfFlight:
    """Takes clouds with their poses. The planner gets what has changed, tile by tile.

    corrected: the map. shown: its voxels. planner: plans on it. prior: what is known before the flight; it
    fills for the planner what the map does not know.
    """

    def __init__(self, planner: PathPlanner, parameters: VolumeParameters, prior: PriorMap | None = None):
        self.corrected, self.planner, self._prior = CorrectedMap(parameters), planner, prior
        self.shown = ShownMap(parameters.resolution_m)
        if prior is not None:
            size = parameters.resolution_m, SIDE
            known = prior.tiles(*size)
            unknown = np.zeros((len(known), SIDE**3), np.uint8)
            planner.update_map(*size, known, prior.filled(*size, known, unknown))

    def add(
        self, stamp_s: float, points: np.ndarray, lidar_in_odom: Pose, odom_in_map: Pose | None = None
    ) -> None:
        """Take a cloud (n, 3) of the lidar's frame; raises ScanError if it has no usable point.

        odom_in_map: None: the same frame.
        """
        self.corrected.add(stamp_s, points, lidar_in_odom, odom_in_map or Pose.identity())

    def close_loop(self) -> None:
        """Move all clouds to where odometry told them, as SLAM does when it finds the drift."""
        Rebuilding(self.corrected, [node.sensor_in_odom for node in self.corrected.nodes]).take_over()

    def room_above_m(self, place_m: np.ndarray, wanted_m: float) -> float:
        """Return how far a UAV that stands at a place (x, y, z) may rise; see `PathPlanner.room_above_m`."""
        self.tell_planner()
        return self.planner.room_above_m(place_m, wanted_m)

    def tell_planner(self) -> None:
        """Let the planner know what has changed."""
        changed = self.shown.refresh(self.corrected)
        if len(changed):
            kinds = self.shown.kinds[self.shown.indices(changed)]
            if self._prior is not None:
                kinds = self._prior.filled(self.shown.resolution_m, SIDE, changed, kinds)
            self.planner.update_map(self.shown.resolution_m, SIDE, changed, kinds)
