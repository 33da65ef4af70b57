"""Experiment 1 on the page: table 8.1, the worlds of figures 8.1 and 8.2 with the paths flown."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from flights.results.picture_files import svg
from flights.trials.store import Store
from master_thesis.experiment_1.claim_metrics import Flights, claim_metrics, ratio, times_ms
from master_thesis.experiment_1.pictures import times_figure, view_figure
from master_thesis.experiment_1.pieces import ALGORITHMS, piece
from master_thesis.report import thesis
from master_thesis.report.claims import judged
from master_thesis.report.content import Block, Picture, Section, Table, counted, number, seeds_of, spread
from master_thesis.report.size import Size


def section(size: Size, store: Store) -> Section:
    """Return the section of the pieces that are there."""
    flights = flights_of(size, store)
    names = [n for n in size.scenarios if all(flights.get((n, algorithm)) for algorithm in ALGORITHMS)]
    return Section(
        key="experiment_1",
        title="Experiment 1: CEPA's run time",
        reference="8.1, table 8.1, figures 8.1 and 8.2; discussed in 9.1.1",
        method=(
            f"The UAV is sent {size.goal_x_m:g} m straight ahead at 2 m/s through each world "
            f"({', '.join(size.scenarios)}), once each with the thesis's original and improved CEPA and with "
            "the dynamic one, which came later. CEPA alone keeps it off the obstacles (UST-10LX padded to "
            "1440 beams, 40 scans a second). "
            "CEPA's computation time is the processor time of its thread for one scan, averaged over "
            "the flight, then over the seeds."
        ),
        blocks=_blocks(names, flights),
        findings=judged("experiment_1", claim_metrics(names, flights)),
        parameters=f"{seeds_of(size.seeds)}; goal {size.goal_x_m:g} m ahead",
    )


def flights_of(size: Size, store: Store) -> Flights:
    """Return the flights that are there."""
    found: dict = {}
    for name in size.scenarios:
        for algorithm in ALGORITHMS:
            done = (store.get(piece(size, name, algorithm, seed)) for seed in size.seeds)
            found[name, algorithm] = [flight.result for flight in done if flight is not None]
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
        for algorithm in thesis.TABLE_8_1_MS
    ]
    rows[1:1] = [("ours: original", *(spread(times_ms(flights, n, "original"), 3) for n in names))]
    rows.append(("ours: improved", *(spread(times_ms(flights, n, "improved"), 3) for n in names)))
    rows.append(("thesis: original / improved", *(_their_ratio(n) for n in names)))
    rows.append(("ours: original / improved", *(f"{ratio(flights, n):.0f}" for n in names)))
    rows.append(("ours: dynamic", *(spread(times_ms(flights, n, "dynamic"), 3) for n in names)))
    count = len(flights[names[0], "original"])
    return Table(
        "Table 8.1: mean computation time per scan, ms",
        ("", *names),
        rows,
        emphasis=(1, 3, 5, 6),
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


def _views(names: Sequence[str], flights: Flights) -> list[Picture]:
    return [
        Picture(
            svg(view_figure(name, {a: flights[name, a][0] for a in ALGORITHMS})),
            f"{name}: from above, with the paths of the first seed.",
            f"The world {name} from above with the paths of all algorithms",
            f"Figure {thesis.SCENARIO_FIGURES[name]}",
            thesis.FIGURES[thesis.SCENARIO_FIGURES[name]].caption,
        )
        for name in names
    ]


def _mean_and_spread(flown: Sequence[dict]) -> tuple[float, float]:
    times = [flight["computation_ms"] for flight in flown]
    return float(np.mean(times)), float(np.std(times))
