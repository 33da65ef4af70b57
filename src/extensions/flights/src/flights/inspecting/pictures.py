"""The picture of an inspection: the surface, what the photographs show of it, the path, the photographs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Sequence

import numpy as np

from flights.inspecting.coverage import Judged
from flights.results.picture_files import png
from flights.results.run_folder import RunFolder
from inspection.camera.photograph_pose import PhotographPose
from inspection.survey.surface_record import SurfaceRecord, read_surface_record

if TYPE_CHECKING:  # matplotlib takes half a second to import
    from matplotlib.axes import Axes

VIEWS = ((0, 1, "from above"), (0, 2, "from the side"), (1, 2, "from ahead"))
SHOWN, PATH, LOOK = "#1b7837", "#d1410c", "#2166ac"
LOOK_M, EDGE_M = 0.8, 0.5
WIDTH_IN, LABELS_IN = 9.0, 1.4


def caption(judged: Judged, flight_s: float) -> str:
    """Return the words for the picture. flight_s: time of all flights with photographs."""
    return (
        f"{len(judged.taken)} photographs show {judged.true_m2:.0f} m²\n"
        f"in {flight_s / 60.0:.1f} min of flight, without GNSS"
    )


def write_inspected(
    folder: RunFolder, record: Path, path_m: np.ndarray, taken: Sequence[PhotographPose], words: str
) -> None:
    """Write inspected.png.

    record: coverage_truth.npz. path_m: (n, 3) of the UAV. taken: the photographs, by their true poses.
    words: for the empty quarter.

    Raises:
        SurveyError: the record cannot be read. ResultsError: the picture cannot be written.
    """
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    surface = read_surface_record(record)
    low, high = surface.points_m.min(axis=0) - EDGE_M, surface.points_m.max(axis=0) + EDGE_M
    spans = high - low
    height_in = (WIDTH_IN - LABELS_IN) * (spans[1] + spans[2]) / (spans[0] + spans[1]) + LABELS_IN
    figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    axes = figure.subplots(2, 2, width_ratios=(spans[0], spans[1]), height_ratios=(spans[1], spans[2]))
    for panel, (right, up, name) in zip((axes[0, 0], axes[1, 0], axes[1, 1]), VIEWS):
        _draw_surface(panel, surface, right, up)
        panel.plot(path_m[:, right], path_m[:, up], color=PATH, lw=0.9, zorder=3)
        for each in taken:
            line = np.array((each.place_m, each.place_m + LOOK_M * each.axes[:, 2]))
            panel.plot(line[:, right], line[:, up], color=LOOK, lw=1.2, zorder=4)
            panel.plot(*line[0, [right, up]], "o", color=LOOK, ms=3.0, mew=0.0, zorder=4)
        panel.set(aspect="equal", xlim=(low[right], high[right]), ylim=(low[up], high[up]))
        panel.set(xlabel=f"{'xyz'[right]} [m]", ylabel=f"{'xyz'[up]} [m]")
        panel.set_title(name, fontsize=9, loc="left")
        panel.spines[["top", "right"]].set_visible(False)
    handles = [
        Line2D([], [], color=SHOWN, marker="s", ms=7, ls="", label="shown by a photograph"),
        Line2D([], [], color="0.75", marker="s", ms=7, ls="", label="not shown"),
        Line2D([], [], color=LOOK, marker="o", ms=4, label="photograph"),
        Line2D([], [], color=PATH, label="path of the UAV"),
    ]
    axes[0, 1].set_axis_off()
    axes[0, 1].legend(
        handles=handles, title=words, loc="upper left", frameon=False, fontsize=8, title_fontsize=9,
        alignment="left", borderaxespad=0.0,
    )  # fmt: skip
    folder.write_files({"inspected.png": png(figure)})


def _draw_surface(panel: Axes, surface: SurfaceRecord, right: int, up: int) -> None:
    """Draw the area behind each cell: a wall that is seen along itself is dark, what is shown is green."""
    from matplotlib.colors import to_rgb

    places = surface.points_m[:, (right, up)]
    side_m = 1.5 * surface.side_m
    low = np.floor(places.min(axis=0) / side_m) * side_m
    counts = np.ceil((places.max(axis=0) - low) / side_m).astype(int) + 1
    ends = low + counts * side_m
    spans = np.column_stack((low, ends))
    x, y = places.T
    areas = [
        np.histogram2d(x, y, bins=counts.tolist(), range=spans, weights=surface.areas_m2 * chosen)[0].T
        for chosen in (np.ones(len(places)), surface.shown)
    ]
    dark = np.sqrt(areas[0] / max(float(np.percentile(areas[0], 99.0)), 1e-9)).clip(0.0, 1.0)[..., None]
    share = np.minimum(2.0 * areas[1] / np.maximum(areas[0], 1e-9), 1.0)[..., None]  # of both sides
    colour = share * np.array(to_rgb(SHOWN)) + (1.0 - share) * np.array((0.6, 0.6, 0.6))
    extent = (float(low[0]), float(ends[0]), float(low[1]), float(ends[1]))
    picture = 1.0 - (0.4 + 0.5 * dark) * (dark > 0.0) * (1.0 - colour)
    panel.imshow(picture, extent=extent, origin="lower", zorder=0)
