"""Draws maps of logs without and with loop closure, beside this file. Needs a folder with the bags.

source devel/setup.bash && python src/gridslam/doc/make_log_figure.py DATA
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from gridslam.evaluation.map_picture import shades
from gridslam.files.map_file import read_map
from gridslam.files.tum import read_tum

HERE = Path(__file__).resolve().parent
LOGS = {"aces": "ACES", "csail": "CSAIL", "corridor": "a bare corridor of 60 m"}
SEED, PIXEL_M = 2, 0.1
HEIGHTS = (1.0, 1.55, 0.3)
"""Of the rows, for maps of these shapes."""


def main() -> None:
    """Map each log twice, and write the figure."""
    data = Path(sys.argv[1])
    plt.rcParams.update({"font.size": 8})
    figure, rows = plt.subplots(
        len(LOGS), 2, figsize=(8.0, 11.0), layout="constrained", gridspec_kw={"height_ratios": HEIGHTS}
    )
    for (log, title), axes in zip(LOGS.items(), rows):
        for closes, plan in zip((False, True), axes):
            draw(plan, data / f"{log}.bag", closes)
            plan.set_title(f"{title}, {'with' if closes else 'without'} loop closure")
        axes[0].set_ylabel("y [m]")
    for plan in rows[-1]:
        plan.set_xlabel("x [m]")
    figure.savefig(HERE / "logs_closed.png", dpi=100)


def draw(plan: Axes, bag: Path, loop_closure: bool) -> None:
    """Map a bag, and draw its map and path."""
    with tempfile.TemporaryDirectory() as folder:
        words = ["base_frame:=base_link", f"seed:={SEED}", f"loop_closure:={str(loop_closure).lower()}"]
        replay = HERE.parent / "nodes/gridslam_replay"
        subprocess.run([sys.executable, replay, bag, "--output", folder, *words], check=True)
        grid, path = read_map(Path(folder, "map.yaml")), read_tum(Path(folder, "trajectory_final.tum"))
    greys, pixel_m = shades(grid, PIXEL_M)
    (left, bottom), (height, width) = grid.origin_xy_m, greys.shape
    extent = (left, left + width * pixel_m, bottom, bottom + height * pixel_m)
    plan.imshow(
        greys, cmap="gray", vmin=0.0, vmax=1.0, origin="lower", extent=extent, interpolation="nearest"
    )
    plan.plot(*path.poses_in_map[:, :2].T, color="#2b6cb0", lw=0.8)


if __name__ == "__main__":
    main()
