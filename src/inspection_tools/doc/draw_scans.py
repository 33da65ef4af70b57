"""Draws median_and_padding.png of the pages; run it in the sourced workspace with .venv/bin/python."""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from inspection_tools import LidarMedianFilter, LidarPadding, ScanGeometry

RANGE_MIN, RANGE_MAX = 0.06, 10.0  # Hokuyo UST-10LX
SIGMA = 0.04 / 3.0
POLE_XY, POLE_RADIUS = (1.6, 0.5), 0.04
BLUE, ORANGE, GREY = "#1f5f99", "#d9722e", "#8a8a8a"


def true_ranges(angles):
    """A hallway 3 m wide, open ahead, closed 4 m behind, with a thin pole ahead on the left."""
    cos, sin = np.cos(angles), np.sin(angles)
    with np.errstate(divide="ignore"):
        walls = 1.5 / np.abs(sin)
        behind = np.where(cos < 0.0, 4.0 / -cos, np.inf)
    along = POLE_XY[0] * cos + POLE_XY[1] * sin
    across = POLE_XY[0] * sin - POLE_XY[1] * cos
    hit = (along > 0.0) & (np.abs(across) < POLE_RADIUS)
    pole = np.where(hit, along - np.sqrt(np.maximum(POLE_RADIUS**2 - across**2, 0.0)), np.inf)
    return np.minimum.reduce([walls, behind, pole])


def measured(angles, rng):
    """With the lidar's noise, 3 % dropouts and 3 % stray readings."""
    ranges = true_ranges(angles) + SIGMA * rng.standard_normal(angles.size)
    stray, lost = rng.random(angles.size) < 0.03, rng.random(angles.size) < 0.03
    ranges[stray] = rng.uniform(0.3, 3.0, stray.sum())
    ranges[ranges > RANGE_MAX] = np.inf
    ranges[lost] = np.nan
    return ranges.astype(np.float32)


def draw(path):
    """Write the figure: the median filter on the left, with its errors below, the padding on the axes."""
    geometry = ScanGeometry(1081, math.radians(-135.0), math.radians(0.25))
    angles = geometry.angle_min_rad + np.arange(geometry.beams) * geometry.angle_increment_rad
    raw = measured(angles, np.random.default_rng(4))
    filtered = LidarMedianFilter().filter(raw, geometry, RANGE_MIN, RANGE_MAX)
    padded = LidarPadding().pad(filtered, geometry, RANGE_MIN, RANGE_MAX)

    figure = plt.figure(figsize=(11.0, 4.4), constrained_layout=True)
    grid = figure.add_gridspec(2, 2, height_ratios=(2.2, 1.0), width_ratios=(1.0, 1.1))
    left, below, right = (figure.add_subplot(cell) for cell in (grid[0, 0], grid[1, 0], grid[:, 1]))
    draw_median(left, below, np.degrees(angles), true_ranges(angles), raw, filtered)
    draw_padding(right, padded)
    for axes in (left, below, right):
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=110)


def draw_median(axes, errors, degrees, truth, raw, filtered):
    """Ranges of one side of the hallway, and what they are off by."""
    truth = np.where(truth > RANGE_MAX, np.nan, truth)
    axes.plot(degrees, truth, color=GREY, linewidth=1.0, label="truth")
    axes.plot(degrees, raw, ".", color=ORANGE, markersize=4, label="/scan")
    axes.plot(degrees, filtered, color=BLUE, linewidth=1.2, label="/scan/filtered, window 3")
    axes.set(xlim=(10.0, 80.0), ylim=(0.0, 6.5), ylabel="range [m]", xticklabels=[])
    axes.set_title("Median: stray readings and dropouts go, the pole stays")
    axes.legend(frameon=False)
    errors.plot(degrees, 100.0 * (raw - truth), ".", color=ORANGE, markersize=4)
    errors.plot(degrees, 100.0 * (filtered - truth), color=BLUE, linewidth=1.2)
    errors.set(xlim=(10.0, 80.0), ylim=(-6.0, 6.0), xlabel="direction of the beam [deg]", ylabel="error [cm]")


def draw_padding(axes, padded):
    """The padded scan from above."""
    turn = (
        padded.geometry.angle_min_rad + np.arange(padded.geometry.beams) * padded.geometry.angle_increment_rad
    )
    seen = padded.seen & np.isfinite(padded.ranges)
    axes.plot(
        padded.ranges[seen] * np.cos(turn[seen]),
        padded.ranges[seen] * np.sin(turn[seen]),
        ".",
        color=BLUE,
        markersize=3,
        label=f"{padded.seen.sum()} beams seen",
    )
    added = turn[~padded.seen]
    sector = np.concatenate((added[added > 0.0], added[added < 0.0] + 2.0 * math.pi))
    axes.fill(
        np.concatenate(([0.0], 6.0 * np.cos(sector))),
        np.concatenate(([0.0], 6.0 * np.sin(sector))),
        color=GREY,
        alpha=0.25,
        linewidth=0,
        label=f"{(~padded.seen).sum()} beams added: unseen, intensity -1",
    )
    axes.plot(0.0, 0.0, marker=(3, 0, -90), color="black", markersize=9, linestyle="none")
    axes.set(xlim=(-5.0, 9.0), ylim=(-3.2, 3.2), xlabel="x, ahead [m]", ylabel="y, left [m]", aspect="equal")
    axes.set_title("Padding: 270 degrees become 360 on the same grid")
    axes.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.2), ncol=2)


if __name__ == "__main__":
    draw(Path(__file__).with_name("median_and_padding.png"))
