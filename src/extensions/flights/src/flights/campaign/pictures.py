"""The pictures of a campaign: legible in grey, one colour and marker for each algorithm and each lidar."""

from __future__ import annotations

import math
from typing import Any, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from flights.campaign.campaign import Campaign
from flights.campaign.statistics import metrics
from flights.results import palette
from flights.results.picture_files import png

COLOURS = {
    **palette.ALGORITHMS,
    "none": "#8a8f98",
    "collision_prevention": "#2f68bf",
    "vfh_plus": "#6f3289",
    "vfh_plus_3d": "#b5651d",
}
MARKERS = {
    "improved": "o",
    "dynamic": "P",
    "original": "s",
    "none": "x",
    "collision_prevention": "^",
    "vfh_plus": "D",
    "vfh_plus_3d": "v",
}
NAMES = {
    "none": "no avoidance",
    "collision_prevention": "collision prevention (ours)",
    "vfh_plus": "VFH+ (ours)",
    "vfh_plus_3d": "3DVFH+ (ours)",
}
"""What algorithms are called in a legend: the baselines are not their authors' own code."""
LABELS = {
    "algorithm": "algorithm",
    "density_per_m2": "trees per m²",
    "width_m": "width of the hallway [m]",
    "speed_m_s": "reference speed [m/s]",
    "height_m": "height [m]",
    "distance_m": "distance [m]",
    "lidar_noise_factor": "lidar noise / data sheet",
    "scan_loss": "lost scans [share]",
    "odometry_delay_s": "odometry is late by [s]",
    "wind_m_s": "wind [m/s]",
    "collision_rate": "collisions [share of flights]",
    "reached_rate": "reached the goal [share]",
    "time_over_straight_mean": "time to goal / straight",
    "ate_rmse_m_mean": "path error, ATE [m]",
    "map_error_p95_m_mean": "map error, 95 % [m]",
    "lidar_range_m": "range [m]",
    "lidar_rate_hz": "rate [Hz]",
    "lidar_weight_kg": "weight [kg]",
    "lidar_power_w": "power [W]",
    "beam_width_m": "width of the beams [m]",
    "beam_spacing_m": "spacing of the beams [m]",
}
_SMALL: dict[str, Any] = {"fontsize": 8}
_PANEL_IN = (2.5, 2.1)
_FLIGHT_MEASURES = ("collision_rate", "reached_rate", "time_over_straight_mean")
_MAP_MEASURES = ("ate_rmse_m_mean", "map_error_p95_m_mean")
_LIDAR_DATA = ("lidar_range_m", "lidar_rate_hz", "lidar_weight_kg", "lidar_power_w")
_LABEL_MAX = 24
"""Letters of a label in a legend of more than two columns."""
_SPREAD = 0.03
"""Part of the axis by which curves stand beside each other, so that their intervals can be told apart."""
_GREYS = ("#1b1f24", "#5b6066", "#9aa0a6", "#c2410c", "#1f3b73", "#35a860")
_DASHES = ("-", "--", ":", "-.", (0, (3, 1, 1, 1, 1, 1)), (0, (5, 1)))
_MARKS = ("o", "s", "^", "D", "v", "P")


def pictures(campaign: Campaign, trials: pd.DataFrame) -> dict[str, bytes]:
    """Return the pictures that a campaign's axes call for, as PNG by file name; trials: its table."""
    flown = trials[trials["error"].isna()]
    if not len(flown):
        return {}
    drawn = {}
    if campaign.kind == "flight":
        numbers = [name for name in campaign.varied if _is_number(flown, name)]
        plain = [name for name in numbers if not name.startswith("cepa.")]
        if plain:
            drawn["flights.png"] = _over_axes(campaign, flown, plain, _FLIGHT_MEASURES)
        tuned = [name for name in campaign.varied if name.startswith("cepa.")]
        if tuned and len(campaign.blocks) == 1:  # over all that varies besides, which blocks do not share
            drawn["trade_off.png"] = _trade_off(campaign, flown, tuned)
    else:
        drawn["slam_range.png"] = _over_lidars(campaign, flown, ("lidar_range_m",))
        drawn["slam_lidars.png"] = _over_lidars(campaign, flown, _LIDAR_DATA)
    return drawn


def _is_number(trials: pd.DataFrame, name: str) -> bool:
    return pd.api.types.is_numeric_dtype(trials[name]) and not pd.api.types.is_bool_dtype(trials[name])


def curve_names(campaign: Campaign) -> list[str]:
    """Return the axes of which each value has its own curve: the algorithm, and whatever is not a number."""
    found = [name for name in campaign.varied if isinstance(campaign.values(name)[0], (str, bool))]
    two = [
        name
        for name in campaign.names
        if name.startswith("cepa.") and len(campaign.values(name)) == 2 and name not in found
    ]
    return found + two or ["algorithm"]


def _over_axes(
    campaign: Campaign, trials: pd.DataFrame, axes_names: Sequence[str], measures: Sequence[str]
) -> bytes:
    """Draw every measure (a row each) over every axis (a column each), a curve for each algorithm."""
    figure, panels = _panels(len(measures), len(axes_names))
    curves = curve_names(campaign)
    groups = list(trials.groupby(curves, sort=False))
    for column, name in enumerate(axes_names):
        for number, (values, group) in enumerate(groups):
            style = _style(curves, values, number)
            for row, measure in enumerate(measures):
                _draw_curve(panels[row, column], campaign, group, name, measure, style, number, len(groups))
        for row, measure in enumerate(measures):
            _finish(panels[row, column], name, measure, row == len(measures) - 1, column == 0)
            panels[row, column].set_xticks(np.sort(trials[name].dropna().unique()))
    _legend(figure, panels[0, 0])
    return png(figure)


def _draw_curve(
    axes: Axes,
    campaign: Campaign,
    group: pd.DataFrame,
    name: str,
    measure: str,
    style: dict,
    number: int,
    of: int,
) -> None:
    values = np.sort(group[name].dropna().unique()).astype(float)
    if not len(values):  # a world that does not have the axis
        return
    span = float(np.ptp(values)) or 1.0
    points = []
    for value in values:
        found = metrics(campaign, group[group[name] == value])
        points.append((value + span * _SPREAD * (number - (of - 1) / 2), *_measured(found, measure)))
    _errorbar(axes, points, style)


def _measured(found: dict[str, float], measure: str) -> tuple[float, float, float]:
    return found[measure], found[f"{measure}_low"], found[f"{measure}_high"]


def _errorbar(axes: Axes, points: Sequence[tuple], style: dict) -> None:
    x, middle, low, high = np.array(points).T
    shown = np.isfinite(middle)
    x, middle, low, high = x[shown], middle[shown], low[shown], high[shown]
    reach = np.maximum((middle - low, high - middle), 0.0)
    axes.errorbar(x, middle, reach, ms=4, lw=1.1, elinewidth=0.8, capsize=2, **style)


def _trade_off(campaign: Campaign, trials: pd.DataFrame, names: Sequence[str]) -> bytes:
    """Draw safety against speed, a panel for each parameter, over everything else that varies."""
    columns = 2 if len(names) == 4 else min(3, len(names))
    figure, panels = _panels(math.ceil(len(names) / columns), columns)
    others = ["speed_m_s"] if "speed_m_s" in campaign.varied else []
    for axes, name in zip(panels.flat, names):
        groups = trials.groupby(others[0]) if others else [("", trials)]
        for number, (other, group) in enumerate(groups):
            label = f"{other:g} m/s" if others else "all flights"
            style = {"color": _GREYS[number % 6], "marker": _MARKS[number % 6], "label": label}
            _draw_trade_off(axes, campaign, group, name, {**style, "linestyle": _DASHES[number % 6]})
        axes.set_title(name.split(".", 1)[1], fontsize=8)
        axes.set_xlabel(LABELS["time_over_straight_mean"], **_SMALL)
        axes.set_ylabel(LABELS["collision_rate"], **_SMALL)
    for axes in panels.flat[len(names) :]:
        axes.set_visible(False)
    _legend(figure, panels.flat[0])
    return png(figure)


def _draw_trade_off(axes: Axes, campaign: Campaign, group: pd.DataFrame, name: str, style: dict) -> None:
    found = [(value, metrics(campaign, part)) for value, part in group.groupby(name)]
    x, y = (
        np.array([_measured(f, key) for _, f in found])
        for key in ("time_over_straight_mean", "collision_rate")
    )
    reach_x = np.maximum((x[:, 0] - x[:, 1], x[:, 2] - x[:, 0]), 0.0)
    reach_y = np.maximum((y[:, 0] - y[:, 1], y[:, 2] - y[:, 0]), 0.0)
    axes.errorbar(x[:, 0], y[:, 0], reach_y, reach_x, ms=4, lw=1.1, elinewidth=0.5, capsize=0, **style)
    for (value, _), a, b in zip(found, x[:, 0], y[:, 0]):
        text = f"{value:g}" if not isinstance(value, (bool, np.bool_)) else "on" if value else "off"
        axes.annotate(text, (a, b), (4, 4), textcoords="offset points", fontsize=7, color=style["color"])
    _grid(axes)


def _over_lidars(campaign: Campaign, trials: pd.DataFrame, names: Sequence[str]) -> bytes:
    """Draw the errors of maps over data of the lidars, in each world."""
    switches = [name for name in curve_names(campaign) if name.startswith("slam.")]
    told = {"world", "lidar", "lidar_range_m", *switches}
    place_names = ["world", *(name for name in campaign.varied if name not in told)]
    places = _split(trials, place_names)
    cells = [(values, group, m, name) for values, group in places for m in _MAP_MEASURES for name in names]
    figure, panels = _panels(len(cells) // max(len(names), 2), max(len(names), 2))
    for axes, (values, group, measure, name) in zip(panels.flat, cells):
        _draw_lidars(axes, campaign, group, name, measure, switches)
        axes.set_title(", ".join(map(_value_in_words, place_names, values)), fontsize=8)
        _finish(axes, name, measure, True, True)
    _legend(figure, panels.flat[0])
    return png(figure)


def _draw_lidars(
    axes: Axes,
    campaign: Campaign,
    trials: pd.DataFrame,
    name: str,
    measure: str,
    switches: Sequence[str],
) -> None:
    for lidar in [lidar for lidar in palette.LIDARS if lidar in set(trials["lidar"])]:
        of_lidar = trials[trials["lidar"] == lidar]
        for number, (values, group) in enumerate(_split(of_lidar, switches)):
            x = float(group[name].iloc[0])
            found = metrics(campaign, group)
            style = {"color": palette.LIDARS[lidar], "marker": palette.MARKERS[lidar], "linestyle": ""}
            style["label"] = ", ".join([lidar, *(_value_in_words(n, v) for n, v in zip(switches, values))])
            style["markerfacecolor"] = palette.LIDARS[lidar] if number == 0 else "white"
            _errorbar(axes, [(x * (1.0 + 0.04 * number), *_measured(found, measure))], style)
    if name == "lidar_range_m":
        axes.set_xscale("log")
        _tick(axes.xaxis)
    axes.set_yscale("log")
    _tick(axes.yaxis)
    axes.set_xlim(_widened(*axes.get_xlim()))
    axes.set_ylim(_widened(*axes.get_ylim()))


def _widened(low: float, high: float) -> tuple[float, float]:
    """Return limits that are at least a factor of 2 apart, so that nearly equal values look equal."""
    return (low / 1.5, high * 1.5) if high < 2.0 * low else (low, high)


def _tick(axis: Axis) -> None:
    """Label a logarithmic axis at 1, 2, 5, 10, ..., in plain numbers."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_locator(NullLocator())


def _split(trials: pd.DataFrame, names: Sequence[str]) -> list[tuple[tuple, pd.DataFrame]]:
    if not names:
        return [((), trials)]
    return [
        (v if isinstance(v, tuple) else (v,), group) for v, group in trials.groupby(list(names), sort=False)
    ]


def _style(curves: Sequence[str], values: Any, number: int) -> dict:
    """Return how a curve is drawn: an algorithm's own colour, or one of six greys and colours."""
    values = values if isinstance(values, tuple) else (values,)
    told = list(map(_value_in_words, curves, values))
    label = ", ".join([words for words in told if not words.endswith(" off")] or told)
    algorithm = dict(zip(curves, values)).get("algorithm")
    lidar = dict(zip(curves, values)).get("lidar")
    if len(curves) == 1 and algorithm:
        return {"color": COLOURS[algorithm], "marker": MARKERS[algorithm], "label": label}
    if len(curves) == 1 and lidar:
        return {"color": palette.LIDARS[lidar], "marker": palette.MARKERS[lidar], "label": label}
    style = {"color": _GREYS[number % 6], "marker": _MARKS[number % 6], "linestyle": _DASHES[number % 6]}
    return {**style, "label": label}


def _value_in_words(name: str, value: Any) -> str:
    """Return a value in words."""
    short = name.split(".", 1)[-1].replace("_", " ")
    if isinstance(value, (bool, np.bool_)):
        return f"{short} {'on' if value else 'off'}"
    if isinstance(value, str):
        return NAMES.get(value, value.replace("_", " "))
    words, _, unit = LABELS.get(name, short).partition(" [")
    return f"{words} {value:g} {unit.rstrip(']')}".rstrip()


def _panels(rows: int, columns: int) -> tuple[Figure, np.ndarray]:
    width, height = _PANEL_IN
    figure = Figure(figsize=(max(width * columns, 4.2), height * rows + 0.5), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False)


def _finish(axes: Axes, name: str, measure: str, with_x: bool, with_y: bool) -> None:
    if with_x:
        axes.set_xlabel(LABELS.get(name, name), **_SMALL)
    if with_y:
        axes.set_ylabel(LABELS[measure], **_SMALL)
    if measure.endswith("_rate"):
        axes.set_ylim(-0.03, 1.03)
    _grid(axes)


def _grid(axes: Axes) -> None:
    axes.tick_params(labelsize=7)
    axes.grid(alpha=0.3, lw=0.4)


def _legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside upper center",
        ncol=2 if max(map(len, labels)) > _LABEL_MAX else min(len(labels), 6 if len(labels) % 5 == 1 else 5),
        fontsize=7,
        frameon=False,
    )
