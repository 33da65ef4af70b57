"""The picture of an exploration: the map, cut open, and the path through it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gridslam.volume import read_octree
from gridslam.volume.drawing.picture import VIEWS, volume_figure
from master_thesis.results.picture_files import png
from master_thesis.results.run_folder import RunFolder

PATH = "#d1410c"


def write_explored(folder: RunFolder, map_path: Path, path_m: np.ndarray) -> None:
    """Write explored.png. path_m: (n, 3) of the UAV in the map's frame.

    Raises:
        SlamError: the map cannot be read.
    """
    figure = volume_figure(read_octree(map_path), "The map, cut open, and the path of the UAV")
    above, _, side, front, *_ = figure.axes  # the second one is free
    for panel, (right, up, _) in zip((above, side, front), VIEWS):
        panel.plot(path_m[:, right], path_m[:, up], color=PATH, linewidth=1.2)
        panel.plot(*path_m[0, [right, up]], "o", color=PATH, markeredgecolor="black")
    folder.write_files({"explored.png": png(figure)})
