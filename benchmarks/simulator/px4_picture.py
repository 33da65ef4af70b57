"""The picture of the step responses: ours over those of real PX4."""

from __future__ import annotations

import io
from typing import Any, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.simulator.step_response import COLUMNS, MANOEUVRES, TAKEOFF, Manoeuvre, quantity_of

OURS, THEIRS = "#1f3b73", "#ea580c"
PANELS = (
    ("velocity north [m/s]", ("velocity_x_0_to_1", "velocity_x_0_to_2", "velocity_x_0_to_4"), 8.0),
    ("velocity north, braking [m/s]", ("velocity_x_1_to_0", "velocity_x_2_to_0", "velocity_x_4_to_0"), 8.0),
    ("position north [m]", ("position_x_+5", "position_x_-5"), 8.0),
    ("tilt of those steps [deg]", ("velocity_x_0_to_4", "velocity_x_0_to_2", "position_x_+5"), 4.0),
    ("yaw [deg]", ("yaw_+90_deg", "yaw_-90_deg"), 4.0),
    ("yaw rate [rad/s]", ("yaw_rate_0_to_0.5",), 4.0),
    ("height of steps and take-off [m]", ("position_down_-1", "position_down_+1", TAKEOFF), 12.0),
    ("velocity down [m/s]", ("velocity_down_0_to_-1", "velocity_down_0_to_1"), 3.0),
)
"""Title, manoeuvres and seconds of each panel."""
_BY_NAME = {manoeuvre.name: manoeuvre for manoeuvre in MANOEUVRES}
_SMALL = 8


def png(flown: Mapping[str, np.ndarray], reference: Mapping[str, np.ndarray]) -> bytes:
    """Draw the series by manoeuvre, rows of COLUMNS; return the PNG file's bytes."""
    figure = Figure(figsize=(11.0, 5.4), layout="constrained")
    for axes, (title, names, seconds) in zip(figure.subplots(2, 4).flat, PANELS):
        for name in names:
            for series, colour, width, label in ((reference, THEIRS, 2.6, "PX4"), (flown, OURS, 1.0, "ours")):
                _draw(axes, title, name, series[name], seconds, color=colour, linewidth=width, label=label)
        axes.set_title(title, fontsize=_SMALL + 1)
        axes.set_xlim(-0.2, seconds)
        axes.tick_params(labelsize=_SMALL)
        axes.grid(alpha=0.3)
        axes.set_xlabel("time since the step [s]", fontsize=_SMALL)
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(handles[:2], labels[:2], fontsize=_SMALL, frameon=False)
    FigureCanvasAgg(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=110)
    return buffer.getvalue()


def _draw(axes: Axes, title: str, name: str, rows: np.ndarray, seconds: float, **style: Any) -> None:
    """Draw one manoeuvre into a panel."""
    manoeuvre = _BY_NAME.get(name)
    compared_s = seconds if manoeuvre is None else min(seconds, manoeuvre.compared_s)
    rows = rows[rows[:, 0] <= compared_s]
    axes.plot(rows[:, 0], _values(title, manoeuvre, rows), **style)


def _values(title: str, manoeuvre: Manoeuvre | None, rows: np.ndarray) -> np.ndarray:
    if title.startswith("tilt"):
        return rows[:, COLUMNS.index("tilt_deg")]
    if title.startswith("height"):
        stood_m = rows[0, COLUMNS.index("down_m")] if manoeuvre is None else 0.0
        return stood_m - rows[:, COLUMNS.index("down_m")]
    assert manoeuvre is not None
    return quantity_of(manoeuvre, rows)
