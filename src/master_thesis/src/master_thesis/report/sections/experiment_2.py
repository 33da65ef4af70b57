"""Experiment 2 on the page: figures 8.3 to 8.7, and flights after the proposals."""

from __future__ import annotations

import math
from typing import Callable, Mapping, Sequence

from master_thesis.experiment_2.variations import Flown
from master_thesis.experiment_2.variations import variations_metrics as summary
from master_thesis.experiment_2.variations_pictures import Paths, paths_figure
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
    resting_on,
)
from master_thesis.report.pieces.experiment_2 import (
    PATH_STEP,
    WITH_SWEEP,
    flights_piece,
    pieces,
    proposals_piece,
)
from master_thesis.report.size import Size
from master_thesis.results.picture_files import svg
from master_thesis.trials.store import Store
from master_thesis.trials.trial import Row
from master_thesis.worlds.placements import R_LB_M, placement

FIGURES = {"columns": "8.3", "wall_one_column": "8.6", "wall_three_columns": "8.7"}
SAME_DEG = 1.0
"""Arrows that differ by less look identical."""
SHAPE_GROWTH = 1.25
"""The figure has lost its shape if this many times more directions seem blocked than with the highest K."""

Sets = Mapping[tuple, Sequence[Flown]]
"""Flights by (scenario, algorithm)."""


def section(size: Size, store: Store) -> Section:
    """Return the section of the pieces that are there."""
    proposals = {
        scenario: done
        for scenario in size.emergencies
        for done in [store.get(proposals_piece(scenario))]
        if done is not None
    }
    sets = sets_of(size, store)
    numbers = {scenario: done.result for scenario, done in proposals.items()}
    blocks: list[Block] = []
    for scenario, done in proposals.items():
        blocks += _pictures(scenario, done)
    if sets:
        blocks += [_paths(sets), _outcomes(sets)]
    return Section(
        key="experiment_2",
        title="Experiment 2: emergency avoidance",
        reference="8.1, figures 8.3 to 8.7; discussed in 9.1.1",
        method=(
            "The UAV hovers at 2 m, time is stopped, obstacles are put around it within r_LB, and time "
            "goes on: the pictures show what both algorithms propose for the first scan after that. "
            "Then the UAV is let go for 15 s with one of them, in "
            f"{counted(size.placements, 'variation')} of each placement (every obstacle shifted by up to "
            "5 cm along x and y)."
        ),
        blocks=blocks,
        findings=findings(numbers, sets),
        parameters=f"{counted(size.placements, 'variation')} of each placement, seed by seed; r_LB "
        f"{R_LB_M:g} m; K 50 m/rad unless varied",
    )


def sets_of(size: Size, store: Store) -> dict[tuple, list[Flown]]:
    """Return the flights that are there."""
    found: dict = {}
    for piece in pieces(size):
        if "algorithm" not in piece.given:
            continue
        done = store.get(flights_piece(**piece.given))
        for flight in done.result["flights"] if done else ():
            flown = Flown.of(flight)
            found.setdefault((flown.scenario, flown.algorithm), []).append(flown)
    return found


def _pictures(scenario: str, done: Row) -> list[Picture]:
    figure = FIGURES[scenario]
    pictures = [
        Picture(
            done.result["pictures"]["proposals"].encode(),
            f"{_words(scenario)}: (a) what stands around the UAV, (b) what the algorithms propose.",
            "The obstacles from above, and the velocities that both algorithms propose as arrows",
            f"Figure {figure}",
            thesis.FIGURES[figure].caption,
            wide=True,
        )
    ]
    if scenario == WITH_SWEEP:
        pictures.append(
            Picture(
                done.result["pictures"]["sweep"].encode(),
                "The same scan through the filter with eight K.",
                "Eight panels: the lower K, the more directions the intrusions fill",
                "Figures 8.4 and 8.5",
                f"{thesis.FIGURES['8.4'].caption} {thesis.FIGURES['8.5'].caption}",
                wide=True,
            )
        )
    return pictures


def _paths(sets: Sets) -> Picture:
    shown = {key: Paths.of(placement(key[0]), flights) for key, flights in sets.items()}
    return Picture(
        svg(paths_figure(shown)),
        f"Let go: the paths of all flights (every {PATH_STEP}th pose), ahead is upwards.",
        "Paths from above, for each placement and algorithm, with the places of contacts",
        "Figures 8.6 and 8.7",
        "The thesis shows arrows only; where they lead is not flown there.",
        wide=True,
    )


def _outcomes(sets: Sets) -> Table:
    rows = []
    for (scenario, algorithm), flights in sets.items():
        values = summary(flights)
        rows.append(
            (
                f"{_words(scenario)}, {algorithm}",
                str(values["flights"]),
                str(values["touched"]),
                str(values["left"]),
                number(values["left_after_s"], 1),
                number(max(values["min_clearance_m"], 0.0), 3),
                number(max(values["median_clearance_m"], 0.0), 3),
            )
        )
    header = ("", "flights", "touched", "got out", "after, s", "least clearance, m", "median, m")
    return Table(
        "What the thesis does not give: what comes of the arrows",
        header,
        rows,
        note="Got out: no emergency in the last second. Clearance 0: contact.",
    )


# -- what agrees --------------------------------------------------------------------------------------------


def findings(proposals: Mapping[str, dict], sets: Sets) -> list[Finding]:
    """Return the thesis's statements beside our numbers. proposals: of each placement as it is."""
    found = []
    if "columns" in proposals:
        found.append(_shape(proposals["columns"]["sweep"]))
    if "wall_one_column" in proposals:
        found.append(_identical(proposals["wall_one_column"]["proposals"]))
    if "wall_three_columns" in proposals:
        found.append(_different(proposals["wall_three_columns"]["proposals"]))
    if ("wall_one_column", "original") in sets:
        found += _counted(_harmless, sets["wall_one_column", "original"])
    if ("wall_three_columns", "original") in sets:
        found += _counted(_crashes, sets["wall_three_columns", "original"])
    improved = [
        flight for (_, algorithm), flights in sets.items() if algorithm == "improved" for flight in flights
    ]
    if improved:
        found += _counted(_saved, improved)
    return found


def _counted(judge: Callable[[Sequence[Flown]], Finding], flights: Sequence[Flown]) -> list[Finding]:
    return resting_on([judge(flights)], len(flights), "flight")


def _shape(sweep: Sequence[dict]) -> Finding:
    by_k = sorted(sweep, key=lambda each: each["k_filter"])
    low, high = by_k[0], by_k[-1]
    growth = low["intruding_share"] / high["intruding_share"]
    first = next(
        (
            e["k_filter"]
            for e in reversed(by_k)
            if e["intruding_share"] > SHAPE_GROWTH * high["intruding_share"]
        ),
        None,
    )
    begins = f" Effects begin near K = {first:g} m/rad." if first is not None else ""
    return Finding(
        "“With low enough Ks the figure starts to loose its shape.”",
        "figure 8.5",
        f"At K = {low['k_filter']:g} m/rad {100 * low['intruding_share']:.0f} % of all directions seem "
        f"blocked within r_LB, at K = {high['k_filter']:g} m/rad {100 * high['intruding_share']:.0f} "
        f"%.{begins}",
        growth > SHAPE_GROWTH,
        "The K tried here are not low enough.",
    )


def _identical(proposed: dict) -> Finding:
    apart = angle_deg(proposed["original_xy"], proposed["improved_xy"])
    return Finding(
        "Wall and one column: “the original does not cause a collision in this scenario the arrows are "
        "identical”.",
        "figure 8.6",
        f"The arrows point {apart:.1f}° apart.",
        apart < SAME_DEG,
        "The improved algorithm judged the original's way as too narrow for its body.",
    )


def _different(proposed: dict) -> Finding:
    apart = angle_deg(proposed["original_xy"], proposed["improved_xy"])
    return Finding(
        "Wall and three columns: the improved algorithm proposes another way than the original.",
        "figure 8.7",
        f"The arrows point {apart:.0f}° apart.",
        apart >= SAME_DEG,
        "The original's way was free for the body of the UAV here.",
    )


def _harmless(flights: Sequence[Flown]) -> Finding:
    touched = _touched(flights)
    return Finding(
        "Wall and one column: the original causes no collision.",
        "figure 8.6",
        f"It touched in {touched} of {len(flights)} variations.",
        touched == 0,
        "An arrow is not a flight: the UAV needs time to follow it, and drifts meanwhile.",
    )


def _crashes(flights: Sequence[Flown]) -> Finding:
    touched, refused = _touched(flights), sum(flight.proposal_refused for flight in flights)
    return Finding(
        "Wall and three columns: the original “would have caused the UAV to crash into the columns”.",
        "figure 8.7",
        f"It touched in {touched} of {len(flights)} variations; in {refused} the way that it proposes is "
        "too narrow for the UAV.",
        2 * touched > len(flights),
        "An arrow is not a flight: once the UAV is near the columns, they push it back before it touches.",
    )


def _saved(flights: Sequence[Flown]) -> Finding:
    touched, values = _touched(flights), summary(flights)
    stuck = values["flights"] - values["left"]
    scenarios = sorted({f.scenario for f in flights if f.metrics["collision"] or not f.metrics["left"]})
    return Finding(
        "The improved emergency avoidance “finds a safe escape”, and causes no collision anywhere.",
        "figure 8.7, 9.1.1",
        f"It touched in {touched} of {len(flights)} flights and got out in {values['left']}; least "
        f"clearance {max(values['min_clearance_m'], 0.0):.2f} m.",
        touched == 0 and stuck == 0,
        f"Not so in {listed([_words(name) for name in scenarios])}.",
    )


def _touched(flights: Sequence[Flown]) -> int:
    return sum(flight.metrics["collision"] for flight in flights)


def angle_deg(first_xy: Sequence[float], second_xy: Sequence[float]) -> float:
    """Return the angle between two velocities, 0 to 180 degrees."""
    turn = math.atan2(first_xy[1], first_xy[0]) - math.atan2(second_xy[1], second_xy[0])
    return abs(math.degrees(math.remainder(turn, 2.0 * math.pi)))


def _words(scenario: str) -> str:
    return scenario.replace("_", " ")
