"""Draws a flight as an animation (GIF), from the folder of its results.

    .venv/bin/python src/extensions/flights/doc/make_animations.py results/experiment_1/TIME forest.gif
    .venv/bin/python src/extensions/flights/doc/make_animations.py results/explore/TIME tank.gif

Call it in the sourced workspace. A flight of Experiment 1 is drawn from above: path, speed and the lidar's
hits, all recorded in flight. An exploration is drawn from above and from the side. The clouds of a flight are
not recorded. So rays through the world's surfaces tell what its lidar could see from the recorded path.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any, Iterator

import matplotlib

matplotlib.use("Agg")
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image
from scipy.spatial.transform import Rotation

from flights.results.palette import BELIEF, SOLID, TRUTH
from flights.results.solids import draw_solids
from flights.worlds.floor_plan import outlines_of_file
from gridslam.evaluation.volume.lidars import VIEWS
from gridslam.evaluation.volume.surface import read_surface
from gridslam.evaluation.volume.visibility import Places, visible_samples

FOREST_STEP_S, TANK_STEP_S = 0.25, 2.0
"""Of the flight, between two pictures."""
SHOWN_MS, LAST_MS = 100, 3000
"""How long a picture is shown; the last one longer, before all begins again."""
COLOURS, DOTS_PER_INCH = 48, 100
SAMPLE_M, PIXEL_M = 0.05, 0.1
EDGE_M, REACH_M = 0.3, 4.0
"""Around what was seen; how far from the path the surfaces are looked at."""
SEEN_RGB, UNSEEN_RGB = np.array((27, 120, 55)) / 255.0, np.array((0.6, 0.6, 0.6))
TEXT: dict[str, Any] = {"fontsize": 9}


class Run:
    """What a flight has left.

    Attributes:
        told: of result.json.
        truth: (n, 8) time in s, position in m, quaternion x, y, z, w; from the first movement to the landing.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.told = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        truth = self.table("truth.csv")
        self.truth = truth[truth[:, 0] >= self.told["times_s"]["flying"] - 2.0]

    def table(self, name: str) -> np.ndarray:
        """Return (n, columns) the numbers of a table."""
        return np.loadtxt(self.folder / name, delimiter=",", skiprows=1, ndmin=2)

    def rows(self, step_s: float) -> np.ndarray:
        """Return the indices of truth, one for each step."""
        first, last = self.truth[[0, -1], 0]
        return np.searchsorted(self.truth[:, 0], np.arange(first, last, step_s))

    def speed_m_s(self, row: int) -> float:
        """Return the mean speed over the last half second."""
        before = max(int(np.searchsorted(self.truth[:, 0], self.truth[row, 0] - 0.5)), 0)
        apart, time_s = self.truth[row, 1:4] - self.truth[before, 1:4], np.ptp(self.truth[[before, row], 0])
        return float(np.linalg.norm(apart) / time_s) if time_s else 0.0


def forest(run: Run) -> Iterator[Image.Image]:
    """Yield the flight from above."""
    truth, hits = run.truth, run.table("hits.csv")
    figure = Figure(figsize=(9.0, 4.3), layout="constrained")
    axes = figure.subplots()
    goal = run.told["goal"]
    axes.set(aspect="equal", xlim=(-3.0, goal[0] + 3.0), ylim=(-9.0, 9.0), xlabel="x [m]", ylabel="y [m]")
    shapes = outlines_of_file(run.told["world"])
    for blocks, colour in ((False, "#dfe5d8"), (True, SOLID)):
        draw_solids(axes, (each.outline_xy for each in shapes if each.blocks(goal[2]) is blocks), colour)
    axes.plot(*goal[:2], "*", ms=13, mfc="white", mec="black", label="goal")
    (beams,) = axes.plot([], [], ".", ms=3, color=BELIEF, label="hits of the lidar")
    (path,) = axes.plot([], [], color=TRUTH, lw=2.0, label="path of the UAV")
    (here,) = axes.plot([], [], "o", ms=8, mfc="#9db4cf", mec="black", mew=1.0, label="UAV")
    axes.legend(loc="upper left", ncols=4, fontsize=8, framealpha=1.0)
    for row in run.rows(FOREST_STEP_S):
        now_s = truth[row, 0]
        seen = hits[hits[:, 0] == hits[max(int(np.searchsorted(hits[:, 0], now_s, "right")) - 1, 0), 0]]
        beams.set_data(seen[:, 1], seen[:, 2])
        path.set_data(truth[: row + 1, 1], truth[: row + 1, 2])
        here.set_data(truth[[row], 1], truth[[row], 2])
        axes.set_title(f"{now_s - truth[0, 0]:4.1f} s   {run.speed_m_s(row):.1f} m/s", **TEXT)
        yield picture(figure)


def tank(run: Run, seed: int = 1) -> Iterator[Image.Image]:
    """Yield the exploration from above and from the side. What the lidar could see by then is green."""
    truth = run.truth
    places_m, first_seen = _first_seen(run, seed)
    low_m, high_m = places_m.min(axis=0) - EDGE_M, places_m.max(axis=0) + EDGE_M
    spans = high_m - low_m
    figure = Figure(figsize=(9.0, 9.0 * (spans[1] + spans[2]) / spans[0] + 1.5), layout="constrained")
    panels = figure.subplots(2, 1, height_ratios=spans[1:])
    for panel, name in zip(panels, ("from above", "from the side")):
        panel.set_title(name, loc="left", **TEXT)
        panel.set(aspect="equal", xlabel="x [m]", ylabel="y [m]" if panel is panels[0] else "z [m]")
    views = [((0, up), _drawn(panel, low_m, high_m, up)) for panel, up in zip(panels, (1, 2))]
    for step, row in enumerate(run.rows(TANK_STEP_S)):
        for axes, (image, path, here) in views:
            view = list(axes)
            image.set_data(_shares(places_m[:, view], first_seen > step, low_m[view], high_m[view]))
            path.set_data(truth[: row + 1, 1 + view[0]], truth[: row + 1, 1 + view[1]])
            here.set_data(truth[[row], 1 + view[0]], truth[[row], 1 + view[1]])
        figure.suptitle(
            f"{truth[row, 0] - truth[0, 0]:3.0f} s: green, what the lidar could see by then; red, the path",
            **TEXT,
        )
        yield picture(figure)


def _first_seen(run: Run, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) of the surfaces, and in which step (n,) the lidar could first see each.

    Only points in the box around all that was seen are kept. A point that was never seen has the step n.
    """
    truth, rng = run.truth, np.random.default_rng(seed)
    surface = read_surface(Path(run.told["world"]))
    low_m, high_m = truth[:, 1:4].min(axis=0) - REACH_M, truth[:, 1:4].max(axis=0) + REACH_M
    samples = surface.samples(SAMPLE_M, rng, low_m, high_m)
    never = len(samples.points_m)
    first = np.full(never, never)
    for step, row in enumerate(run.rows(TANK_STEP_S)):
        at = Places(truth[[row], 1:4], Rotation.from_quat(truth[[row], 4:8]).as_matrix())
        some = np.flatnonzero(first == never)
        rest = replace(
            samples,
            points_m=samples.points_m[some],
            normals=samples.normals[some],
            triangles=samples.triangles[some],
        )
        first[some[visible_samples(surface, rest, at, VIEWS[run.told["lidar"]], rng)]] = step
    seen_m = samples.points_m[first < never]
    inside = (samples.points_m >= seen_m.min(axis=0)) & (samples.points_m <= seen_m.max(axis=0))
    return samples.points_m[inside.all(axis=1)], first[inside.all(axis=1)]


def _drawn(panel: Any, low_m: np.ndarray, high_m: np.ndarray, up: int) -> tuple[Any, Any, Any]:
    extent = (low_m[0], high_m[0], low_m[up], high_m[up])
    image = panel.imshow(np.ones((2, 2, 3)), extent=extent, origin="lower", interpolation="nearest")
    (path,) = panel.plot([], [], color="#d1410c", lw=1.3)
    (here,) = panel.plot([], [], "o", ms=8, mfc="white", mec="black")
    return image, path, here


def _shares(places_m: np.ndarray, unseen: np.ndarray, low_m: np.ndarray, high_m: np.ndarray) -> np.ndarray:
    """Return (h, w, 3) colours: green as far as it is seen, dark where much surface lies in a pixel."""
    counts = np.round((high_m - low_m) / PIXEL_M).astype(int)
    limits = np.column_stack((low_m, high_m))
    every, dark = (
        np.histogram2d(*places_m[chosen].T, bins=counts.tolist(), range=limits)[0].T
        for chosen in (slice(None), unseen)
    )
    share = 1.0 - dark / np.maximum(every, 1.0)
    share = np.minimum(2.0 * share, 1.0)[..., None]  # one of a plate's two sides is enough
    depth = np.sqrt(every / np.percentile(every, 99.0)).clip(0.0, 1.0)[..., None]
    colour = share * SEEN_RGB + (1.0 - share) * UNSEEN_RGB
    return 1.0 - (0.4 + 0.5 * depth) * (depth > 0.0) * (1.0 - colour)


def picture(figure: Figure) -> Image.Image:
    """Return what the figure shows now."""
    figure.set_dpi(DOTS_PER_INCH)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3])


def write(pictures: list[Image.Image], path: Path) -> None:
    """Write a GIF with the colours of its first, middle and last picture."""
    some = np.concatenate([np.asarray(pictures[index]) for index in (0, len(pictures) // 2, -1)])
    colours = Image.fromarray(some).quantize(COLOURS, dither=Image.Dither.NONE)
    frames = [each.quantize(palette=colours, dither=Image.Dither.NONE) for each in pictures]
    times_ms = [SHOWN_MS] * (len(frames) - 1) + [LAST_MS]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=times_ms, loop=0, optimize=True)


def main() -> None:
    """Draw a run."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("run", type=Path, help="folder of the results")
    parser.add_argument("gif", type=Path, help="file to write")
    given = parser.parse_args()
    run = Run(given.run)
    pictures = list(tank(run) if run.told["experiment"] == "explore" else forest(run))
    write(pictures, given.gif)
    print(f"{given.gif}: {len(pictures)} pictures, {given.gif.stat().st_size / 1e6:.2f} MB")
    print(f"For its caption: seed {run.told.get('seed')}, commit {str(run.told.get('commit'))[:8]}")


if __name__ == "__main__":
    main()
