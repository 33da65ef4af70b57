"""The picture of an exploration: the map, cut open, the path through it, and what was known when."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from flights.results.picture_files import pdf, png
from flights.results.run_folder import RunFolder
from gridslam.volume import read_octree
from gridslam.volume.drawing.picture import VIEWS, explain, volume_figure
from gridslam.volume.voxel_map import VoxelMap

if TYPE_CHECKING:  # matplotlib takes half a second to import
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PATH = "#d1410c"
LINE, CASING = 1.0, 2.2
"""Widths in points. The casing lets the path stand out from the map."""
KNOWN = 0.99


def write_explored(folder: RunFolder, map_path: Path, path_m: np.ndarray, known: np.ndarray) -> None:
    """Write explored.png and explored.pdf.

    path_m: (n, 3) of the UAV in the map's frame. known: (m, 2) seconds from the begin, and volume in m3.

    Raises:
        SlamError: the map cannot be read.
    """
    figure = explored_figure(read_octree(map_path), path_m, known)
    folder.write_files({"explored.png": png(figure), "explored.pdf": pdf(figure)})


def explored_figure(voxels: VoxelMap, path_m: np.ndarray, known: np.ndarray) -> Figure:
    """Return the picture. path_m, known: as of `write_explored`."""
    figure = volume_figure(voxels, "The map, cut open, and the path of the UAV")
    if figure.axes:  # a map without occupied voxels has none
        above, free, side, front, *_ = figure.axes
        for panel, (right, up, _) in zip((above, side, front), VIEWS):
            _draw_path(panel, path_m[:, (right, up)])
        if len(known):
            _draw_known(free, known)
        explain(figure, _path_keys())
    return figure


def _path_keys() -> list[Artist]:
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], color=PATH, linewidth=LINE, label="path of the UAV"),
        Line2D([], [], color=PATH, marker="o", markeredgecolor="white", linestyle="", label="start"),
    ]


def _draw_path(panel: Axes, path_m: np.ndarray) -> None:
    panel.plot(*path_m.T, color="white", linewidth=CASING)
    panel.plot(*path_m.T, color=PATH, linewidth=LINE)
    panel.plot(*path_m[0], "o", color=PATH, markeredgecolor="white", markersize=6)


def _draw_known(panel: Axes, known: np.ndarray) -> None:
    """Draw the known volume over the time, and when almost all of it was known."""
    panel.set_axis_on()
    panel.plot(*known.T, color=PATH, linewidth=1.5)
    enough_s = known[known[:, 1] >= KNOWN * known[-1, 1]][0, 0]
    panel.axvline(enough_s, color="grey", linewidth=0.8, linestyle="--")
    whole = f"{100 * KNOWN:.0f} % of these {known[-1, 1]:.0f} m³"
    panel.set_title(f"known volume; {whole} after {enough_s:.0f} s", fontsize=9)
    panel.set(xlabel="time [s]", ylabel="known volume [m³]", xlim=(0.0, known[-1, 0]), ylim=(0.0, None))
    panel.spines[["top", "right"]].set_visible(False)
