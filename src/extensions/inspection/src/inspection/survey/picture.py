"""The plan as a picture: from above and from two sides, the surface, the photographs and the flights."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Any

import numpy as np

from flight_basics.errors import SurveyError
from inspection.survey.plan import Flight, SurveyPlan
from inspection.survey.surface.patches import Patches

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#7a5c00", "#56b4e9")
"""Of Okabe and Ito: they differ for the colour-blind, too."""
LEFT_OUT = "#b00020"
LOOK_M = 0.45
"""Length of the line that shows where a camera looks."""
EDGE_M = 0.5
WIDTH_IN, LEAST_HEIGHT_IN, LABELS_IN = 10.0, 5.0, 0.9
TALLEST = 1.3
"""Height of the picture over its width, at most."""
VIEWS = ((0, 1, "from above"), (0, 2, "from the side"), (1, 2, "from ahead"))


def draw_plan(path: Path, plan: SurveyPlan, patches: Patches) -> None:
    """Write the picture as PNG.

    Raises:
        SurveyError: the file cannot be written.
    """
    try:
        path.write_bytes(plan_png(plan, patches))
    except OSError as error:
        raise SurveyError(f"{path} cannot be written: {error.strerror}.") from None


def plan_png(plan: SurveyPlan, patches: Patches, dpi: int = 200) -> bytes:
    """Return the picture as PNG."""
    from matplotlib.figure import Figure

    low, high = patches.points_m.min(axis=0) - EDGE_M, patches.points_m.max(axis=0) + EDGE_M
    spans = high - low
    height_in = (WIDTH_IN - LABELS_IN) * (spans[1] + spans[2]) / (spans[0] + spans[1]) + 1.5 * LABELS_IN
    size_in = (WIDTH_IN, min(max(height_in, LEAST_HEIGHT_IN), TALLEST * WIDTH_IN))
    figure = Figure(figsize=size_in, layout="constrained")
    axes = figure.subplots(2, 2, width_ratios=(spans[0], spans[1]), height_ratios=(spans[1], spans[2]))
    for panel, (right, up, name) in zip((axes[0, 0], axes[1, 0], axes[1, 1]), VIEWS):
        _draw_surface(panel, patches, right, up)
        for number, flight in enumerate(plan.flights):
            _draw_flight(panel, plan.home_m, flight, right, up, COLOURS[number % len(COLOURS)])
        _draw_left_out(panel, plan, right, up)
        panel.plot(plan.home_m[right], plan.home_m[up], "*", color="black", ms=11, mec="white", zorder=6)
        panel.set(aspect="equal", xlim=(low[right], high[right]), ylim=(low[up], high[up]))
        panel.set(xlabel=f"{'xyz'[right]} [m]", ylabel=f"{'xyz'[up]} [m]")
        panel.set_title(name, fontsize=10, loc="left")
        panel.spines[["top", "right"]].set_visible(False)
    _tell(axes[0, 1], plan)
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=dpi, format="png")
    return drawn.getvalue()


def _draw_surface(panel: Any, patches: Patches, right: int, up: int) -> None:
    """Draw the area behind each cell: a wall seen along itself is dark."""
    side_m = patches.grid.side_m
    places = patches.points_m[:, (right, up)]
    low = np.floor(places.min(axis=0) / side_m) * side_m
    counts = np.ceil((places.max(axis=0) - low) / side_m).astype(int) + 1
    ends = low + counts * side_m
    spans = np.column_stack((low, ends))
    areas, *_ = np.histogram2d(
        places[:, 0], places[:, 1], bins=counts.tolist(), range=spans, weights=patches.areas_m2
    )
    extent = (low[0], ends[0], low[1], ends[1])
    dark = np.sqrt(areas.T / max(np.percentile(areas, 99.0), 1e-9))
    panel.imshow(dark, extent=extent, origin="lower", cmap="Greys", vmin=0.0, vmax=1.8, zorder=0)


def _draw_flight(panel: Any, home_m: tuple, flight: Flight, right: int, up: int, colour: str) -> None:
    way = [home_m]
    for each in flight.views:
        way += [*each.way_m, each.view.place_m]
    line = np.array([*way, home_m])
    panel.plot(line[:, right], line[:, up], color=colour, lw=0.5, alpha=0.45, zorder=2)
    places = np.array([each.view.place_m for each in flight.views])
    looks = np.array([_ahead(each.view.yaw_rad, each.view.tilt_rad) for each in flight.views])
    ends = places + LOOK_M * looks
    gaps = np.full(len(places), np.nan)
    x = np.column_stack((places[:, right], ends[:, right], gaps)).ravel()
    y = np.column_stack((places[:, up], ends[:, up], gaps)).ravel()
    panel.plot(x, y, color=colour, lw=1.0, zorder=3, solid_capstyle="butt")
    panel.plot(places[:, right], places[:, up], "o", color=colour, ms=2.2, mew=0.0, zorder=4)


def _draw_left_out(panel: Any, plan: SurveyPlan, right: int, up: int) -> None:
    for left in plan.leftovers:
        side_pt = 5.0 * math.sqrt(left.area_m2)
        panel.plot(
            left.place_m[right],
            left.place_m[up],
            "s",
            ms=side_pt,
            color=LEFT_OUT,
            alpha=0.35,
            mew=0.0,
            zorder=1,
        )


def _ahead(yaw_rad: float, tilt_rad: float) -> tuple[float, float, float]:
    level = math.cos(tilt_rad)
    return level * math.cos(yaw_rad), level * math.sin(yaw_rad), math.sin(tilt_rad)


def _tell(panel: Any, plan: SurveyPlan) -> None:
    """Write figures and legend where the fourth view would be."""
    from matplotlib.lines import Line2D

    share, reachable_m2 = plan.figures.get("share"), plan.figures.get("reachable_m2")
    lines = [f"{len(plan.views)} photographs"]
    if share is not None and reachable_m2 is not None:
        lines[0] += f" show {100.0 * share:.1f} %"
        lines.append(f"of {reachable_m2:,.0f} m² that can be reached of the {plan.reference}")
    lines.append(f"{plan.asked.resolution:g} mm per pixel, incidence to {plan.asked.incidence:g}°")
    handles = [
        Line2D([], [], color=COLOURS[n % len(COLOURS)], marker="o", ms=4, label=_label(n + 1, each))
        for n, each in enumerate(plan.flights)
    ]
    handles += [
        Line2D([], [], color="black", marker="*", ms=10, ls="", label="take-off"),
        Line2D([], [], color="0.6", marker="s", ms=7, ls="", label="surface"),
        Line2D([], [], color=LEFT_OUT, alpha=0.5, marker="s", ms=7, ls="", label="cannot be photographed"),
    ]
    panel.set_axis_off()
    panel.legend(
        handles=handles, title="\n".join(lines), loc="upper left", frameon=False, fontsize=8,
        title_fontsize=9, alignment="left", borderaxespad=0.0,
    )  # fmt: skip


def _label(number: int, flight: Flight) -> str:
    count = len(flight.views)
    return f"flight {number}: {count} photographs, {flight.time_s / 60.0:.1f} min, {flight.way_m:.0f} m"
