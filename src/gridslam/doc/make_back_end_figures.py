"""Draws the figures of evaluation and loop closure, beside this file, from a simulated round trip."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "src"), str(HERE.parent / "test")]

from plain_correlation import score  # noqa: E402
from planar_world import URG, Drift, along, drive, hold, rectangle_route  # noqa: E402

from gridslam import SlamParameters, se2  # noqa: E402
from gridslam.evaluation import draw_map_error, map_error, poses_at  # noqa: E402
from gridslam.filter.grid_slam import GridSlam  # noqa: E402
from gridslam.loop_closure import LoopClosureParameters  # noqa: E402
from gridslam.loop_closure.closer import LoopCloser  # noqa: E402
from gridslam.loop_closure.correction import Correction  # noqa: E402
from gridslam.loop_closure.local_maps.stretches import LocalMaps  # noqa: E402
from gridslam.loop_closure.path.measured_path import MeasuredPath  # noqa: E402
from gridslam.loop_closure.path.way_uncertainty import way_covariances  # noqa: E402

SEED = 4
FILTER = {"linearUpdate": 0.3, "angularUpdate": 0.2, "srr": 0.05, "srt": 0.05, "str": 0.05, "stt": 0.05}
TURNS_RAD = (-0.02, 0.0, 0.02)
WALL, BEFORE, AFTER = "0.75", "#e8711a", "#2b6cb0"


def main() -> None:
    """Write every figure."""
    plt.rcParams.update({"font.size": 8, "axes.spines.top": False, "axes.spines.right": False})
    log = drive(hold(), along(rectangle_route(12.0, 7.0, 0.5), 0.1, 0.1), URG, SEED, Drift(), seconds=0.1)
    before, _ = fly(log, LoopClosureParameters(separation_m=1e4))
    after, closer = fly(log, LoopClosureParameters())
    grid, trajectory = before.grid(), before.trajectory()
    draw_map_error(
        HERE / "evaluation.png", grid, hold(), map_error(grid, hold()), estimate=trajectory, truth=log.truth
    )
    figure = draw_loop_closure(log, before, after, closer)
    figure.savefig(HERE / "loop_closure.png", dpi=110, bbox_inches="tight")
    plt.close(figure)


def fly(log, parameters: LoopClosureParameters):
    """Run filter and closer over a log."""
    slam = GridSlam(
        SlamParameters(seed=SEED, **FILTER), starting_pose=tuple(log.odometry[0]), keep_scans=True
    )
    closer = LoopCloser(parameters)
    for scan, odometry in zip(log.scans, log.odometry):
        correct(slam, closer.take(scan.stamp_s))
        if slam.process(scan, odometry) is not None:
            closer.add_node(scan.stamp_s, odometry)
            if closer.is_search_due:
                closer.search(slam.snapshot())
    correct(slam, closer.take(math.inf))
    correct(slam, closer.finish(slam.snapshot()))
    return slam, closer


def correct(slam: GridSlam, correction: Correction | None) -> None:
    """Let the filter take over a correction, if there is one."""
    if correction is not None:
        slam.correct(correction)


def draw_loop_closure(log, before: GridSlam, after: GridSlam, closer: LoopCloser):
    """Path without and with closing, and how well the flight's end fits its beginning, shift by shift."""
    figure, (plan, surface) = plt.subplots(1, 2, figsize=(10.0, 3.9), width_ratios=(1.5, 1.0))
    for x1, y1, x2, y2 in hold().ends_m:
        plan.plot((x1, x2), (y1, y2), color=WALL, lw=2.5)
    plan.plot(*log.truth.poses_in_map[:, :2].T, color="k", lw=0.8, ls=":", label="true path")
    plan.plot(*log.odometry[:, :2].T, color="0.55", lw=0.8, label="odometry")
    for slam, colour, label in ((before, BEFORE, "filter alone"), (after, AFTER, "with loop closure")):
        trajectory = slam.trajectory()
        error = trajectory.poses_in_map - poses_at(log.truth, trajectory.stamps_s)
        rmse = np.sqrt((error[:, :2] ** 2).sum(axis=1).mean())
        plan.plot(*trajectory.poses_in_map[:, :2].T, color=colour, lw=1.3, label=f"{label}: ATE {rmse:.2f} m")
    path = after.trajectory()
    for closure in closer.closures:
        ends = poses_at(path, np.array([closure.stamp_from_s, closure.stamp_to_s]))
        plan.plot(*ends[:, :2].T, "o-", color="k", ms=3, lw=0.8)
    plan.plot([], [], "o-", color="k", ms=3, lw=0.8, label=f"{len(closer.closures)} closures")
    plan.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    plan.legend(loc="center", frameon=False, fontsize=8)
    _draw_surface(surface, before)
    return figure


def _draw_surface(ax, slam: GridSlam) -> None:
    parameters = LoopClosureParameters()
    maps, snapshot = LocalMaps(parameters), slam.snapshot()
    maps.extend(snapshot.scans)
    path = MeasuredPath.empty().followed(snapshot, maps.informations, parameters)
    last = len(path) - 1
    first_map, last_map = maps.around(path, 0), maps.around(path, last)
    x, y, yaw = se2.between(path.poses[0], path.poses[last])
    along_m, across_m = x + np.arange(-4.5, 4.6, 0.1), y + np.arange(-2.5, 2.6, 0.1)
    scores = [
        [
            max(score(first_map, last_map, (u, v, yaw + turn), parameters.overlap_min) for turn in TURNS_RAD)
            for u in along_m
        ]
        for v in across_m
    ]
    drawn = ax.pcolormesh(along_m, across_m, scores, cmap="gray_r", vmin=0.0, vmax=1.0, shading="nearest")
    uncertainty = way_covariances(path, path.covariances, [], last, parameters.drift_share)[0]
    reach_m = parameters.window_sigmas * np.sqrt(np.linalg.eigvalsh(uncertainty[:2, :2])[-1])
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])
    ax.plot(*((x, y) + reach_m * corners).T, color=BEFORE, lw=1.5, label="window: 3 sigma of the path")
    ax.plot(x, y, "+", color=BEFORE, ms=9, mew=2, label="the filter's estimate")
    ax.set(
        aspect="equal",
        xlabel="last pose seen from the first: along the wall [m]",
        ylabel="across [m]",
    )
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False, fontsize=8)
    ax.figure.colorbar(drawn, ax=ax, label="share that agrees", orientation="horizontal", pad=0.22)


if __name__ == "__main__":
    main()
