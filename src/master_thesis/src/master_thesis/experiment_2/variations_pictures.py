"""All paths of a scenario of Experiment 2 from above, one panel for each algorithm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flights.results.palette import ALGORITHMS
from flights.results.pictures_from_above import draw_obstacles, frame, up
from flights.results.solids import solid_mark
from flights.worlds.placements import Obstacle


@dataclass(frozen=True)
class Paths:
    """The content of a panel: the placement before its variation, paths (n, 2), places of contacts (2,)."""

    obstacles: tuple[Obstacle, ...]
    paths_xy: tuple[np.ndarray, ...]
    touches_xy: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, obstacles: Sequence[Obstacle], flights: Sequence) -> Paths:
        """Take the flights of one scenario and algorithm."""
        touches = tuple(flight.touch_xy for flight in flights if flight.touch_xy is not None)
        return cls(tuple(obstacles), tuple(flight.path_xy for flight in flights), touches)


def paths_figure(panels: dict[tuple[str, str], Paths]) -> Figure:
    """Draw one row for each algorithm and one column for each scenario."""
    scenarios = list(dict.fromkeys(scenario for scenario, _ in panels))
    algorithms = list(dict.fromkeys(algorithm for _, algorithm in panels))
    everything = np.concatenate([path for shown in panels.values() for path in shown.paths_xy])
    low, high = np.minimum(everything.min(axis=0) - 0.2, -1.0), np.maximum(everything.max(axis=0) + 0.2, 1.0)
    height, width = high - low
    panel_in = min(6.6 / len(scenarios), 2.6)
    figure = Figure(figsize=(7.2, panel_in * height / width * len(algorithms) + 1.1))
    grid = figure.subplots(len(algorithms), len(scenarios), sharex=True, sharey=True, squeeze=False)
    for (scenario, algorithm), shown in panels.items():
        axes = grid[algorithms.index(algorithm), scenarios.index(scenario)]
        _panel(axes, shown, ALGORITHMS[algorithm])
        frame(axes, low[0], high[0], low[1], high[1])
        title = f"{scenario.replace('_', ' ')}: {algorithm}"
        axes.set_title(f"{title}\n{len(shown.touches_xy)} of {len(shown.paths_xy)} touched", fontsize=8)
        axes.label_outer()
    handles = [
        solid_mark("obstacle, before its variation"),
        *(Line2D([], [], color=ALGORITHMS[name], lw=1.2, label=f"{name}: path") for name in algorithms),
        Line2D(
            [], [], marker="X", ls="", mfc="white", mec="black", ms=6, label="first contact, UAV's middle"
        ),
    ]
    figure.legend(handles=handles, loc="lower center", ncol=len(handles), fontsize=7, frameon=False)
    figure.tight_layout(rect=(0.0, 0.04, 1.0, 1.0))
    return figure


def _panel(axes: Axes, shown: Paths, colour: str) -> None:
    draw_obstacles(axes, shown.obstacles)
    for path in shown.paths_xy:
        axes.plot(*up(path).T, color=colour, lw=0.8, alpha=0.6, zorder=5)
        axes.plot(*up(path[-1]), ".", ms=4, color=colour, zorder=6)
    for place in shown.touches_xy:
        axes.plot(*up(place), "X", ms=6, mfc="white", mec="black", mew=0.7, zorder=7)
    axes.plot(0, 0, "o", ms=4, mfc="white", mec="black", zorder=8)
