"""The map that the node serves: how it begins, and how it is saved."""

from __future__ import annotations

from typing import Any

import rospy

from gridslam import SlamError
from gridslam.volume import CorrectedMap, read_octree
from gridslam.volume.path_poses import OdometryHistory
from gridslam.volume.saved.map_time import MapTime
from gridslam.volume.saved.saved_map import Restored, read_volume, state_of, write_volume
from gridslam_ros.volume.kept_map import KeptMap
from gridslam_ros.volume.parameters import OctomapParameters


class MapInService:
    """A corrected map, the odometry at its clouds, and their time.

    It begins with the copy of a node that died, or with a saved state, or with the octree of `map_file`.

    Args:
        parameters: of the node.
        lock: held while the map is read or changed.

    Raises:
        SlamError: what it is to begin with cannot be read, or has other voxels.
    """

    def __init__(self, parameters: OctomapParameters, lock: Any) -> None:
        self._parameters, self._lock = parameters, lock
        self._kept = KeptMap(parameters.keep_period)
        self.corrected, self.history, self.time = self._first()
        self.is_begun = bool(self.corrected.events or self.corrected.base)
        """Whether it held something from the start."""

    def _first(self) -> Restored:
        if self._kept.found:
            rospy.logwarn("This node died. It goes on with the map that it had kept.")
            return self._read(self._kept.found)
        if self._parameters.continue_from_state:
            return self._read(self._parameters.state_file.strip())
        path, base = self._parameters.map_file.strip(), None
        if path:
            base = read_octree(path, self._parameters.volume)
            self._require_resolution(path, base.parameters.resolution_m)
        corrected = CorrectedMap(self._parameters.volume, self._parameters.spacing, base)
        return Restored(corrected, OdometryHistory(), MapTime())

    def _read(self, path: str) -> Restored:
        found = read_volume(path)
        self._require_resolution(path, found.corrected.parameters.resolution_m)
        return found

    def _require_resolution(self, path: str, resolution_m: float) -> None:
        if resolution_m != self._parameters.volume.resolution_m:
            raise SlamError(f"{path} has voxels of {resolution_m} m; set resolution to that.")

    def begin_anew(self) -> None:
        """Forget all, after a clock that jumped back."""
        with self._lock:
            self.corrected.reset()
            self.history.clear()
            self.time.take_over(MapTime())

    def save(self, path: str) -> None:
        """Write the complete state; raises StateError if that fails."""
        with self._lock:
            state = state_of(self.corrected, self.history, self.time)
        write_volume(state, path)

    def load(self, path: str) -> None:
        """Go on from a state; raises SlamError if it cannot be used. The map stays as it is then."""
        found = self._read(path)
        with self._lock:
            self.corrected.take_over(found.corrected)
            self.history.take_over(found.history)
            self.time.take_over(found.time)

    def keep_if_due(self, now_s: float) -> None:
        """Replace the copy for a node that dies, if its period is over; raises StateError if that fails."""
        if not self._kept.is_due(now_s):
            return
        with self._lock:
            state = state_of(self.corrected, self.history, self.time)
        self._kept.keep(now_s, state)
