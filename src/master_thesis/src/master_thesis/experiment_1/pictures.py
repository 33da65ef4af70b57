"""The pictures of Experiment 1 on the page: computation times, and the worlds with the paths flown."""

from __future__ import annotations

from typing import Mapping

import numpy as np
from matplotlib.figure import Figure

from flights.results import palette
from flights.results.solids import draw_solids
from flights.worlds.floor_plan import outlines_of_file
from flights.worlds.scenario import FLIGHT_HEIGHT_M
from master_thesis.experiment_1.scenario_flight import WORLDS
from master_thesis.report import thesis

LEAST_MS = 0.005
"""The lower end of the picture's logarithmic scale. The thesis's "~ 0" is drawn there."""
_LINES = {"original": (2.4, (0, (4, 1.5))), "improved": (1.5, "-"), "dynamic": (1.5, (0, (1, 1)))}
"""Width and dashes of each algorithm's path."""


def times_figure(times: Mapping[tuple, tuple[float, float]]) -> Figure:
    """Draw computation times, the thesis's and ours (mean, spread in ms by scenario and algorithm)."""
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    axes = figure.add_subplot()
    names, algorithms = (list(dict.fromkeys(values)) for values in zip(*times))
    places = np.arange(len(names))
    columns = [
        (whose, algorithm)
        for algorithm in algorithms
        for whose in (("thesis", "ours") if algorithm in thesis.TABLE_8_1_MS else ("ours",))
    ]
    width = 0.8 / len(columns)
    for column, (whose, algorithm) in enumerate(columns):
        theirs = thesis.TABLE_8_1_MS.get(algorithm, {})
        means = [theirs[n] or LEAST_MS if whose == "thesis" else times[n, algorithm][0] for n in names]
        colour = palette.ALGORITHMS[algorithm]
        bars = axes.bar(
            places + (column - (len(columns) - 1) / 2) * width,
            means,
            width,
            yerr=None if whose == "thesis" else [times[n, algorithm][1] for n in names],
            capsize=2,
            facecolor="white" if whose == "thesis" else colour,
            edgecolor=colour,
            lw=1.2,
            label=f"{algorithm}, {whose}",
        )
        labels = [f"{mean:.2g}" if mean > LEAST_MS else "~ 0" for mean in means]
        axes.bar_label(bars, labels, fontsize=6.5, padding=2)
    axes.set_yscale("log")
    axes.set_ylim(LEAST_MS, 100.0)
    axes.set_xticks(places, names)
    axes.set_ylabel("mean computation time [ms]", fontsize=8)
    axes.tick_params(labelsize=8)
    axes.legend(fontsize=7, ncol=len(columns), frameon=False, loc="upper center")
    return figure


def view_figure(name: str, flown: Mapping[str, dict]) -> Figure:
    """Draw a world from above with the paths of a flight by each algorithm."""
    paths = {algorithm: np.array(flight["path_xy"]) for algorithm, flight in flown.items()}
    points = np.concatenate(list(paths.values()))
    margin = np.array((2.0, 4.0))
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    width, height = high - low
    figure = Figure(figsize=(7.2, 6.6 * height / width + 0.75), layout="constrained")
    axes = figure.add_subplot()
    shapes = outlines_of_file(WORLDS / f"{name}.world")
    draw_solids(axes, (o.outline_xy for o in shapes if o.blocks(FLIGHT_HEIGHT_M)))
    for algorithm, (line, dashes) in _LINES.items():
        colour = palette.ALGORITHMS[algorithm]
        axes.plot(*paths[algorithm].T, color=colour, lw=line, ls=dashes, label=algorithm)
        places = np.array(flown[algorithm]["emergencies_xy"]).reshape(-1, 2)
        if len(places):
            axes.plot(*places.T, "x", ms=5, mew=1.2, color=colour, label=f"{algorithm}: emergency", zorder=6)
    axes.plot(*points[0], "o", ms=5, mfc="white", mec="black", zorder=7)
    axes.plot(*paths["improved"][-1], "*", ms=10, mfc="white", mec="black", zorder=7)
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_xlabel("x [m]", fontsize=8)
    axes.set_ylabel("y [m]", fontsize=8)
    axes.tick_params(labelsize=7)
    figure.legend(
        *axes.get_legend_handles_labels(), fontsize=7, frameon=False, ncol=3, loc="outside lower center"
    )
    return figure
