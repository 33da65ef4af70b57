"""Experiment 2 on the page: figures 8.3 to 8.7, and flights after the proposals."""

from __future__ import annotations

from flights.results.picture_files import svg
from flights.trials.store import Store
from flights.trials.trial import Row
from flights.worlds.placements import R_LB_M, placement
from master_thesis.experiment_2.claim_metrics import Sets, claim_metrics
from master_thesis.experiment_2.pieces import PATH_STEP, WITH_SWEEP, flights_piece, pieces, proposals_piece
from master_thesis.experiment_2.variations import Flown
from master_thesis.experiment_2.variations import variations_metrics as summary
from master_thesis.experiment_2.variations_pictures import Paths, paths_figure
from master_thesis.report import thesis
from master_thesis.report.claims import judged
from master_thesis.report.content import Block, Picture, Section, Table, counted, number
from master_thesis.report.size import Size

FIGURES = {"columns": "8.3", "wall_one_column": "8.6", "wall_three_columns": "8.7"}


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
        findings=judged("experiment_2", claim_metrics(numbers, sets)),
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


def _words(scenario: str) -> str:
    return scenario.replace("_", " ")
