"""The plan as a picture: from above and from the side, the surface, the photographs and the flights."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from inspection_tools.errors import SurveyError
from inspection_tools.survey.plan import SurveyPlan
from inspection_tools.survey.surface.patches import Patches

COLOURS = ("#1b6ca8", "#c2571a", "#2e7d32", "#7b3fa0", "#8a6d00", "#ad1457")
LEFT_OUT = "#d32f2f"
ARROW_M = 0.5
VIEWS = ((0, 1), (0, 2), (1, 2))


def draw_plan(path: Path, plan: SurveyPlan, patches: Patches) -> None:
    """Write the picture as PNG.

    Raises:
        SurveyError: the file cannot be written.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 11.0), layout="constrained")
    spans = np.ptp(patches.points_m, axis=0) + 1.0
    axes = figure.subplots(
        2, 2, width_ratios=(spans[0], spans[1]), height_ratios=(spans[1], spans[2]), squeeze=False
    )
    panels = (axes[0, 0], axes[1, 0], axes[1, 1])
    for panel, (right, up) in zip(panels, VIEWS):
        panel.plot(
            patches.points_m[:, right], patches.points_m[:, up], ",", color="0.75", rasterized=True, zorder=0
        )
        for number, flight in enumerate(plan.flights):
            colour = COLOURS[number % len(COLOURS)]
            way = [plan.home_m]
            for each in flight.views:
                way += [*each.way_m, each.view.place_m]
            line = np.array([*way, plan.home_m])
            panel.plot(line[:, right], line[:, up], color=colour, lw=0.6, alpha=0.6)
            places = np.array([each.view.place_m for each in flight.views])
            looks = np.array([_ahead(each.view.yaw_rad, each.view.tilt_rad) for each in flight.views])
            panel.quiver(
                places[:, right], places[:, up], ARROW_M * looks[:, right], ARROW_M * looks[:, up],
                color=colour, angles="xy", scale_units="xy", scale=1.0, width=0.0015,
            )  # fmt: skip
        for left in plan.leftovers:
            size = 8.0 * math.sqrt(left.area_m2)
            panel.plot(left.place_m[right], left.place_m[up], "o", ms=size, mfc="none", mec=LEFT_OUT, mew=0.8)
        panel.plot(plan.home_m[right], plan.home_m[up], "*", color="black", ms=12)
        panel.set(aspect="equal", xlabel=f"{'xyz'[right]}, m", ylabel=f"{'xyz'[up]}, m")
        panel.spines[["top", "right"]].set_visible(False)
    _tell(axes[0, 1], plan)
    try:
        figure.savefig(path, dpi=150, format="png")
    except OSError as error:
        raise SurveyError(f"{path} cannot be written: {error.strerror}.") from None


def _ahead(yaw_rad: float, tilt_rad: float) -> tuple[float, float, float]:
    level = math.cos(tilt_rad)
    return level * math.cos(yaw_rad), level * math.sin(yaw_rad), math.sin(tilt_rad)


def _tell(panel: object, plan: SurveyPlan) -> None:
    """Write the figures where the fourth view would be."""
    f = plan.figures
    lines = [
        f"{len(plan.views)} photographs, {100 * f.get('share', math.nan):.1f} %",
        f"of {f.get('reachable_m2', math.nan):,.0f} m²",
        f"{plan.asked.resolution:g} mm per pixel,",
        f"incidence up to {plan.asked.incidence:g}°",
        "",
    ]
    lines += [
        f"flight {n}: {len(each.views)} photographs, {each.time_s / 60.0:.1f} min, {each.way_m:.0f} m"
        for n, each in enumerate(plan.flights, start=1)
    ]
    lines += [
        "",
        "star: take-off. Grey: surface.",
        "Red circles: cannot be photographed,",
        "larger for more area.",
    ]
    panel.set_axis_off()  # type: ignore[attr-defined]
    panel.text(0.0, 1.0, "\n".join(lines), va="top", fontsize=9)  # type: ignore[attr-defined]
