"""The pictures of Experiment 2, after the thesis's figures 6.3 and 8.3 to 8.7. Needs matplotlib, no display.

All are drawn in the frame of the freeze, with ahead upwards as in the thesis ("wall on the left"). The red
arrow is the original algorithm's proposal, the green one the improved one's; 1 m of arrow is 1 m/s.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyArrowPatch, Patch

from cepa import CepaParameters, LaserScan2D, view
from flights.results import palette
from flights.results.picture_files import files
from flights.results.pictures_from_above import LABEL, draw_obstacles, draw_uav, frame, up
from flights.results.solids import solid_mark
from master_thesis.experiment_2.description import (
    TrialDescription,
    first_scan_of,
    flown,
    freeze_of,
    in_freeze_frame,
)
from master_thesis.experiment_2.proposals import Proposals, propose, sweep
from master_thesis.experiment_2.trial import EmergencyTrial
from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import Model
from simulation_tools.vehicle.uav import load_uav

_ORIGINAL, _IMPROVED, _INTRUSION = palette.ALGORITHMS["original"], palette.ALGORITHMS["improved"], "#f0a3a3"
_PATH = "viridis"
_SHOWN = 1.4  # half of the shown area's side, in r_LB
_UAV_SPACING_M = 0.4


def pictures(description: TrialDescription, trial: EmergencyTrial, content: dict) -> dict[str, bytes]:
    """Return the files by name, each picture as PNG, PDF and SVG; the trial has its freeze and first scan."""
    uav = load_uav(description.model, description.lidar).model
    return {
        **files("proposals", proposals_figure(description, trial, uav)),
        **files("k_sweep", sweep_figure(description, trial)),
        **files("path", _path_figure(description, trial, uav, content)),
    }


def proposals_figure(description: TrialDescription, trial: EmergencyTrial, uav: Model) -> Figure:
    """Draw side by side the obstacles around the UAV, and the algorithms' proposals for its scan."""
    figure = Figure(figsize=(7.2, 4.4))
    place, seen = figure.subplots(1, 2, sharey=True)
    scan, parameters = first_scan_of(trial).scan, description.cepa
    draw_obstacles(place, freeze_of(trial).obstacles)
    draw_uav(place, uav, Pose.identity())
    _draw_circle(place, parameters)
    proposed = propose(scan, parameters)
    _draw_proposals(seen, scan, parameters, proposed)
    for axes, title in (
        (place, "(a) around the UAV when time goes on"),
        (seen, "(b) what the algorithms propose"),
    ):
        _frame_around(axes, parameters)
        axes.set_title(title, fontsize=8.5)
    seen.set_ylabel("")
    figure.legend(handles=_legend(), loc="lower center", ncol=6, fontsize=7, frameon=False)
    figure.suptitle(f"{_title(description)}; improved: {proposed.reason}", fontsize=9)
    figure.subplots_adjust(left=0.08, right=0.99, bottom=0.18, top=0.87, wspace=0.06)
    return figure


def sweep_figure(description: TrialDescription, trial: EmergencyTrial) -> Figure:
    """Draw one panel for each K: the filter's widening of near obstacles, and the proposals."""
    scan = first_scan_of(trial).scan
    all_proposed = sweep(scan, description.cepa)[::-1]
    figure = Figure(figsize=(7.2, 4.5))
    panels = figure.subplots(2, 4, sharex=True, sharey=True)
    for axes, proposed in zip(panels.flat, all_proposed):
        _draw_proposals(axes, scan, replace(description.cepa, k_filter=proposed.k_filter), proposed)
        _frame_around(axes, description.cepa)
        axes.set_title(f"K = {proposed.k_filter:g} m/rad", fontsize=8)
        axes.label_outer()
    figure.legend(handles=_legend()[1:], loc="lower center", ncol=5, fontsize=7, frameon=False)
    figure.suptitle(f"{_place(description)}: one scan, seen through the filter with different K", fontsize=9)
    figure.subplots_adjust(left=0.08, right=0.99, bottom=0.17, top=0.88, wspace=0.06, hspace=0.22)
    return figure


def _path_figure(description: TrialDescription, trial: EmergencyTrial, uav: Model, content: dict) -> Figure:
    """Draw from above the UAV's path after the release, coloured by time, and its shape on the way."""
    poses = flown(trial)
    path = in_freeze_frame(trial, poses[:, 1:4])
    since_s = poses[:, 0] - freeze_of(trial).t_s
    low = np.minimum(path[:, :2].min(axis=0) - 0.5, -1.0)
    high = np.maximum(path[:, :2].max(axis=0) + 0.5, 1.0)
    figure = Figure(figsize=(4.6, 4.6 * (high - low)[0] / (high - low)[1] + 0.6))
    axes = figure.add_subplot()
    draw_obstacles(axes, freeze_of(trial).obstacles)
    for index in _spaced(path):
        draw_uav(axes, uav, _turned(trial, poses[index]), alpha=0.5)
    lines = LineCollection(
        np.stack((up(path[:-1, :2]), up(path[1:, :2])), axis=1),
        cmap=_PATH,
        norm=Normalize(0.0, since_s[-1]),
        linewidth=2.0,
        zorder=6,
    )
    lines.set_array(since_s[:-1])
    axes.add_collection(lines)
    axes.plot(*up(path[0, :2]), "o", ms=5, mfc="white", mec="black", zorder=7)
    for after_s in content["touched"].values():
        where = path[np.searchsorted(since_s, after_s).clip(max=len(path) - 1), :2]
        axes.plot(*up(where), "X", ms=9, color=_ORIGINAL, mec="black", mew=0.6, zorder=8)
    frame(axes, low[0], high[0], low[1], high[1])
    bar = figure.colorbar(lines, cax=axes.inset_axes((1.03, 0.0, 0.04, 1.0)))
    bar.set_label("time since it was let go [s]", **LABEL)
    bar.ax.tick_params(labelsize=7)
    axes.set_title(
        f"{_title(description)}\n{description.algorithm} algorithm: {_what_happened(content)}", fontsize=8.5
    )
    return figure


def _what_happened(content: dict) -> str:
    if content["collision"]:
        name, after_s = min(content["touched"].items(), key=lambda item: item[1])
        return f"touched {name.split('::')[0].replace('_', ' ')} after {after_s:.1f} s"
    end = f"got away after {content['left_after_s']:.1f} s" if content["left"] else "did not get away"
    return f"{end}, least clearance {content['min_clearance_m']:.2f} m"


def _spaced(path: np.ndarray) -> list[int]:
    """Return the first and the last place of a path (n, 3), and places between that do not overlap."""
    shown = [0]
    for index in range(len(path)):
        if min(np.linalg.norm(path[index] - path[i]) for i in shown) >= _UAV_SPACING_M:
            shown.append(index)
    return [*shown, len(path) - 1]


def _turned(trial: EmergencyTrial, row: np.ndarray) -> Pose:
    """Return the pose of a row (8,: t, position, quaternion) in the frame of the freeze."""
    x, y, _ = in_freeze_frame(trial, row[None, 1:4])[0]
    yaw = Pose(tuple(row[1:4]), tuple(row[4:8])).yaw_rad - freeze_of(trial).uav.yaw_rad
    return Pose.from_xyz_rpy(float(x), float(y), 0.0, yaw=yaw)


def _draw_proposals(axes: Axes, scan: LaserScan2D, parameters: CepaParameters, proposed: Proposals) -> None:
    beams = scan.full_turn(parameters.dropout_beams)
    hit = np.isfinite(beams.ranges)
    points = beams.ranges[hit, None] * np.column_stack((np.cos(beams.angles[hit]), np.sin(beams.angles[hit])))
    intrusions = view.intrusions(beams, parameters)
    ends = up(intrusions.reshape(-1, 2)).reshape(-1, 2, 2)
    axes.add_collection(
        LineCollection(list(ends), colors=_INTRUSION, linewidths=0.5, zorder=2, rasterized=True)
    )
    axes.scatter(
        up(points)[:, 0], up(points)[:, 1], s=1.2, color="black", linewidths=0, zorder=3, rasterized=True
    )
    _draw_circle(axes, parameters)
    axes.plot(0, 0, "+", ms=5, color="black", zorder=4)
    # Red is below and wider, so that it stays visible if both are equal
    _arrow(axes, proposed.original_xy, _ORIGINAL, 3.6)
    _arrow(axes, proposed.improved_xy, _IMPROVED, 1.5)


def _arrow(axes: Axes, velocity_xy: tuple[float, float], colour: str, width: float) -> None:
    if np.hypot(*velocity_xy) < 1e-3:
        axes.plot(0, 0, "o", ms=2.5 + width, color=colour, zorder=5 - 0.1 * width)
        return
    x, y = up(np.array(velocity_xy)).tolist()
    axes.add_patch(
        FancyArrowPatch(
            (0, 0),
            (x, y),
            arrowstyle=f"-|>,head_length={4.5 - 0.4 * width:g},head_width={1.9 - 0.12 * width:g}",
            color=colour,
            lw=width,
            shrinkA=0,
            shrinkB=0,
            zorder=6 - 0.1 * width,
        )
    )


def _draw_circle(axes: Axes, parameters: CepaParameters) -> None:
    axes.add_patch(Circle((0, 0), parameters.r_lb, fill=False, ec="black", lw=0.8, ls=(0, (4, 2)), zorder=4))


def _frame_around(axes: Axes, parameters: CepaParameters) -> None:
    reach = _SHOWN * parameters.r_lb
    frame(axes, -reach, reach, -reach, reach)


def _title(description: TrialDescription) -> str:
    return f"{_place(description)}, $K$ = {description.cepa.k_filter:g} m/rad"


def _place(description: TrialDescription) -> str:
    name = description.scenario.replace("_", " ")
    return f"{name}, $r_{{LB}}$ = {description.cepa.r_lb:g} m"


def _legend() -> list:
    dashed: dict[str, Any] = {"color": "black", "lw": 0.8, "ls": (0, (4, 2))}
    return [
        solid_mark("obstacle"),
        Line2D([], [], label="$r_{LB}$", **dashed),
        Line2D([], [], marker=".", ls="", ms=4, color="black", label="lidar"),
        Patch(facecolor=_INTRUSION, label="intrusions after the K filter"),
        Line2D([], [], color=_ORIGINAL, lw=3.6, label="original"),
        Line2D([], [], color=_IMPROVED, lw=1.5, label="improved"),
    ]
