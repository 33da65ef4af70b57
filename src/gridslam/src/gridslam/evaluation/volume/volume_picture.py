"""A map of voxels beside the true surfaces: cut open, its errors in sections, and what is mapped."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import trimesh

from gridslam.evaluation.volume.surface import Surface
from gridslam.evaluation.volume.visibility import Places
from gridslam.evaluation.volume.volume_error import VolumeError
from gridslam.evaluation.volume.voxels import Voxels
from gridslam.files.replacing import replace_file
from gridslam.volume.drawing.picture import (
    HEIGHT_LABEL,
    VIEWS,
    draw_cut_open,
    pixels,
    projections,
    show_pixels,
)

if TYPE_CHECKING:  # matplotlib takes half a second to import
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

TRUE, PATH = "#e8711a", "#c2185b"
ERRORS = "viridis_r"
FAR_VOXELS = 2.0
"""A distance of so many voxels has the last colour."""
TURNED_PIXEL = 1.5
"""Pixels of a map that is turned against the world are so many voxels wide: no gaps open between voxels."""
PARTS_MAX = 10
"""Things that are listed: of more, the least mapped."""


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
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=150, format="png")
    replace_file(path, drawn.getvalue())


def volume_error_figure(
    voxels: Voxels,
    surface: Surface,
    error: VolumeError,
    distances_m: np.ndarray,
    places: Places | None = None,
) -> Figure:
    """Return a figure: the map cut open, coloured by height; the same cuts, coloured by error; the shares.

    The cuts lead through the middle of the way, or of the map without one. distances_m: (n,) of the occupied
    voxels.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14.0, 6.6), layout="constrained")
    figure.suptitle(_title(voxels, error), fontsize=11)
    halves: Any = figure.subfigures(1, 2)
    left, right = halves
    middle_m, centres = _middle(voxels, places), voxels.occupied_m
    (panels, spread), (sections, parts) = projections(left, centres), projections(right, centres)
    for view, panel, section in zip(VIEWS, panels, sections):
        heights = draw_cut_open(panel, centres, _pixel_m(voxels), view, middle_m[view[2]])
        errors = _draw_section(section, voxels, surface, distances_m, view, middle_m)
        if places is not None:
            for each in (panel, section):
                each.plot(*places.positions_m[:, view[:2]].T, color=PATH, lw=0.8)
    bar = {"location": "bottom", "aspect": 50}
    left.colorbar(heights, ax=[*panels, spread], label=HEIGHT_LABEL, **bar)
    right.colorbar(
        errors, ax=[*sections, parts], label="distance from the true surface [m]", extend="max", **bar
    )
    sections[0].set_title(f"{sections[0].get_title()}; orange: true surface", fontsize=9)
    _draw_distances(spread, distances_m, error, voxels.resolution_m)
    _draw_parts(parts, error)
    return figure


def _title(voxels: Voxels, error: VolumeError) -> str:
    title = f"{error.occupied_voxels:,} occupied voxels of {voxels.resolution_m:g} m"
    if np.isfinite(error.mapped):
        title += f"; {100 * error.mapped:.1f} % of {error.visible_m2:,.0f} m² of visible surface mapped"
    if np.isfinite(error.free_right):
        title += f"; {100 * error.free_right:.1f} % of the free voxels right"
    return title


def _pixel_m(voxels: Voxels) -> float:
    return voxels.resolution_m * (1.0 if np.allclose(voxels.axes, np.eye(3)) else TURNED_PIXEL)


def _middle(voxels: Voxels, places: Places | None) -> np.ndarray:
    """Return the place (3,) through which the cuts lead."""
    if places is not None:
        return np.median(places.positions_m, axis=0)
    return 0.5 * (voxels.occupied_m.min(axis=0) + voxels.occupied_m.max(axis=0))


def _draw_section(
    panel: Axes,
    voxels: Voxels,
    surface: Surface,
    distances_m: np.ndarray,
    view: tuple[int, int, int],
    middle_m: np.ndarray,
) -> AxesImage:
    right, up, across = view
    cut = np.abs(voxels.occupied_m[:, across] - middle_m[across]) <= 0.5 * _pixel_m(voxels) + 1e-9
    worst_last = np.flatnonzero(cut)[np.argsort(distances_m[cut], kind="stable")]
    shown_m = voxels.occupied_m[:, (right, up)]
    image = pixels(shown_m[worst_last], distances_m[worst_last], shown_m, _pixel_m(voxels))
    shown = show_pixels(panel, image, view, ERRORS, 0.0, FAR_VOXELS * voxels.resolution_m)
    for line in _cut_lines(surface, across, middle_m):
        panel.plot(
            line[:, right], line[:, up], color=TRUE, lw=1.2, zorder=-1
        )  # shows where no voxel covers it
    margin_m = 5 * voxels.resolution_m
    left, last, low, high = image.extent_m
    panel.set(xlim=(left - margin_m, last + margin_m), ylim=(low - margin_m, high + margin_m))
    panel.set_title(f"section at {'xyz'[across]} = {middle_m[across]:.2f} m", fontsize=9)
    return shown


def _cut_lines(surface: Surface, across: int, middle_m: np.ndarray) -> np.ndarray:
    """Return the true surfaces' lines (n, 2, 3) in the plane through the middle, across an axis."""
    triangles = surface.triangles_m
    mesh = trimesh.Trimesh(
        triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), process=False
    )
    return trimesh.intersections.mesh_plane(mesh, np.eye(3)[across], middle_m)


def _draw_distances(panel: Axes, distances_m: np.ndarray, error: VolumeError, resolution_m: float) -> None:
    rising = np.sort(distances_m)
    shares = np.arange(1, len(rising) + 1) / len(rising) * 100.0
    panel.step(rising, shares, color="black", lw=1.4, where="post")
    for value, style in ((error.mean_m, ":"), (error.p95_m, "--")):
        panel.axvline(value, color=TRUE, ls=style, lw=1.2)
    panel.set(xlim=(0.0, max(1.6 * error.p95_m, FAR_VOXELS * resolution_m)), ylim=(0.0, 101.0))
    panel.set(xlabel="distance [m]", ylabel="occupied voxels [%]")
    panel.set_title(f"mean {error.mean_m:.3f} m (dotted)\n95 % {error.p95_m:.3f} m (dashed)", fontsize=9)
    panel.spines[["top", "right"]].set_visible(False)


def _draw_parts(panel: Axes, error: VolumeError) -> None:
    if not error.mapped_by_part:
        panel.set_axis_off()
        return
    names = sorted(error.mapped_by_part, key=error.mapped_by_part.__getitem__)[:PARTS_MAX][::-1]
    shares = [100.0 * error.mapped_by_part[name] for name in names]
    panel.barh(names, shares, color="0.75", height=0.75)
    for row, share in enumerate(shares):
        panel.text(1.0, row, f"{share:.1f} %", va="center", fontsize=8)
    panel.set(xlim=(0.0, 100.0), xlabel="visible surface mapped [%]")
    hidden = len(error.mapped_by_part) - len(names)
    if hidden:
        panel.set_title(f"the {len(names)} least of {len(names) + hidden} things", fontsize=9)
    panel.spines[["top", "right"]].set_visible(False)
