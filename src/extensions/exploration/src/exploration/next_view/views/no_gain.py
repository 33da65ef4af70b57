"""What was looked at without information gain: it stayed unknown, and is not looked at again and again."""

from __future__ import annotations

import numpy as np

from exploration.next_view.frontiers import ascending

SAME = 0.8
"""A cell has not changed if it still has this share of its voxels."""
TRIES = 1.0
"""A cell does not count any more after views without gain that count so much."""


class CellsWithoutGain:
    """Cells that were looked at, and how often without gain. A cell that has changed begins anew."""

    def __init__(self) -> None:
        self._cells: dict[tuple[int, ...], tuple[int, float]] = {}
        """By cell: its voxels when it was looked at, and what the views count."""

    def note(self, cells: np.ndarray, counts: np.ndarray, views: np.ndarray) -> None:
        """Take views of cells (n, 3) that still have so many voxels (n,); the views count so much (n,)."""
        for cell, count, view in zip(map(tuple, cells.tolist()), counts.tolist(), views.tolist()):
            before, tries = self._cells.get(cell, (count, 0.0))
            self._cells[cell] = (count, (tries if count >= SAME * before else 0.0) + view)

    def is_left(self, cells: np.ndarray, counts: np.ndarray) -> np.ndarray:
        """Return (n,) whether cells (n, 3) with so many voxels (n,) were looked at often enough."""
        often = [(cell, before) for cell, (before, tries) in self._cells.items() if tries >= TRIES]
        if not often:
            return np.zeros(len(cells), bool)
        keys = ascending(np.array([cell for cell, _ in often], np.int64))
        order = np.argsort(keys)
        keys, before = keys[order], np.array([voxels for _, voxels in often], float)[order]
        asked = ascending(cells)
        at = np.minimum(np.searchsorted(keys, asked), len(keys) - 1)
        is_left: np.ndarray = (keys[at] == asked) & (counts >= SAME * before[at])
        return is_left

    def left(self) -> np.ndarray:
        """Return the cells (n, 3) that were looked at often enough, changed or not."""
        left = [cell for cell, (_, tries) in self._cells.items() if tries >= TRIES]
        return np.array(left, np.int64).reshape(-1, 3)
