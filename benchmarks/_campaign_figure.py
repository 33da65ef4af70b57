"""The campaign's picture: collisions per kilometre, what became of the flights, time, and one forest."""

from __future__ import annotations

import io
from typing import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from benchmarks._campaign import GOAL_X_M, SPEEDS_M_S, Flown, figures
from master_thesis.campaign.places import HALF_WIDTH_M

COLOURS = {
    "original": "#c2410c",
    "improved": "#1f3b73",
    "improved_velocity_aware": "#0f8a5f",
    "improved_levelling": "#9a7bd0",
}
MARKERS = {"original": "s", "improved": "o", "improved_velocity_aware": "^", "improved_levelling": "v"}
OFFSET_M_S = {
    "original": -0.15,
    "improved": -0.05,
    "improved_velocity_aware": 0.05,
    "improved_levelling": 0.15,
}
"""Beside each other, so that the intervals can be told apart."""
_SMALL = {"fontsize": 8}


def png(flown: dict[str, list[Flown]]) -> bytes:
    """Draw the flights (by algorithm and variant, in mixed speeds over the same forests); return the PNG."""
    figure = Figure(figsize=(7.2, 5.4), layout="constrained")
    grid = figure.add_gridspec(2, 3, height_ratios=(1.0, 1.2))
    rates, arrivals, times = (figure.add_subplot(grid[0, column]) for column in range(3))
    for axes, measure, label in (
        (rates, _rate, "collisions per km"),
        (arrivals, _arrived, "reached the goal [%]"),
        (times, _time, "time / straight at full speed"),
    ):
        _draw_by_speed(axes, flown, measure, label)
    arrivals.set_ylim(-3.0, 103.0)
    rates.legend(fontsize=7, frameon=False)
    _draw_forest(figure.add_subplot(grid[1, :]), flown)
    return _bytes(figure)


Measure = Callable[[list], "tuple[float, float, float] | None"]


def _rate(flights: list[Flown]) -> tuple[float, float, float]:
    values = figures(flights)
    return (values["collisions_per_km"], *values["collisions_per_km_95"])


def _arrived(flights: list[Flown]) -> tuple[float, float, float]:
    share = 100.0 * figures(flights)["reached"]
    return share, share, share


def _time(flights: list[Flown]) -> tuple[float, float, float] | None:
    longer = [f.time_s * f.trial.speed_m_s / GOAL_X_M for f in flights if f.end == "goal"]
    return tuple(np.percentile(longer, (50, 25, 75))) if longer else None


def _draw_by_speed(axes: Axes, flown: dict[str, list[Flown]], measure: Measure, label: str) -> None:
    """Draw a value with its interval over the speed, for each algorithm."""
    for algorithm, flights in flown.items():
        points = []
        for speed in sorted(SPEEDS_M_S):
            chosen = [flight for flight in flights if flight.trial.speed_m_s == speed]
            value = measure(chosen) if chosen else None
            if value is not None:
                points.append((speed + OFFSET_M_S[algorithm], *value))
        if points:
            x, middle, low, high = np.array(points).T
            style = {
                "color": COLOURS[algorithm],
                "marker": MARKERS[algorithm],
                "label": algorithm.replace("_", " ", 1).replace("_", "-"),
            }
            axes.errorbar(x, middle, (middle - low, high - middle), ms=4, lw=1, capsize=2, **style)
    axes.set_xlabel("reference speed [m/s]", **_SMALL)
    axes.set_ylabel(label, **_SMALL)
    axes.set_xticks(sorted(SPEEDS_M_S))
    axes.tick_params(labelsize=7)
    axes.grid(alpha=0.3, linewidth=0.5)


def _draw_forest(axes: Axes, flown: dict[str, list[Flown]]) -> None:
    """Draw the forest that tells the two apart, or the first, with both algorithms' paths."""
    pairs = list(zip(flown["original"], flown["improved"]))
    telling = [pair for pair in pairs if pair[0].end != "goal" and pair[1].end == "goal"]
    original, improved = (telling or pairs)[0]
    for x, y, radius in original.trial.forest:
        axes.add_patch(Circle((x, y), radius, facecolor="#5b6066", edgecolor="black", linewidth=0.3))
    for flight in (original, improved):
        name = flight.trial.algorithm
        label = f"{name}: {flight.end} after {flight.time_s:.1f} s"
        axes.plot(*flight.path_xy.T, color=COLOURS[name], lw=1.6, label=label)
        if flight.end != "goal":
            axes.plot(*flight.path_xy[-1], "x", color=COLOURS[name], ms=8, mew=2)
    axes.plot(0.0, 0.0, "o", ms=6, mfc="white", mec="black")
    axes.plot(GOAL_X_M, 0.0, "*", ms=11, mfc="white", mec="black")
    axes.set_aspect("equal")
    axes.set_xlim(-2.0, GOAL_X_M + 2.0)
    axes.set_ylim(-HALF_WIDTH_M * 0.6, HALF_WIDTH_M * 0.6)
    axes.set_xlabel("x [m]", **_SMALL)
    axes.set_ylabel("y [m]", **_SMALL)
    axes.set_title(f"forest {original.trial.number} at {original.trial.speed_m_s:g} m/s", fontsize=8)
    axes.tick_params(labelsize=7)
    axes.legend(fontsize=7, loc="upper right", framealpha=0.9)


def _bytes(figure: Figure) -> bytes:
    stream = io.BytesIO()
    FigureCanvasAgg(figure)
    figure.savefig(stream, format="png", dpi=200)
    return stream.getvalue()
