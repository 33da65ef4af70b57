"""The pictures of a flight: the world from above with the path, and the flight over time.

Made to be printed: legible in grey, equal scales, units on every axis. Needs matplotlib, no display.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.transforms import ScaledTranslation

from flights.results.palette import SOLID
from flights.results.solids import draw_solids, solid_mark
from flights.worlds.floor_plan import Outline

_WIDTH_IN = 7.2  # a paper's two columns
_PATH_STEP_M = 0.05  # a vector picture draws each piece of the coloured path on its own
_LOW, _HIT = "#d9d9d6", "#c2410c"
_STYLE: dict[str, Any] = {"fontsize": 8}


@dataclass(frozen=True)
class TopView:
    """The content of a picture from above.

    path: (n, 3) of x, y in metres and the value that colours it; hits_xy: where lidar beams ended, (m, 2);
    emergencies_xy: places of emergency avoidance, (k, 2); flight_height_m: shapes at this height are drawn
    dark, lower and higher ones light. value_range: of the colours; values beyond it get the colour of the
    end.
    """

    title: str
    outlines: list[Outline]
    path: np.ndarray
    value_label: str
    start_xy: tuple[float, float]
    goal_xy: tuple[float, float]
    hits_xy: np.ndarray
    emergencies_xy: np.ndarray
    flight_height_m: float = 2.0
    value_range: tuple[float, float] | None = None


def top_view_figure(view: TopView) -> Figure:
    """Draw the world from above with the path coloured by a value."""
    low, high = _limits(view)
    width, height = high - low
    figure = Figure(figsize=(_WIDTH_IN, (_WIDTH_IN - 0.7) * height / width + 1.25))
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    _draw_outlines(axes, view)
    axes.scatter(
        view.hits_xy[:, 0], view.hits_xy[:, 1], s=0.5, color=_HIT, linewidths=0, zorder=3, rasterized=True
    )
    path = _draw_path(axes, view)
    axes.plot(*view.start_xy, "o", ms=6, mfc="white", mec="black", mew=1.2, zorder=6)
    axes.plot(*view.goal_xy, "*", ms=11, mfc="white", mec="black", mew=1.0, zorder=6)
    axes.plot(*view.emergencies_xy.T, "x", ms=4, color="black", mew=0.9, zorder=7)
    axes.set_xlabel("x [m]", **_STYLE)
    axes.set_ylabel("y [m]", **_STYLE)
    axes.set_title(view.title, fontsize=9)
    axes.tick_params(labelsize=7)
    beyond = view.value_range is not None and view.path[:, 2].max() > view.value_range[1]
    place = axes.inset_axes((1.012, 0.0, 0.018, 1.0))
    bar = figure.colorbar(path, cax=place, extend="max" if beyond else "neither")
    bar.set_label(view.value_label, **_STYLE)
    bar.ax.tick_params(labelsize=7)
    _legend(axes, view)
    return figure


def _limits(view: TopView) -> np.ndarray:
    """Return the lower left and upper right corner of the path and at least 3 m around it."""
    points = np.concatenate((view.path[:, :2], [view.start_xy], [view.goal_xy]))
    low, high = points.min(axis=0) - 3.0, points.max(axis=0) + 3.0
    if len(view.hits_xy):  # the part that the lidar saw, not the whole world
        seen = np.percentile(view.hits_xy, (1, 99), axis=0)
        low, high = np.minimum(low, seen[0] - 1.0), np.maximum(high, seen[1] + 1.0)
    reach = 0.3 * (high - low).max()
    middle = (low + high) / 2
    return np.array((np.minimum(low, middle - reach / 2), np.maximum(high, middle + reach / 2)))


def _draw_outlines(axes: Axes, view: TopView) -> None:
    for blocks, colour, order in ((False, _LOW, 1), (True, SOLID, 2)):
        shapes = (o.outline_xy for o in view.outlines if o.blocks(view.flight_height_m) is blocks)
        draw_solids(axes, shapes, colour, zorder=order)


def _draw_path(axes: Axes, view: TopView) -> LineCollection:
    flown_m = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(view.path[:, :2], axis=0).T))))
    steps = np.flatnonzero(np.diff(np.floor(flown_m / _PATH_STEP_M), prepend=-1.0))
    path = view.path[np.append(steps, len(flown_m) - 1)]
    points = path[:, :2]
    segments = np.stack((points[:-1], points[1:]), axis=1)
    axes.plot(*points.T, color="black", linewidth=3.2, solid_capstyle="round", zorder=4)
    lines = LineCollection(segments, cmap="viridis", linewidth=2.2, capstyle="round", zorder=5)
    lines.set_array(path[:-1, 2])
    if view.value_range:
        lines.set_clim(*view.value_range)
    axes.add_collection(lines)
    return lines


def _legend(axes: Axes, view: TopView) -> None:
    handles: list[Line2D | Patch] = [
        Line2D([], [], marker="o", ls="", ms=5, mfc="white", mec="black", label="start"),
        Line2D([], [], marker="*", ls="", ms=8, mfc="white", mec="black", label="goal"),
        Line2D([], [], color="#21918c", lw=2.2, label="path"),
    ]
    if view.outlines:
        handles.append(solid_mark("obstacle"))
    if any(not outline.blocks(view.flight_height_m) for outline in view.outlines):
        handles.append(solid_mark("below or above the flight", _LOW))
    if len(view.hits_xy):
        handles.append(Line2D([], [], marker=".", ls="", ms=4, color=_HIT, label="lidar"))
    if len(view.emergencies_xy):
        handles.append(Line2D([], [], marker="x", ls="", ms=4, color="black", label="emergency"))
    below_the_label = ScaledTranslation(0.0, -0.36, axes.figure.dpi_scale_trans)
    axes.legend(
        handles=handles,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=axes.transAxes + below_the_label,
        ncol=len(handles),
        fontsize=7,
        frameon=False,
        handletextpad=0.4,
        columnspacing=1.2,
    )


@dataclass(frozen=True)
class TimeSeries:
    """One panel of the flight over time: curves (label, (n, 2) of time and value), a unit, a limit line."""

    label: str
    curves: tuple[tuple[str, np.ndarray], ...]
    limit: tuple[str, float] | None = None


def time_series_figure(
    title: str, panels: tuple[TimeSeries, ...], event: tuple[str, float] | None = None
) -> Figure:
    """Draw panels over a common time axis. event: name and time of a vertical line through all of them."""
    figure = Figure(figsize=(_WIDTH_IN, 1.35 * len(panels) + 0.6), layout="constrained")
    all_axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    styles = (("#1f3b73", "-"), ("#c2410c", "--"), ("black", ":"))
    for axes, panel in zip(all_axes, panels):
        for (label, curve), (colour, dashes) in zip(panel.curves, styles):
            axes.plot(*curve.T, dashes, color=colour, lw=1.0, label=label)
        if panel.limit:
            axes.axhline(panel.limit[1], color="black", lw=0.7, ls=(0, (5, 3)), label=panel.limit[0])
        if event:
            name = event[0] if axes is all_axes[0] else None
            axes.axvline(event[1], color="black", lw=0.9, ls=":", label=name)
        axes.set_ylabel(panel.label, **_STYLE)
        axes.tick_params(labelsize=7)
        axes.grid(alpha=0.3, lw=0.4)
        if len(axes.get_legend_handles_labels()[0]) > 1:
            axes.legend(
                fontsize=7, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5)
            )  # off the curves
    all_axes[0].set_title(title, fontsize=9)
    all_axes[-1].set_xlabel("time [s]", **_STYLE)
    figure.align_ylabels(all_axes)
    return figure
