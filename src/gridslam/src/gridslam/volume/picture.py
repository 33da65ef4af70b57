"""A picture of a map of voxels: from above and from two sides, coloured by height."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from gridslam.volume.voxel_map import VoxelMap

VIEWS = ((0, 1, 2, "from above"), (0, 2, 1, "from the side"), (1, 2, 0, "from the front"))
"""Axes to the right and up, the axis towards the reader, and the title."""
AXES = "xyz"


def volume_figure(voxels: VoxelMap, title: str) -> Figure:
    """Return a picture of the occupied voxels. In each view, the nearest one hides those behind it."""
    centres = occupied_centres(voxels)
    figure = Figure(figsize=(12.0, 5.0), layout="constrained")
    figure.suptitle(title)
    panels = figure.subplots(1, len(VIEWS))
    for panel, (right, up, depth, name) in zip(panels, VIEWS):
        towards = -centres[:, depth] if depth == 1 else centres[:, depth]
        order = np.argsort(towards)
        x, y = centres[order, right], centres[order, up]
        panel.scatter(x, y, c=centres[order, 2], s=1.0, marker="s", cmap="viridis", rasterized=True)
        panel.set(title=name, xlabel=f"{AXES[right]}, m", ylabel=f"{AXES[up]}, m", aspect="equal")
    figure.colorbar(panels[0].collections[0], ax=panels, label="height, m", shrink=0.8)
    return figure


def occupied_centres(voxels: VoxelMap) -> np.ndarray:
    """Return the centres (n, 3) of all occupied voxels, m."""
    box = voxels.box()
    z, y, x = np.nonzero(voxels.values(box) >= 0.0)
    return (np.stack((x, y, z), axis=1) + box.low + 0.5) * voxels.parameters.resolution_m
