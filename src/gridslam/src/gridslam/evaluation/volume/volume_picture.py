"""A map of voxels beside the true surfaces: three sections, the distances, what is mapped of each thing."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import trimesh

from gridslam.evaluation.volume.surface import Surface
from gridslam.evaluation.volume.visibility import Places
from gridslam.evaluation.volume.volume_error import VolumeError, Voxels

if TYPE_CHECKING:  # matplotlib takes half a second to import
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.figure import Figure

AXES = "xyz"
SECTIONS = ((0, 1, 2), (0, 2, 1), (1, 2, 0))
"""Axis to the right, axis up, axis across the section."""
TRUE, PATH = "#e8711a", "#2b6cb0"
FAR_VOXELS = 2.0
"""A distance of so many voxels has the last colour."""


def draw_volume_error(
    path: Path,
    voxels: Voxels,
    surface: Surface,
    error: VolumeError,
    distances_m: np.ndarray,
    places: Places | None = None,
) -> None:
    """Write the picture of `volume_error_figure` as PNG. The file's ending does not matter."""
    figure = volume_error_figure(voxels, surface, error, distances_m, places)
    figure.savefig(path, dpi=130, format="png")


def volume_error_figure(
    voxels: Voxels,
    surface: Surface,
    error: VolumeError,
    distances_m: np.ndarray,
    places: Places | None = None,
) -> Figure:
    """Return a figure with three sections through the middle of the way, or of the map without one.

    distances_m: (n,) of the occupied voxels.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.0, 7.2), layout="constrained")
    grid = figure.add_gridspec(2, 6)
    plots = [
        figure.add_subplot(grid[0, :4]),
        figure.add_subplot(grid[1, :4]),
        figure.add_subplot(grid[0, 4:]),
    ]
    middle_m = _middle(voxels, places)
    for plot, section in zip(plots, SECTIONS):
        marks = _draw_section(plot, voxels, surface, distances_m, section, middle_m, places)
    figure.colorbar(marks, ax=plots[1], label="distance from the true surface, m", shrink=0.8)
    below = grid[1, 4:].subgridspec(2, 1, hspace=0.1)
    _draw_distances(figure.add_subplot(below[0]), distances_m, error)
    _draw_parts(figure.add_subplot(below[1]), error)
    return figure


def _middle(voxels: Voxels, places: Places | None) -> np.ndarray:
    """Return the place (3,) through which the sections lead: that of the path nearest to its median."""
    if places is None:
        return np.median(voxels.occupied_m, axis=0)
    apart = np.linalg.norm(places.positions_m - np.median(places.positions_m, axis=0), axis=1)
    return places.positions_m[apart.argmin()]


def _draw_section(
    plot: Axes,
    voxels: Voxels,
    surface: Surface,
    distances_m: np.ndarray,
    section: tuple[int, int, int],
    middle_m: np.ndarray,
    places: Places | None,
) -> PathCollection:
    right, up, across = section
    cut = np.abs(voxels.occupied_m[:, across] - middle_m[across]) <= 0.5 * voxels.resolution_m + 1e-9
    at, far_m = voxels.occupied_m[cut], FAR_VOXELS * voxels.resolution_m
    for line in _cut_lines(surface, across, middle_m):
        plot.plot(line[:, right], line[:, up], color=TRUE, lw=0.8, zorder=1)
    marks = plot.scatter(
        at[:, right],
        at[:, up],
        c=distances_m[cut],
        s=5,
        marker="s",
        lw=0,
        cmap="viridis_r",
        vmin=0.0,
        vmax=far_m,
    )
    if places is not None:
        plot.plot(*places.positions_m[:, (right, up)].T, color=PATH, lw=0.8, alpha=0.7)
    span = voxels.occupied_m[:, (right, up)]
    margin = 5 * voxels.resolution_m
    plot.set_xlim(span[:, 0].min() - margin, span[:, 0].max() + margin)
    plot.set_ylim(span[:, 1].min() - margin, span[:, 1].max() + margin)
    plot.set_aspect("equal")
    plot.set_xlabel(f"{AXES[right]}, m")
    plot.set_ylabel(f"{AXES[up]}, m")
    plot.set_title(f"section at {AXES[across]} = {middle_m[across]:.2f} m", fontsize=9)
    return marks


def _cut_lines(surface: Surface, across: int, middle_m: np.ndarray) -> np.ndarray:
    """Return the true surfaces' lines (n, 2, 3) in the plane through the middle, across an axis."""
    triangles = surface.triangles_m
    mesh = trimesh.Trimesh(
        triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), process=False
    )
    return trimesh.intersections.mesh_plane(mesh, np.eye(3)[across], middle_m)


def _draw_distances(plot: Axes, distances_m: np.ndarray, error: VolumeError) -> None:
    rising = np.sort(distances_m)
    plot.plot(rising, np.arange(1, len(rising) + 1) / len(rising), color="black", lw=1.2)
    plot.axvline(error.p95_m, color=TRUE, lw=1.0, label=f"95 %: {error.p95_m:.3f} m")
    plot.set_xlim(0.0, max(1.5 * error.p95_m, 1e-3))
    plot.set_ylim(0.0, 1.0)
    plot.set_xlabel("distance from the true surface, m", fontsize=8)
    plot.set_ylabel("share of voxels", fontsize=8)
    plot.legend(loc="lower right", frameon=False, fontsize=8)


def _draw_parts(plot: Axes, error: VolumeError) -> None:
    if not error.mapped_by_part:
        plot.set_axis_off()
        return
    names = sorted(error.mapped_by_part, key=error.mapped_by_part.__getitem__)
    shares = [100.0 * error.mapped_by_part[name] for name in names]
    plot.barh(names, shares, color="0.6", height=0.7)
    for row, share in enumerate(shares):
        plot.text(1.5, row, f"{share:.1f} %", va="center", fontsize=7)
    plot.set_xlim(0.0, 100.0)
    plot.set_xlabel("visible surface that is mapped, %", fontsize=8)
    plot.tick_params(labelsize=8)
