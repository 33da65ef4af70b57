"""The border of what is known, without the cells that were looked at without information gain."""

from __future__ import annotations

import math

import numpy as np

from exploration.next_view.frontiers import Frontiers
from exploration.next_view.views.no_gain import CellsWithoutGain
from exploration.next_view.views.scene import Scene
from exploration.next_view.views.view import Look

NEAR, FAR = 1.0, 0.5
"""What a view without gain from the nearer half of the lidar's reach counts, and one from the other half."""


class BorderWithoutGain:
    """Remembers which cells of the border were looked at without gain: views of them are not retried.

    Args:
        side_m: of the cells. reach_m: of the lidar.
    """

    def __init__(self, side_m: float, reach_m: float) -> None:
        self._side_m, self._reach_m, self._no_gain = side_m, reach_m, CellsWithoutGain()
        self._promised: dict[tuple[int, ...], int] = {}
        """By cell: the voxels that the view shows which the UAV flies to."""

    def promise(self, scene: Scene, cells: Frontiers) -> None:
        """The UAV flies to a view that shows cells."""
        keys = map(tuple, scene.keys(cells, self._side_m).tolist())
        self._promised = dict(zip(keys, cells.counts.tolist()))

    def note(self, scene: Scene, looked: Look, cells: Frontiers) -> None:
        """Count the cells that were looked at, and are still there.

        At its goal, the UAV has also looked at what the view had promised. Else it would fly for ever to and
        fro between what moves away and comes back.
        """
        grid = scene.space.grid
        indices = [index for index in map(grid.index_of, looked.places_m) if index is not None]
        if not indices:
            return
        seen = cells.chosen(scene.gains(np.array(indices), cells)[1])
        keys = scene.keys(seen, self._side_m)
        far_m = [grid.resolution_m * min(math.dist(i, place - 1) for i in indices) for place in seen.places]
        views = looked.counts * np.where(np.array(far_m) <= self._reach_m / 2, NEAR, FAR)
        self._no_gain.note(keys, seen.counts, views)
        if looked.counts == 1.0:
            gone = {
                key: self._promised[key] for key in self._promised.keys() - set(map(tuple, keys.tolist()))
            }
            unseen = np.array(list(gone), np.int64).reshape(-1, 3)
            self._no_gain.note(unseen, np.array(list(gone.values())), np.full(len(gone), FAR))
            self._promised = {}

    def is_left(self, scene: Scene, cells: Frontiers) -> np.ndarray:
        """Return (m,) whether cells were looked at often enough, and have not changed."""
        return self._no_gain.is_left(scene.keys(cells, self._side_m), cells.counts)
