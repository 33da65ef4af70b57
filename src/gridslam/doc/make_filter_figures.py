"""Draws the figures of the filter with the library itself, beside this file."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "src"), str(HERE.parent / "test")]

import rooms  # noqa: E402
from planar_world import URG, along, drive, hold, rectangle_route  # noqa: E402

from gridslam import GridSlam, SlamParameters, se2  # noqa: E402
from gridslam.filter.motion_model import Motion, predict  # noqa: E402
from gridslam.filter.scan_matcher import ScanMatcher  # noqa: E402
from gridslam.filter.workers import Workers  # noqa: E402
from gridslam.kernels.insertion import EMPTY, SIDE  # noqa: E402
from gridslam.maps.beams import Beams  # noqa: E402

GREY, BLUE, ORANGE, RED = "#b0b0b0", "#2b6cb0", "#e8711a", "#cc1f1a"
PARAMETERS = SlamParameters(particles=30)
BEFORE, AFTER = 110, 122
"""Scans of the log before and after the step that is drawn."""


def main() -> None:
    """Write both figures."""
    plt.rcParams.update({"font.size": 8, "axes.spines.top": False, "axes.spines.right": False})
    log = rooms.log(seed=3)
    slam = GridSlam(
        dataclasses.replace(PARAMETERS, linearUpdate=0.5), starting_pose=log.truth.poses_in_map[0]
    )
    rooms.run(slam, log, 0, BEFORE)
    flight = drive(hold(), along(rectangle_route(12.0, 7.0, laps=0.8), 0.2), URG, seed=1)
    long = GridSlam(PARAMETERS, starting_pose=flight.truth.poses_in_map[0])
    rooms.run(long, flight)
    for name, figure in (("scan_matching", draw_matching(slam, log)), ("tiles", draw_tiles(long))):
        figure.savefig(HERE / f"{name}.png", dpi=110, bbox_inches="tight")
        plt.close(figure)


def draw_matching(slam: GridSlam, log):
    """One step: what odometry draws, and what the scan makes of it."""
    motion = Motion(slam._motion.start, 0.0)
    for pose in log.odometry[BEFORE - 1 : AFTER]:
        motion.add(pose, slam.parameters)
    prediction = predict(slam._poses, motion, np.random.default_rng(0))
    beams, best = Beams.from_scan(log.scans[AFTER - 1], slam.parameters), slam.best_particle
    matches = ScanMatcher(slam.parameters).match(slam._maps, prediction, best, beams, Workers(1))
    found = slam._maps.to_metres(matches.poses)
    figure, (motions, whole, part) = plt.subplots(1, 3, figsize=(11.0, 3.4))
    _draw_motions(motions, slam, prediction, found, log)
    for ax in (whole, part):
        _draw_scans(ax, slam, beams, (prediction.drawn[best], found[best]))
    _zoom(part)
    whole.set_title("one particle's map, and the scan there")
    part.set_title("the same, at one wall")
    whole.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncol=2, frameon=False)
    return figure


def _draw_motions(ax, slam, prediction, found, log):
    for poses, colour, label in (
        (slam._poses, GREY, "particles before"),
        (prediction.drawn, ORANGE, "motion model: drawn from odometry"),
        (found, BLUE, "scan matching: where the scan fits"),
    ):
        ax.plot(*poses[:, :2].T, ".", ms=4, color=colour, label=label)
    ax.plot(*log.truth.poses_in_map[AFTER - 1, :2], "x", color=RED, label="truth")
    ax.set(title="one step of the particles", xlabel="x [m]", ylabel="y [m]", xlim=(-2.4, -1.6))
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), frameon=False)


def _draw_scans(ax, slam, beams, poses):
    grid = slam.grid()
    width, height = grid.size_m
    extent = (
        grid.origin_xy_m[0],
        grid.origin_xy_m[0] + width,
        grid.origin_xy_m[1],
        grid.origin_xy_m[1] + height,
    )
    shades = np.where(grid.cells == -1, 0.8, 1.0 - 0.6 * (grid.cells == 100))
    ax.imshow(shades, origin="lower", extent=extent, cmap="gray", vmin=0.0, vmax=1.0)
    for pose, colour, label in zip(poses, (ORANGE, BLUE), ("as drawn", "as matched")):
        ends = se2.transform(pose, beams.ends[beams.hits] * slam.parameters.delta)
        ax.plot(*ends.T, ".", ms=3, color=colour, label=label)
    ax.set_xlabel("x [m]")


def _zoom(ax):
    ax.set(xlim=(-0.6, 0.6), ylim=(-3.3, -2.7), aspect="equal")


def draw_tiles(slam: GridSlam):
    """Which tiles particles share, after a few scans in which they were resampled."""
    maps = slam._maps
    maps.settle()
    place = np.nonzero((maps.tables != EMPTY).any(axis=0))
    sharing = np.zeros(maps.tables.shape[1:])
    for row, column in zip(*place):
        sharing[row, column] = len(np.unique(maps.tables[:, row, column]))
    figure, (before, ax) = plt.subplots(1, 2, figsize=(11.0, 3.6))
    side = SIDE * slam.parameters.delta
    low = maps.corner * side
    extent = (low[0], low[0] + sharing.shape[1] * side, low[1], low[1] + sharing.shape[0] * side)
    shown = np.where(sharing == 0.0, np.nan, sharing)
    image = ax.imshow(shown, origin="lower", extent=extent, cmap="viridis_r", vmin=1, vmax=len(maps.tables))
    figure.colorbar(image, ax=ax, label="different tiles at this place")
    for walls in (before, ax):
        for x0, y0, x1, y1 in hold().ends_m:
            walls.plot((x0, x1), (y0, y1), color="k", lw=0.8)
        walls.plot(*slam.trajectory().poses_in_map[:, :2].T, color=RED, lw=1.0)
        walls.set(xlim=(-17.0, 17.0), ylim=(-12.0, 12.0), xlabel="x [m]", aspect="equal")
    visits = maps.pool.tiles.visits[maps.tables[slam.best_particle]]
    cells = visits.reshape(*visits.shape[:2], SIDE, SIDE).transpose(0, 2, 1, 3)
    before.imshow(
        np.log1p(cells.reshape(visits.shape[0] * SIDE, -1)), origin="lower", extent=extent, cmap="Greys"
    )
    for edge in np.arange(low[0], extent[1], side):
        before.axvline(edge, color=BLUE, lw=0.3)
    for edge in np.arange(low[1], extent[3], side):
        before.axhline(edge, color=BLUE, lw=0.3)
    used, whole = maps.pool.used, sum(np.count_nonzero(table) for table in maps.tables)
    before.set_title("best particle's cells (darker: more beams), in tiles")
    ax.set_title(f"{len(maps.tables)} particles: {used} tiles instead of {whole}")
    return figure


if __name__ == "__main__":
    main()
