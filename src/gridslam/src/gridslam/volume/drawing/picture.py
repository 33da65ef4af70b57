"""A picture of a map of voxels: cut open from above and from the side, coloured by height."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Sequence

import numpy as np

from gridslam.volume.drawing.centres import occupied_centres
from gridslam.volume.voxel_map import VoxelMap

if TYPE_CHECKING:  # matplotlib takes half a second to import
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase
    from matplotlib.image import AxesImage

AXES = "xyz"
ABOVE, SIDE, FRONT = (0, 1, 2), (0, 2, 1), (1, 2, 0)
VIEWS = (ABOVE, SIDE, FRONT)
"""Axis to the right, axis up, axis of sight."""
HEIGHTS = "viridis"
HEIGHT_LABEL = "height z [m]"
SHADOW_M, DARKEST = 0.5, 0.75
"""A pixel this far behind its neighbour has the darkest shadow, 0..1."""
PIXELS_MAX = 3000
"""Of a view's longer side."""


class Pixels(NamedTuple):
    """An image (h, w), row 0 lowest, NaN where nothing is, and its extent (left, right, low, high), m."""

    values: np.ndarray
    extent_m: tuple[float, float, float, float]


def volume_figure(voxels: VoxelMap, title: str) -> Figure:
    """Return a picture of a map's occupied voxels, cut open through its middle."""
    from matplotlib.figure import Figure

    centres, resolution_m = occupied_centres(voxels), voxels.parameters.resolution_m
    figure = Figure(figsize=(8.0, 6.4), layout="constrained")
    figure.suptitle(title, fontsize=10)
    if not len(centres):
        return figure
    panels, free = projections(figure, centres)
    free.set_axis_off()
    middle_m = 0.5 * (centres.min(axis=0) + centres.max(axis=0))
    for panel, view in zip(panels, VIEWS):
        shown = draw_cut_open(panel, centres, resolution_m, view, middle_m[view[2]])
    figure.colorbar(shown, ax=[*panels, free], label=HEIGHT_LABEL, location="bottom", aspect=50)
    explain(figure, _voxel_keys(resolution_m))
    return figure


def explain(figure: Figure, keys: Sequence[Artist]) -> None:
    """Let a legend below the picture explain what is drawn, after what it explains already."""
    shown: list[Artist] = []
    for legend in list(figure.legends):
        shown += [each for each in legend.legend_handles if each is not None]
        legend.remove()
    figure.legend(handles=[*shown, *keys], loc="outside lower center", ncols=3, fontsize=8, frameon=False)


def _voxel_keys(resolution_m: float) -> list[Artist]:
    from matplotlib import colormaps
    from matplotlib.colors import to_hex
    from matplotlib.patches import Patch

    colours = {
        f"occupied voxel of {resolution_m:g} m": to_hex(colormaps[HEIGHTS](0.5)),
        "edge of what is nearer": "black",
        "free, unknown, or cut away": "white",
    }
    return [Patch(facecolor=colour, edgecolor="grey", label=words) for words, colour in colours.items()]


def projections(figure: FigureBase, centres: np.ndarray) -> tuple[list[Axes], Axes]:
    """Return axes for `VIEWS` at about one scale, the side below the plan and the front right of it.

    Above the front there is room for something else: the second axes.
    """
    x, y, z = np.maximum(np.ptp(centres, axis=0), 1.0)
    widths, heights = (x, max(y, 0.6 * x)), (max(y, 0.6 * x), max(z, 0.45 * x))
    above, free, side, front = figure.subplots(2, 2, width_ratios=widths, height_ratios=heights).ravel()
    return [above, side, front], free


def draw_cut_open(
    panel: Axes, centres: np.ndarray, pixel_m: float, view: tuple[int, int, int], cut_m: float
) -> AxesImage:
    """Draw the voxels behind a plane across the axis of sight, coloured by height. The nearest one is seen.

    centres: (n, 3) of all occupied voxels, m. The view from above looks down, the others look along their
    axis of sight.
    """
    right, up, across = view
    behind = centres[centres[:, across] <= cut_m] if across == 2 else centres[centres[:, across] >= cut_m]
    nearest_last = np.argsort(behind[:, across] * (1.0 if across == 2 else -1.0), kind="stable")
    behind = behind[nearest_last]
    image, depth = (
        pixels(behind[:, (right, up)], values, centres[:, (right, up)], pixel_m)
        for values in (behind[:, 2], behind[:, across] * (-1.0 if across == 2 else 1.0))
    )
    shown = show_pixels(panel, image, view, HEIGHTS, *np.percentile(centres[:, 2], (0.5, 99.5)))
    shadow = np.zeros((*depth.values.shape, 4))
    shadow[..., 3] = shadows(depth.values)
    panel.imshow(shadow, origin="lower", extent=image.extent_m, interpolation="nearest")
    seen = "from above" if across == 2 else f"along {AXES[across]}"
    panel.set_title(f"{seen}, cut at {AXES[across]} = {cut_m:.2f} m", fontsize=9)
    return shown


def pixels(places: np.ndarray, values: np.ndarray, shown: np.ndarray, pixel_m: float) -> Pixels:
    """Return values (n,) at places (n, 2) as an image; a later one covers an earlier one.

    shown: (m, 2) places around which the image ends. A pixel is as wide as a voxel, or wider in a large map.
    """
    low, high = shown.min(axis=0), shown.max(axis=0)
    pixel_m *= max(1, int(np.ceil((high - low).max() / pixel_m / PIXELS_MAX)))
    size = np.rint((high - low) / pixel_m).astype(int) + 1
    at = np.clip(np.rint((places - low) / pixel_m).astype(int), 0, size - 1)
    image = np.full(size[::-1], np.nan)
    image[at[:, 1], at[:, 0]] = values
    first, last = low - 0.5 * pixel_m, low + (size - 0.5) * pixel_m
    return Pixels(image, (first[0], last[0], first[1], last[1]))


def shadows(depth_m: np.ndarray) -> np.ndarray:
    """Return how dark (h, w), 0..1, each pixel is that lies behind its neighbours, NaN: nothing there.

    This lets edges stand out where the colour is the same.
    """
    padded = np.pad(depth_m, 1, constant_values=np.nan)
    neighbours = (padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:])
    steps = [np.nan_to_num(np.clip(depth_m - each, 0.0, SHADOW_M)) for each in neighbours]
    return np.where(np.isnan(depth_m), 0.0, DARKEST * np.max(steps, axis=0) / SHADOW_M)


def show_pixels(
    panel: Axes, image: Pixels, view: tuple[int, int, int], colours: str, lowest: float, highest: float
) -> AxesImage:
    """Draw an image into a view. colours: name of a colour map; lowest and highest have its ends."""
    shown = panel.imshow(
        image.values,
        origin="lower",
        extent=image.extent_m,
        interpolation="nearest",
        cmap=colours,
        vmin=lowest,
        vmax=highest,
    )
    panel.set(xlabel=f"{AXES[view[0]]} [m]", ylabel=f"{AXES[view[1]]} [m]", aspect="equal")
    return shown
