"""Experiments 3 and 4 without GNSS on the page: what each lidar can do."""

from __future__ import annotations

from typing import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flights.mapping.mapping_flight import SCENARIOS
from flights.results import palette
from flights.results.picture_files import svg
from flights.results.solids import draw_solids
from flights.trials.store import Store
from flights.worlds.floor_plan import outlines_of_file
from master_thesis.experiments_3_4.report.maps import ORDER, short_name
from master_thesis.experiments_3_4.without_gnss.flight import distances
from master_thesis.experiments_3_4.without_gnss.pieces import EXPERIMENT, piece
from master_thesis.report import thesis
from master_thesis.report.content import Block, Picture, Section, Table, number, seeds_of
from master_thesis.report.size import Size

COLUMNS = {
    "ate_m": "error of the pose flown by, m",
    "odometry_ate_m": "error of odometry, m",
    "path_p95_m": "off the planned path, 95 %, m",
    "landed_off_m": "landed off the start, m",
    "height_p95_m": "error of the height, 95 %, m",
}


def section(size: Size, store: Store) -> Section:
    """Return the section of the pieces that are there."""
    flown = {world: _flights(world, size, store) for world in size.worlds}
    flown = {world: flights for world, flights in flown.items() if flights}
    blocks: list[Block] = [_table(flown), _paths(flown)] if flown else []
    return Section(
        key=EXPERIMENT,
        title="Experiments 3 and 4 without GNSS",
        reference="not in the thesis, whose UAV flies by the ground truth",
        method=(
            "The UAV flies Experiments 3 and 4 by lidar, IMU and a range finder that looks down, as in a "
            "steel hold. The flight controller's only position is odometry from the lidar. gridslam with "
            "loop closure corrects it, and the UAV flies its mission by the corrected pose. The ground "
            "truth only judges."
        ),
        blocks=blocks,
        findings=(),
        parameters=f"{seeds_of(size.map_seeds)}; launch argument gnss:=false",
    )


def _flights(world: str, size: Size, store: Store) -> dict[str, list[dict]]:
    """Return the results of each lidar, by range, over the seeds."""
    found: dict[str, list[dict]] = {}
    for lidar in (each for each in ORDER if each in size.lidars):
        rows = (store.get(piece(size, world, lidar, seed)) for seed in size.map_seeds)
        done = [row.result for row in rows if row is not None]
        if done:
            found[lidar] = done
    return found


def _table(flown: Mapping[str, Mapping[str, Sequence[dict]]]) -> Table:
    rows = [
        (
            f"{world}, {short_name(lidar)}, {thesis.LIDARS[lidar].range_m:g} m",
            f"{sum(done['flown'] for done in results)} of {len(results)}",
            str(sum(done["contact"] for done in results)),
            *(_middle_and_worst([done[key] for done in results]) for key in COLUMNS),
        )
        for world, lidars in flown.items()
        for lidar, results in lidars.items()
    ]
    return Table(
        "What each lidar can do without GNSS",
        ("world, lidar, range", "flown and landed", "contacts", *COLUMNS.values()),
        rows,
        note="Median over the seeds, the worst in brackets. Errors of poses: root mean square over the "
        "flight, not aligned. Off the planned path: true distance from the straight lines between the "
        "waypoints, corners included.",
    )


def _middle_and_worst(values: Sequence[float | None]) -> str:
    known = [value for value in values if value is not None]
    if not known:
        return "-"
    middle = number(float(np.median(known)), 3)
    return middle if len(known) == 1 else f"{middle} ({max(known):.3f})"


def _paths(flown: Mapping[str, Mapping[str, Sequence[dict]]]) -> Picture:
    """Return the true paths of the first flight of each lidar, and how far they are off the planned path."""
    figure = Figure(figsize=(5.5 * len(flown), 5.8), layout="constrained")
    grid = figure.subplots(2, len(flown), squeeze=False, height_ratios=(2.2, 1.0))
    for (above, below), (world, lidars) in zip(grid.T, flown.items()):
        scenario = SCENARIOS[world]
        way_xy = np.array([scenario.start_xyz_yaw[:2], *(w.position_m[:2] for w in scenario.waypoints)])
        _draw_world(above, world, way_xy)
        for lidar, results in lidars.items():
            path_xy = np.array(results[0]["path_xy"])
            look = {"color": palette.LIDARS[lidar], "lw": 1.0}
            above.plot(*path_xy.T, **look)
            above.plot(*path_xy[-1], palette.MARKERS[lidar], **look, ms=5, mec="black", mew=0.4)
            flown_m = np.append(0.0, np.hypot(*np.diff(path_xy, axis=0).T).cumsum())
            below.plot(flown_m, distances(path_xy, way_xy), **look)
        below.set_ylim(bottom=0.0)
        below.margins(x=0.01)
        _name_axes(below, "way flown [m]", "off the planned path [m]")
    marks = [_mark(lidar) for lidar in ORDER if any(lidar in lidars for lidars in flown.values())]
    figure.legend(handles=marks, loc="outside lower center", ncols=len(marks), fontsize=8)
    return Picture(
        svg(figure),
        "True paths of one flight with each lidar, with a mark where it ended. Dashed: the planned path. "
        "Below: the distance from the planned path.",
        "The worlds from above with the path flown with each lidar, and its distance from the planned path",
        wide=True,
    )


def _mark(lidar: str) -> Line2D:
    """Return a thick line with the mark of the end, so that the legend shows the colour."""
    colour, marker, name = palette.LIDARS[lidar], palette.MARKERS[lidar], short_name(lidar)
    return Line2D([], [], color=colour, marker=marker, lw=2.5, ms=6, mec="black", mew=0.4, label=name)


def _draw_world(axes: Axes, world: str, way_xy: np.ndarray) -> None:
    scenario = SCENARIOS[world]
    shapes = outlines_of_file(scenario.world_path)
    draw_solids(axes, (o.outline_xy for o in shapes if o.blocks(scenario.flight_height_m)))
    axes.plot(*way_xy.T, "--", color="black", lw=0.6)
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_title(world, fontsize=9)
    _name_axes(axes, "x [m]", "y [m]")


def _name_axes(axes: Axes, x: str, y: str) -> None:
    axes.set_xlabel(x, fontsize=8)
    axes.set_ylabel(y, fontsize=8)
    axes.tick_params(labelsize=7)
