"""The pictures of Experiments 3 and 4: world and maps side by side as in the thesis, the error over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from flights.results.flight_pictures import TimeSeries, time_series_figure
from flights.results.palette import BELIEF, TRUTH
from flights.results.solids import draw_solids
from flights.worlds.floor_plan import Outline
from gridslam import OccupancyGrid

_MAP_COLOURS = ListedColormap(("#b3b3b3", "white", "black"))  # unknown, free, occupied, as in the thesis
_CLOSURE = "#15803d"
_OCCUPIED_FROM = 65
_WIDTH_IN = 10.0
_MARGIN_M = 1.0
_LABEL: dict[str, Any] = {"fontsize": 8}


@dataclass(frozen=True)
class MapView:
    """A map and the drawings on it.

    path_xy: SLAM's path at that time, (n, 2). closures_xy: pairs of places on it that SLAM recognised as
    one, (k, 2, 2).
    """

    title: str
    grid: OccupancyGrid
    path_xy: np.ndarray
    closures_xy: np.ndarray


def world_and_maps(
    title: str,
    outlines: Sequence[Outline],
    height_m: float,
    true_path_xy: np.ndarray,
    views: Sequence[MapView],
) -> Figure:
    """Draw the world from above with the true path, and maps beside it at the same scale."""
    low, high = _limits(outlines, views)
    width, height = high - low
    panels = 1 + len(views)
    figure = Figure(figsize=(_WIDTH_IN, _WIDTH_IN / panels * height / width + 0.9), layout="constrained")
    all_axes = figure.subplots(1, panels, sharex=True, sharey=True)
    _draw_world(all_axes[0], outlines, height_m, true_path_xy)
    for axes, view in zip(all_axes[1:], views):
        _draw_map(axes, view)
    for axes in all_axes:
        axes.set_aspect("equal")
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        axes.tick_params(labelsize=7)
        axes.set_xlabel("x [m]", **_LABEL)
    all_axes[0].set_ylabel("y [m]", **_LABEL)
    figure.suptitle(title, fontsize=9)
    return figure


def error_figure(title: str, panels: Sequence[TimeSeries], closure_times_s: Sequence[float]) -> Figure:
    """Draw errors over time, and below them the number of loops closed so far."""
    closed = np.sort(np.asarray(closure_times_s, dtype=float))
    if len(closed):
        times = panels[0].curves[0][1][:, 0]
        stairs = _stairs(closed, times[0], times[-1])
        panels = (*panels, TimeSeries("loops closed", (("loops closed", stairs),)))
    return time_series_figure(title, tuple(panels))


def _stairs(times: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Return (n, 2): the number of past times, as steps."""
    x = np.concatenate(([begin], np.repeat(times, 2), [end]))
    y = np.repeat(np.arange(len(times) + 1), 2)
    return np.column_stack((x, y))


def _limits(outlines: Sequence[Outline], views: Sequence[MapView]) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of the world and of all occupied cells, with a margin."""
    points = [outline.outline_xy for outline in outlines]
    points += [view.grid.occupied_xy(_OCCUPIED_FROM) for view in views]
    together = np.concatenate(points)
    return together.min(axis=0) - _MARGIN_M, together.max(axis=0) + _MARGIN_M


def _draw_world(axes: Axes, outlines: Sequence[Outline], height_m: float, true_path_xy: np.ndarray) -> None:
    draw_solids(axes, (o.outline_xy for o in outlines if o.blocks(height_m)))
    axes.plot(*true_path_xy.T, color=TRUTH, lw=0.9)
    axes.plot(*true_path_xy[0], "o", ms=4, mfc="white", mec="black")
    axes.set_title("world, true path", fontsize=8)


def _draw_map(axes: Axes, view: MapView) -> None:
    cells = view.grid.cells
    shades = np.where(cells < 0, 0, np.where(cells >= _OCCUPIED_FROM, 2, 1))
    (x, y), (width, height) = view.grid.origin_xy_m, view.grid.size_m
    axes.set_facecolor(_MAP_COLOURS(0))
    axes.imshow(
        shades,
        cmap=_MAP_COLOURS,
        vmin=0,
        vmax=2,
        origin="lower",
        extent=(x, x + width, y, y + height),
        interpolation="none",  # one pixel for each cell, in SVG too
    )
    axes.plot(*view.path_xy.T, color=BELIEF, lw=0.7)
    for pair in view.closures_xy:
        axes.plot(*pair.T, "o-", color=_CLOSURE, lw=0.8, ms=2.0)
    axes.set_title(view.title, fontsize=8)
