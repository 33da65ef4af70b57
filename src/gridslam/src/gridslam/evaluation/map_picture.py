"""A map beside the true world: the picture of the map error."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Sequence

import numpy as np

from gridslam import se2
from gridslam.evaluation.map_error import MapAccuracy
from gridslam.evaluation.walls import WallPoints, Walls
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.trajectory import Trajectory

if TYPE_CHECKING:  # matplotlib takes half a second to import
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GREY_UNKNOWN, GREY_FREE, GREY_OCCUPIED = 0.80, 1.0, 0.0
TRUE_WALL = "#e8711a"  # mid grey in print, where the map itself is black and white
MARGIN_M = 1.0
PLAN_PIXELS = (700, 470)  # the plan's approximate share of the picture, in x and y


def draw_map_error(
    path: Path,
    grid: OccupancyGrid,
    walls: Walls | WallPoints,
    accuracy: MapAccuracy,
    map_in_world: tuple[float, float, float] = (0.0, 0.0, 0.0),
    estimate: Trajectory | None = None,
    truth: Trajectory | None = None,
) -> None:
    """Write the picture of `map_error_figure` as PNG. The file's ending does not matter."""
    figure = map_error_figure(grid, walls, accuracy, map_in_world, estimate, truth)
    figure.savefig(path, dpi=120, format="png")


def map_error_figure(
    grid: OccupancyGrid,
    walls: Walls | WallPoints,
    accuracy: MapAccuracy,
    map_in_world: tuple[float, float, float] = (0.0, 0.0, 0.0),
    estimate: Trajectory | None = None,
    truth: Trajectory | None = None,
) -> Figure:
    """Return a figure with map, true walls and both paths, and beside them the cells' errors."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 5.0), layout="constrained")
    plan, spread = figure.subplots(1, 2, gridspec_kw={"width_ratios": (2.2, 1.0)})
    _draw_plan(plan, grid, walls, map_in_world)
    for trajectory, style, label in ((truth, "0.55", "true path"), (estimate, "#2b6cb0", "estimated path")):
        if trajectory is not None:
            points = trajectory.poses_in_map[:, :2]
            points = points if trajectory is truth else se2.transform(map_in_world, points)
            plan.plot(*points.T, color=style, lw=1.2, ls="--" if trajectory is truth else "-", label=label)
    plan.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncol=3, frameon=False, fontsize=8)
    _draw_spread(spread, grid, walls, accuracy, map_in_world)
    return figure


def _draw_plan(
    ax: Axes, grid: OccupancyGrid, walls: Walls | WallPoints, map_in_world: Sequence[float]
) -> None:
    from matplotlib.transforms import Affine2D

    lines = walls.ends_m.reshape(-1, 2, 2) if isinstance(walls, Walls) else walls.points_xy_m
    shown = np.concatenate([lines.reshape(-1, 2), se2.transform(map_in_world, grid.occupied_xy())])
    lowest, highest = shown.min(axis=0) - MARGIN_M, shown.max(axis=0) + MARGIN_M
    shade, shade_m = shades(grid, float(((highest - lowest) / PLAN_PIXELS).max()))
    (x, y), (height, width) = grid.origin_xy_m, np.array(shade.shape) * shade_m
    placed = Affine2D().rotate(map_in_world[2]).translate(*map_in_world[:2]) + ax.transData
    ax.imshow(
        shade,
        cmap="gray",
        vmin=0.0,
        vmax=1.0,
        origin="lower",
        extent=(x, x + width, y, y + height),
        interpolation="nearest",
        transform=placed,
    )
    if isinstance(walls, Walls):
        gaps = np.full((len(lines), 1, 2), np.nan)
        line = np.concatenate([lines, gaps], axis=1).reshape(-1, 2)
        ax.plot(*line.T, color=TRUE_WALL, lw=0.9, label="true walls")
    else:
        ax.plot(*lines.T, ".", color=TRUE_WALL, ms=1.0, label="true walls")
    ax.set(
        xlim=(lowest[0], highest[0]),
        ylim=(lowest[1], highest[1]),
        aspect="equal",
        xlabel="x [m]",
        ylabel="y [m]",
        facecolor=str(GREY_UNKNOWN),
    )


def shades(grid: OccupancyGrid, pixel_m: float) -> tuple[np.ndarray, float]:
    """Return a map's greys, (h, w) from 0 black to 1 white, row 0 lowest, and the size of each, m.

    If a pixel of the picture is larger than a cell, it takes the darkest of the cells that it covers.
    Otherwise a wall of one cell would vanish between two pixels.
    """
    shade = np.full(grid.cells.shape, GREY_UNKNOWN)
    known = grid.cells >= 0
    shade[known] = GREY_FREE + (GREY_OCCUPIED - GREY_FREE) * grid.cells[known] / 100.0
    side = max(1, math.ceil(pixel_m / grid.resolution_m))
    height, width = shade.shape
    shade = np.pad(shade, ((0, -height % side), (0, -width % side)), constant_values=GREY_FREE)
    blocks = shade.reshape(shade.shape[0] // side, side, shade.shape[1] // side, side)
    return blocks.min(axis=(1, 3)), side * grid.resolution_m


def _draw_spread(
    ax: Axes,
    grid: OccupancyGrid,
    walls: Walls | WallPoints,
    accuracy: MapAccuracy,
    map_in_world: Sequence[float],
) -> None:
    distance = np.sort(walls.distances(se2.transform(map_in_world, grid.occupied_xy()))[0])
    ax.plot(distance, np.arange(1, len(distance) + 1) / len(distance) * 100.0, color="k", lw=1.5)
    for value, label, style in ((accuracy.mean_m, "mean", ":"), (accuracy.p95_m, "95 %", "--")):
        ax.axvline(value, color="0.4", ls=style, lw=1.0, label=f"{label}: {value:.3f} m")
    ax.set(
        xlabel="distance from the nearest true wall [m]",
        ylabel="occupied cells [%]",
        xlim=(0.0, max(0.1, 1.6 * accuracy.p95_m)),
        ylim=(0.0, 101.0),
    )
    title = f"{accuracy.seen_share:.0%} of the true walls seen within {accuracy.seen_within_m:g} m"
    if accuracy.walls:
        title += f"\nwalls straight within {accuracy.straightness_rms_m:.3f} m (RMS)"
    ax.set_title(title, fontsize=9)
    ax.spines[["top", "right"]].set_visible(False)
    ax.set_box_aspect(1.0)
    ax.legend(loc="lower right", frameon=False, fontsize=8)
