"""The picture of bench avoidance: what became of the flights of each algorithm, place and speed."""

from __future__ import annotations

import io
from typing import Mapping

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.avoidance_rows.rows import JUDGED

REACHED, GIVEN_UP, CONTACT = "#1f3b73", "#c9cfd8", "#dc2626"
Flown = Mapping[tuple[str, float, str], Mapping]
"""Metrics (`judging.metrics`) by place, speed in m/s and algorithm."""
_SMALL = 8
_LEGEND_IN = 4.6
"""So wide is the legend."""


def png(found: Flown) -> bytes:
    """Draw a panel for each algorithm, with a bar for each place and speed; return the PNG file's bytes."""
    places = list(dict.fromkeys((place, speed) for place, speed, _ in found))
    algorithms = sorted({name for *_, name in found}, key=lambda name: (name != JUDGED, name))
    width_in, height_in = max(1.2 + 1.9 * len(algorithms), _LEGEND_IN), 1.3 + 0.21 * len(places)
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    panels = figure.subplots(1, len(algorithms), sharey=True, squeeze=False)[0]
    for axes, algorithm in zip(panels, algorithms):
        for row, (place, speed) in enumerate(places):
            values = found.get((place, speed, algorithm))
            if values is not None:
                _bar(axes, row, values)
        axes.set_title(algorithm.replace("_", " "), fontsize=_SMALL + 1)
        axes.set_xlim(0.0, 100.0)
        axes.set_xlabel("flights [%]", fontsize=_SMALL)
        axes.tick_params(labelsize=_SMALL, length=0)
        axes.spines[["top", "right", "left"]].set_visible(False)
    labels = [f"{place.replace('_', ' ')}, {speed:g} m/s" for place, speed in places]
    panels[0].set_yticks(range(len(places)), labels)
    panels[0].set_ylim(len(places) - 0.4, -0.6)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    FigureCanvasAgg(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=110)
    return buffer.getvalue()


def _bar(axes: Axes, row: int, values: Mapping) -> None:
    reached, contact = 100.0 * values["reached"], 100.0 * values["contacts"] / values["flights"]
    parts = (
        (reached, REACHED, "goal reached"),
        (100.0 - reached - contact, GIVEN_UP, "stuck or given up"),
        (contact, CONTACT, "contact"),
    )
    start = 0.0
    for width, colour, label in parts:
        axes.barh(row, width, left=start, height=0.75, color=colour, label=label if row == 0 else None)
        start += width
