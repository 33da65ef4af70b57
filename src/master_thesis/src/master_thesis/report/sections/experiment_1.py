"""Experiment 1 on the page: table 8.1, the worlds of figures 8.1 and 8.2 with the paths flown."""

from __future__ import annotations

from typing import Mapping, Sequence

import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from master_thesis.flight.scenario_flight import WORLDS
from master_thesis.report import thesis
from master_thesis.report.content import (
    Block,
    Finding,
    Picture,
    Section,
    Table,
    counted,
    listed,
    number,
    spread,
)
from master_thesis.report.pieces.experiment_1 import ALGORITHMS, piece
from master_thesis.report.size import Size
from master_thesis.report.store import Store
from master_thesis.results import palette
from master_thesis.results.figures import svg
from master_thesis.results.from_above import SOLID
from master_thesis.worlds.floor_plan import outlines
from master_thesis.worlds.scenario import FLIGHT_HEIGHT_M
from simulation_tools.sdf.parser import load_world

LEAST_MS = 0.005
"""The foot of the picture's logarithmic scale; the thesis's "~ 0" stands there."""
STEADY = 1.25
"""Times are steady when the greatest is no more than this many times the least; the thesis's: 1.19."""
HUGE = 3.0
"""The least reduction that the thesis calls huge: 17.0 to 5.1 ms in its forest."""
ORDER = "the scenarios in the order of their times"

Flights = Mapping[tuple, Sequence[dict]]
"""Numbers of the flights by (scenario, algorithm)."""


def section(size: Size, store: Store) -> Section:
    """Return the section, from what is there."""
    flights = flights_of(size, store)
    names = [n for n in size.scenarios if all(flights.get((n, algorithm)) for algorithm in ALGORITHMS)]
    return Section(
        key="experiment_1",
        title="Experiment 1: CEPA's run time",
        reference="8.1, table 8.1, figures 8.1 and 8.2; discussed in 9.1.1",
        method=(
            f"The UAV is sent {size.goal_x_m:g} m straight ahead at 2 m/s through each world "
            f"({', '.join(size.scenarios)}), once with the original and once with the improved CEPA, "
            "which alone keeps it off the obstacles (UST-10LX padded to 1440 beams, 40 scans a second). "
            "CEPA's computation time is the processor time of its thread for one scan, averaged over "
            "the flight, then over the seeds."
        ),
        blocks=_blocks(names, flights),
        findings=findings(names, flights),
        parameters=f"seeds {', '.join(map(str, size.seeds))}; goal {size.goal_x_m:g} m ahead",
    )


def flights_of(size: Size, store: Store) -> Flights:
    """Return the flights that are there."""
    found: dict = {}
    for name in size.scenarios:
        for algorithm in ALGORITHMS:
            done = (store.get(piece(size, name, algorithm, seed)) for seed in size.seeds)
            found[name, algorithm] = [flight.numbers for flight in done if flight is not None]
    return found


def _blocks(names: Sequence[str], flights: Flights) -> list[Block]:
    if not names:
        return []
    times = {key: _mean_and_spread(values) for key, values in flights.items() if values}
    chart = Picture(
        svg(times_figure(times)),
        "Computation time per scan, on a logarithmic scale: outlined the thesis's, filled ours.",
        "Bars of the mean computation time for each scenario and algorithm",
        "Table 8.1",
        thesis_words="Time it takes the two CEPA versions to complete its calculations.",
    )
    return [_table_8_1(names, flights), chart, *_views(names, flights), _truth(names, flights)]


def _table_8_1(names: Sequence[str], flights: Flights) -> Table:
    rows = [
        (f"thesis: {algorithm}", *(number(thesis.TABLE_8_1_MS[algorithm][n], 1) for n in names))
        for algorithm in ALGORITHMS
    ]
    rows[1:1] = [("ours: original", *(spread(_all(flights, n, "original"), 3) for n in names))]
    rows.append(("ours: improved", *(spread(_all(flights, n, "improved"), 3) for n in names)))
    rows.append(("thesis: original / improved", *(_their_ratio(n) for n in names)))
    rows.append(("ours: original / improved", *(f"{ratio(flights, n):.0f}" for n in names)))
    count = len(flights[names[0], "original"])
    return Table(
        "Table 8.1: mean computation time per scan, ms",
        ("", *names),
        rows,
        emphasis=(1, 3, 5),
        theirs=(0, 2, 4),
        note=f"Ours: mean and standard deviation over {counted(count, 'flight')} of each. “~ 0” of the "
        "thesis stands as 0.0.",
    )


def _their_ratio(name: str) -> str:
    improved = thesis.TABLE_8_1_MS["improved"][name]
    return f"{thesis.TABLE_8_1_MS['original'][name] / improved:.0f}" if improved else "not given"


def _truth(names: Sequence[str], flights: Flights) -> Table:
    rows = []
    for name in names:
        for algorithm in ALGORITHMS:
            flown = flights[name, algorithm]
            clearances = [f["clearance_m"] for f in flown if f["clearance_m"] is not None]
            rows.append(
                (
                    f"{name}, {algorithm}",
                    f"{sum(f['reached_goal'] for f in flown)} of {len(flown)}",
                    str(sum(f["collision"] for f in flown)),
                    number(min(clearances), 2) if clearances else "nothing near",
                    spread([f["flight_time_s"] for f in flown], 1),
                    spread([f["path_length_m"] for f in flown], 1),
                    spread([f["directions"] for f in flown], 0),
                    number(max(f["computation_p99_ms"] for f in flown), 2),
                    spread([f["emergencies"] for f in flown], 1),
                )
            )
    header = (
        "",
        "reached the goal",
        "collisions",
        "least clearance, m",
        "time, s",
        "way, m",
        "directions tested",
        "worst p99, ms",
        "scans in emergency",
    )
    return Table(
        "What the thesis does not give: how the flights went, by the ground truth",
        header,
        rows,
        note="Clearance: from the UAV's shape to the nearest obstacle, along the true path, least of "
        "all flights.",
    )


# -- what agrees --------------------------------------------------------------------------------------------


def findings(names: Sequence[str], flights: Flights) -> list[Finding]:
    """Return the thesis's statements beside our numbers."""
    if not names:
        return []
    found = [_reduction(names, flights)]
    if len(names) > 1:
        found.append(_stable(names, flights))
    if "empty" in names:
        found.append(_one_test(flights))
    if "empty" in names and len(names) > 1:
        found += [_fastest_in_the_empty_world(names, flights), _clutter(names, flights)]
    if set(names) == set(thesis.SCENARIO_FIGURES):
        found.append(_order(names, flights))
    return [*found, _in_time(names, flights), _untouched(names, flights)]


def _reduction(names: Sequence[str], flights: Flights) -> Finding:
    ratios = {name: ratio(flights, name) for name in names}
    least = min(ratios.values())
    agrees = least >= HUGE
    slow = listed([name for name, value in ratios.items() if value < HUGE])
    return Finding(
        "“We see a huge reduction in computation time across the board!”",
        "9.1.1",
        f"The original takes {' to '.join(_ends(ratios))} times as long as the improved.",
        agrees,
        "" if agrees else f"In {slow} it is less than the {HUGE:g} times of the thesis's forest.",
    )


def _stable(names: Sequence[str], flights: Flights) -> Finding:
    means = {name: _mean(flights, name, "original") for name in names}
    widest = max(means.values()) / min(means.values())
    theirs = thesis.TABLE_8_1_MS["original"]
    their_widest = max(theirs[n] for n in names) / min(theirs[n] for n in names)
    agrees = widest <= STEADY
    return Finding(
        "“The computation times for the original algorithm is quite stable”",
        "9.1.1",
        f"The slowest scenario takes {widest:.2f} times as long as the fastest (thesis: {their_widest:.2f}).",
        agrees,
        ""
        if agrees
        else f"A direction is given up at the first beam that forbids it, soonest in the {_least(means)}.",
    )


def _fastest_in_the_empty_world(names: Sequence[str], flights: Flights) -> Finding:
    means = {name: _mean(flights, name, "original") for name in names}
    agrees = _least(means) == "empty"
    return Finding(
        "The original saves a little time in the empty world.",
        "9.1.1",
        f"Fastest in {_least(means)}: {min(means.values()):.1f} ms; empty: {means['empty']:.1f} ms.",
        agrees,
        ""
        if agrees
        else "Ours gives up a direction at the first beam that forbids it, so that obstacles save it "
        "time; the thesis's adjusts speeds there instead, which costs time.",
    )


def _one_test(flights: Flights) -> Finding:
    improved, original = (
        np.mean([f["directions"] for f in flights["empty", algorithm]])
        for algorithm in ("improved", "original")
    )
    agrees = improved < 1.5 and original > 1000
    return Finding(
        "In the open, testing v_ref first “reduces the … 1440 tests to 1!”",
        "9.1.1",
        f"Improved: {improved:.2f} directions a scan in the empty world; original: {original:.0f} (every "
        "seen beam at each of four speeds).",
        agrees,
        "" if agrees else "v_ref is not always clear there: the UAV leans, and the lidar sees the ground.",
    )


def _clutter(names: Sequence[str], flights: Flights) -> Finding:
    means = {name: _mean(flights, name, "improved") for name in names}
    agrees = _least(means) == "empty"
    return Finding(
        "“When the environment gets more cluttered, the time it takes for the improved algorithm … "
        "increases”.",
        "9.1.1",
        "Improved: " + ", ".join(f"{name} {value:.3f} ms" for name, value in means.items()) + ".",
        agrees,
        "" if agrees else f"The {_least(means)} took less than the empty world.",
    )


def _order(names: Sequence[str], flights: Flights) -> Finding:
    ours = sorted(names, key=lambda name: _mean(flights, name, "improved"))
    theirs = sorted(names, key=lambda name: thesis.TABLE_8_1_MS["improved"][name])
    agrees = ours == theirs
    return Finding(
        f"Improved, {ORDER}: {' < '.join(theirs)}.",
        "table 8.1",
        f"Ours: {' < '.join(ours)}.",
        agrees,
        ""
        if agrees
        else "The worlds are built after the thesis's pictures, which give no measures: how narrow they "
        "are, and so how often v_ref is not clear, is our choice.",
    )


def _in_time(names: Sequence[str], flights: Flights) -> Finding:
    worst = max(f["computation_p99_ms"] for n in names for f in flights[n, "original"])
    agrees = worst < thesis.SCAN_PERIOD_MS
    return Finding(
        "“The original is still fast enough for a lidar at 40Hz”, which leaves 25 ms.",
        "8.1, 9.1.1",
        f"99 of 100 scans took the original less than {worst:.1f} ms in every flight.",
        agrees,
        "" if agrees else "On this machine, at the load of this run, it was not.",
    )


def _untouched(names: Sequence[str], flights: Flights) -> Finding:
    flown = [f for n in names for f in flights[n, "improved"]]
    touched, late = sum(f["collision"] for f in flown), sum(not f["reached_goal"] for f in flown)
    agrees = not touched and not late
    return Finding(
        "The improved algorithm “will no longer cause collisions”.",
        "9.1.1",
        f"{counted(touched, 'collision')} in {counted(len(flown), 'flight')}; {len(flown) - late} "
        "reached the goal.",
        agrees,
        "" if agrees else "See the table above for which.",
    )


def ratio(flights: Flights, name: str) -> float:
    """Return how many times as long the original takes as the improved."""
    return _mean(flights, name, "original") / _mean(flights, name, "improved")


def _ends(values: Mapping[str, float]) -> list[str]:
    """Return the least and the greatest value; one, where they are written alike."""
    return list(dict.fromkeys(f"{end:.0f}" for end in (min(values.values()), max(values.values()))))


def _all(flights: Flights, name: str, algorithm: str) -> list[float]:
    return [flight["computation_ms"] for flight in flights[name, algorithm]]


def _mean(flights: Flights, name: str, algorithm: str) -> float:
    return float(np.mean(_all(flights, name, algorithm)))


def _mean_and_spread(flown: Sequence[dict]) -> tuple[float, float]:
    times = [flight["computation_ms"] for flight in flown]
    return float(np.mean(times)), float(np.std(times))


def _least(means: Mapping[str, float]) -> str:
    return min(means, key=means.get)


# -- pictures -----------------------------------------------------------------------------------------------


def _views(names: Sequence[str], flights: Flights) -> list[Picture]:
    return [
        Picture(
            svg(_view_figure(name, {a: flights[name, a][0] for a in ALGORITHMS})),
            f"{name}: from above, with the paths of the first seed.",
            f"The world {name} from above with the paths of both algorithms",
            f"Figure {thesis.SCENARIO_FIGURES[name]}",
            thesis.FIGURES[thesis.SCENARIO_FIGURES[name]].caption,
        )
        for name in names
    ]


def times_figure(times: Mapping[tuple, tuple[float, float]]) -> Figure:
    """Draw computation times, the thesis's and ours (mean, spread in ms by scenario and algorithm)."""
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    axes = figure.add_subplot()
    names, width = list(dict.fromkeys(name for name, _ in times)), 0.2
    places = np.arange(len(names))
    columns = [(whose, algorithm) for algorithm in thesis.TABLE_8_1_MS for whose in ("thesis", "ours")]
    for column, (whose, algorithm) in enumerate(columns):
        theirs = thesis.TABLE_8_1_MS[algorithm]
        means = [theirs[n] or LEAST_MS if whose == "thesis" else times[n, algorithm][0] for n in names]
        colour = palette.ALGORITHMS[algorithm]
        bars = axes.bar(
            places + (column - 1.5) * width,
            means,
            width,
            yerr=None if whose == "thesis" else [times[n, algorithm][1] for n in names],
            capsize=2,
            facecolor="white" if whose == "thesis" else colour,
            edgecolor=colour,
            lw=1.2,
            label=f"{algorithm}, {whose}",
        )
        labels = [f"{mean:.2g}" if mean > LEAST_MS else "~ 0" for mean in means]
        axes.bar_label(bars, labels, fontsize=6.5, padding=2)
    axes.set_yscale("log")
    axes.set_ylim(LEAST_MS, 100.0)
    axes.set_xticks(places, names)
    axes.set_ylabel("mean computation time [ms]", fontsize=8)
    axes.tick_params(labelsize=8)
    axes.legend(fontsize=7, ncol=4, frameon=False, loc="upper center")
    return figure


def _view_figure(name: str, flown: Mapping[str, dict]) -> Figure:
    paths = {algorithm: np.array(flight["path_xy"]) for algorithm, flight in flown.items()}
    points = np.concatenate(list(paths.values()))
    margin = np.array((2.0, 4.0))
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    width, height = high - low
    figure = Figure(figsize=(7.2, 6.6 * height / width + 0.75), layout="constrained")
    axes = figure.add_subplot()
    solid = [o for o in outlines(load_world(str(WORLDS / f"{name}.world"))) if o.blocks(FLIGHT_HEIGHT_M)]
    patches = [Polygon(o.outline_xy, closed=True) for o in solid if len(o.outline_xy) > 2]
    axes.add_collection(PatchCollection(patches, facecolor=SOLID, edgecolor="black", linewidth=0.3))
    for algorithm, (line, dashes) in {"original": (2.4, (0, (4, 1.5))), "improved": (1.5, "-")}.items():
        colour = palette.ALGORITHMS[algorithm]
        axes.plot(*paths[algorithm].T, color=colour, lw=line, ls=dashes, label=algorithm)
        places = np.array(flown[algorithm]["emergencies_xy"]).reshape(-1, 2)
        if len(places):
            axes.plot(*places.T, "x", ms=5, mew=1.2, color=colour, label=f"{algorithm}: emergency", zorder=6)
    axes.plot(*points[0], "o", ms=5, mfc="white", mec="black", zorder=7)
    axes.plot(*paths["improved"][-1], "*", ms=10, mfc="white", mec="black", zorder=7)
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_xlabel("x [m]", fontsize=8)
    axes.set_ylabel("y [m]", fontsize=8)
    axes.tick_params(labelsize=7)
    figure.legend(
        *axes.get_legend_handles_labels(), fontsize=7, frameon=False, ncol=4, loc="outside lower center"
    )
    return figure
