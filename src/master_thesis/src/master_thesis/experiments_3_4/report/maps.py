"""The numbers of Experiments 3 and 4 for the page, and their common chart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Sequence

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flights.mapping.slam_metrics import verdict
from flights.results import palette
from flights.results.picture_files import svg
from flights.trials.store import Store
from flights.trials.trial import Row
from master_thesis.experiments_3_4.map_variants import medians
from master_thesis.experiments_3_4.report.pieces import CLOSED, OPEN, piece
from master_thesis.report import thesis
from master_thesis.report.content import Picture, Table, number
from master_thesis.report.size import Size

ORDER = ("urg", "ust", "tim", "utm", "puck", "m8")
"""By range."""
MATTERS_M = 0.02
"""Loop closure is shown if the median trajectory errors differ by at least this, m."""
TRUE_TO_THE_WORLD = "true to the world"

_TICKS_M = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
_COLUMNS = {
    "ate_rmse_m": ("trajectory error, m", 3),
    "map_error_p95_m": ("95 % of the map within, m", 3),
    "wall_straightness_rms_m": ("walls bent by, m", 3),
    "wall_seen_share": ("wall seen", 2),
    "closures": ("loops", 0),
    "cpu_ms": ("CPU a scan, ms", 1),
}


@dataclass(frozen=True)
class Maps:
    """The maps of a world: metrics by lidar over the seeds, without and with loop closure."""

    world: str
    open: Mapping[str, Sequence[dict]]
    closed: Mapping[str, Sequence[dict]]

    @property
    def lidars(self) -> tuple[str, ...]:
        """Lidars that have a map, by range."""
        return tuple(lidar for lidar in ORDER if self.open.get(lidar))

    @property
    def fewest(self) -> int:
        """The least number of flights of a lidar."""
        return min((len(self.open[lidar]) for lidar in self.lidars), default=0)

    def middle(self, lidar: str, closure: bool = False) -> dict:
        """Return the medians over the seeds."""
        return medians((self.closed if closure else self.open)[lidar])

    def verdict(self, lidar: str, closure: bool = False) -> str:
        """Return our description of the median map."""
        return verdict(self.middle(lidar, closure))

    def is_true(self, lidar: str, closure: bool = False) -> bool:
        """Return whether the median map is true to the world."""
        return self.verdict(lidar, closure) == TRUE_TO_THE_WORLD

    def closure_matters(self, lidar: str) -> bool:
        """Return whether loop closure changes the path."""
        ates = (self.middle(lidar, closure)["ate_rmse_m"] for closure in (False, True))
        return abs(next(ates) - next(ates)) > MATTERS_M


def short_name(lidar: str) -> str:
    """Return the thesis's shorthand of a lidar."""
    return thesis.LIDARS[lidar].short


def maps_of(world: str, size: Size, store: Store) -> tuple[Maps, dict[str, Row]]:
    """Return a world's maps, and for each lidar the piece with the shown pictures."""
    numbers: dict = {OPEN: {}, CLOSED: {}}
    shown: dict[str, Row] = {}
    for lidar in size.lidars:
        for seed in size.map_seeds:
            done = store.get(piece(size, world, lidar, seed))
            if done is None:
                continue
            for name, found in numbers.items():
                found.setdefault(lidar, []).append({**done.result[name], "seed": seed})
            if OPEN in done.result["pictures"]:
                shown.setdefault(lidar, done)
    return Maps(world, numbers[OPEN], numbers[CLOSED]), shown


def maps_table(maps: Maps, caption: str) -> Table:
    """Return the metrics of every lidar, without and with loop closure, beside the thesis's words."""
    rows = []
    for lidar in maps.lidars:
        words = thesis.MAPS[maps.world][lidar]
        for closure in (False, True):
            middle = maps.middle(lidar, closure)
            rows.append(
                (
                    f"{short_name(lidar)}, {thesis.LIDARS[lidar].range_m:g} m",
                    "yes" if closure else "no",
                    *(number(middle[key], digits) for key, (_, digits) in _COLUMNS.items()),
                    number(middle["odometry_ate_rmse_m"], 2),
                    maps.verdict(lidar, closure),
                    f"{words.words} ({words.figure})",
                )
            )
    header = (
        "lidar, range",
        "loop closure",
        *(heading for heading, _ in _COLUMNS.values()),
        "odometry alone, m",
        "our map is",
        "the thesis says",
    )
    return Table(
        caption,
        header,
        rows,
        words=2,
        theirs_last=True,
        note=("One flight of each lidar" if maps.fewest == 1 else "Medians over the seeds")
        + ". Trajectory error: root mean square, not aligned, of the path as "
        "it is at the end. 95 % of the map: of its occupied cells, from the nearest true wall. Walls "
        "bent by: deviation of straight walls' cells from a fitted line. Wall seen: share of the true "
        "walls' length in the map. Odometry alone: its trajectory error.",
    )


def range_chart(maps: Maps) -> Picture:
    """Return the chart of the trajectory error by lidar in the order of range, a mark for each seed."""
    figure = Figure(figsize=(7.2, 3.1), layout="constrained")
    axes = figure.add_subplot()
    for place, lidar in enumerate(maps.lidars):
        for closure, found in ((False, maps.open), (True, maps.closed)):
            ates = [metrics["ate_rmse_m"] for metrics in found[lidar]]
            axes.plot(
                [place + (0.12 if closure else -0.12)] * len(ates),
                ates,
                palette.MARKERS[lidar],
                ms=7,
                mfc="white" if closure else palette.LIDARS[lidar],
                mec=palette.LIDARS[lidar],
                mew=1.4,
                ls="",
            )
    labels = [f"{short_name(lidar)}\n{thesis.LIDARS[lidar].range_m:g} m" for lidar in maps.lidars]
    axes.set_xticks(range(len(labels)), labels, fontsize=8)
    axes.set_xlim(-0.5, len(labels) - 0.5)
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    axes.set_yticks(_TICKS_M, [f"{tick:g}" for tick in _TICKS_M])
    axes.minorticks_off()
    axes.set_ylim(min(low, 0.004), max(high, 0.4))
    axes.set_ylabel("trajectory error [m]", fontsize=8)
    axes.tick_params(labelsize=8)
    axes.grid(alpha=0.3, lw=0.4, axis="y")
    grey: dict[str, Any] = {"marker": "o", "ls": "", "mec": "black", "ms": 6}
    handles = [
        Line2D([], [], mfc="black", label="without loop closure", **grey),
        Line2D([], [], mfc="white", label="with loop closure", **grey),
    ]
    axes.legend(handles=handles, fontsize=7, frameon=False, loc="upper right")
    return Picture(
        svg(figure),
        f"Trajectory error in the {maps.world} by lidar, in the order of their range; a mark is a flight.",
        "Marks of the trajectory error of each lidar, on a logarithmic scale",
        "9.1.2",
        "“The range of the lidars on the other hand has a huge impact. This is most clearly seen in "
        "Experiment 4.”",
    )


def map_pictures(maps: Maps, shown: Mapping[str, Row]) -> list[Picture]:
    """Return each lidar's world and maps in the thesis's order, with loop closure too if it matters."""
    pictures = []
    for lidar, words in sorted(thesis.MAPS[maps.world].items(), key=lambda item: _place(item[1].figure)):
        if lidar in shown:
            names = (OPEN, CLOSED) if maps.closure_matters(lidar) else (OPEN,)
            what = thesis.LIDARS[lidar].name
            pictures += [map_picture(what, words, shown[lidar], name) for name in names]
    return pictures


def map_picture(what: str, words: thesis.MapWords, done: Row, name: str) -> Picture:
    """Return the world and the maps of one flight. words: the thesis's; name: OPEN or CLOSED."""
    metrics = done.result[name]
    return Picture(
        done.result["pictures"][name].encode(),
        f"{what}, {'with' if name == CLOSED else 'without'} loop closure: {verdict(metrics)}; trajectory "
        f"error {metrics['ate_rmse_m']:.3f} m, 95 % of the map within {metrics['map_error_p95_m']:.3f} m "
        "of a wall.",
        f"The world from above, the map at half time and the map at the end: {what}",
        f"Figure {words.figure}",
        f"{thesis.FIGURES[words.figure.rstrip('ab')].caption} In short: {words.words}.",
        wide=True,
    )


def _place(figure: str) -> tuple[float, str]:
    return float(figure.rstrip("ab").split(".")[1]), figure
