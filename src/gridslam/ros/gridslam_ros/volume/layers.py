"""What slam_octomap shows of its map, and what has changed since it was told."""

from __future__ import annotations

import numpy as np

from gridslam.volume import CorrectedMap, DistanceField, Frontiers, ShownMap
from gridslam_ros.volume.parameters import OctomapParameters


class Layers:
    """What is shown, and the layers for planners. These follow the map once somebody has asked for them."""

    def __init__(self, parameters: OctomapParameters):
        self._resolution_m = parameters.volume.resolution_m
        self._greatest_m = parameters.greatest_distance
        self.shown = ShownMap(self._resolution_m)
        self._distances: DistanceField | None = None
        self._frontiers: Frontiers | None = None
        self._changed: list[np.ndarray] = []
        self._renewed: list[np.ndarray] = []

    def refresh(self, corrected: CorrectedMap) -> None:
        """Follow a map."""
        changed = self.shown.refresh(corrected)
        self._changed.append(changed)
        if self._distances is not None:
            self._renewed.append(self._distances.update(self.shown, changed))
        if self._frontiers is not None:
            self._frontiers.update(self.shown, changed)

    def take_changes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the tiles (n, 3) that changed since the last call, and those (m, 3) with new distances.

        Services refresh between two publications. So each refresh adds to what is to be told.
        """
        changed, self._changed = _united(self._changed), []
        renewed, self._renewed = _united(self._renewed), []
        return changed, renewed

    @property
    def distances(self) -> DistanceField:
        """The distance field; from the first time on, it follows the map."""
        if self._distances is None:
            self._distances = DistanceField(self._resolution_m, self._greatest_m)
            self._distances.update(self.shown, self.shown.known_tiles())
        return self._distances

    @property
    def frontiers(self) -> Frontiers:
        """The frontiers; likewise."""
        if self._frontiers is None:
            self._frontiers = Frontiers(self._resolution_m)
            self._frontiers.update(self.shown, self.shown.known_tiles())
        return self._frontiers


def _united(parts: list[np.ndarray]) -> np.ndarray:
    tiles: np.ndarray = np.unique(np.concatenate([np.zeros((0, 3), np.int64), *parts]), axis=0)
    return tiles
