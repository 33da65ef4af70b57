"""A campaign of flights through random forests: does CEPA collide, arrive, or get stuck?

Each forest (_campaign.py) is flown by both algorithms in the ROS-free closed loop: the same simulator, flight
controller, lidar and filters as in the graph. The speed goes through 1, 2, 3 and 4 m/s from forest to forest.
The improved algorithm then flies every forest at 2 m/s, where it must never collide, and the mixed speeds
again with each extension that is off by default (velocity-aware emergency, levelling).

Every flight is written to results/avoidance_flights.jsonl as soon as it is over; --resume goes on from there.

Figures: cepa.campaign.{original, improved, improved_VARIANT}.{all, 1_m_s, ...} and
cepa.campaign.improved_at_2_m_s, each with collisions per km and their exact 95 % interval, share stuck and
time to goal; and results/avoidance.png.
"""

from __future__ import annotations

import argparse
import os
from itertools import chain
from typing import Iterable, Sequence

from benchmarks import _campaign, _campaign_figure
from benchmarks._campaign import SPEEDS_M_S, VARIANTS, Flown, Trial
from benchmarks._flown_file import FlownFile, fly_all
from benchmarks._report import ROOT, Report, options, table, write_atomically
from master_thesis.results.sources import commit

SAFE_SPEED_M_S = 2.0
SAFE = f"improved_at_{SAFE_SPEED_M_S:g}_m_s"
BRIEF = {"original": 16, "variants": 40}
"""Flights of what is slow, and of what is flown besides, in a brief run."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    given = _options().parse_args(arguments)
    with Report("avoidance", given.results, vars(given)) as report:
        number = numbers(given)
        file = FlownFile(given.results / "avoidance_flights.jsonl", commit(ROOT), given.resume)
        sets = plan(number)
        fly_all(list(dict.fromkeys(chain.from_iterable(sets.values()))), given.workers, file)
        flown = {name: [file.flown[trial] for trial in trials] for name, trials in sets.items()}
        safe = flown.pop(SAFE)
        parts = {f"{name}.{part}": s for name in flown for part, s in by_speed(flown[name]).items()}
        figures = {name: _campaign.figures(flights) for name, flights in {SAFE: safe, **parts}.items()}
        for name, values in figures.items():
            report.add(f"cepa.campaign.{name}", values)
        write_atomically(given.results / "avoidance.png", _campaign_figure.png(flown))
        print(f"\n{campaign_table(figures)}\n{failures(file.flown.values())}")
        if given.brief:
            print(f"Brief: {number['original']} of {given.flights} forests with the original algorithm.")


def _options() -> argparse.ArgumentParser:
    parser = options(__doc__)
    parser.add_argument("--flights", type=int, default=200, metavar="N", help="forests for each algorithm")
    parser.add_argument("--original", type=int, metavar="N", help="fewer for the original, which is slow")
    parser.add_argument("--variants", type=int, metavar="N", help="fewer with each extension")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), metavar="N", help="processes that fly")
    parser.add_argument("--resume", action="store_true", help="go on from an interrupted run of this commit")
    return parser


def numbers(given: argparse.Namespace) -> dict[str, int]:
    """Return how many flights in mixed speeds each algorithm and each variant is to fly."""
    brief = BRIEF if given.brief else {}

    def fewer(what: str) -> int:
        asked = getattr(given, what)
        return min(given.flights, brief.get(what, given.flights) if asked is None else asked)

    variants = {Trial(0, "improved", 1.0, variant).name: fewer("variants") for variant in VARIANTS if variant}
    return {"improved": given.flights, **variants, "original": fewer("original")}


def plan(number: dict[str, int]) -> dict[str, list[Trial]]:
    """Return the flights of each set: improved at 2 m/s, then each name's in mixed speeds."""
    sets = {SAFE: [Trial(n, "improved", SAFE_SPEED_M_S) for n in range(number["improved"])]}
    for name, count in number.items():
        algorithm, _, variant = name.partition("_")
        sets[name] = [Trial(n, algorithm, SPEEDS_M_S[n % len(SPEEDS_M_S)], variant) for n in range(count)]
    return sets


def by_speed(flown: Sequence[Flown]) -> dict[str, list[Flown]]:
    """Return the flights by name of set: all, and each speed that was flown."""
    sets = {"all": list(flown)}
    for speed in sorted(SPEEDS_M_S):
        at_speed = [flight for flight in flown if flight.trial.speed_m_s == speed]
        if at_speed:
            sets[f"{speed:g}_m_s"] = at_speed
    return sets


def campaign_table(figures: dict[str, dict]) -> str:
    """Return the campaign as a table; time: over that of a straight flight at full speed, median."""
    header = (
        "flights",
        "number",
        "km",
        "collisions",
        "per km",
        "95 %",
        "stuck",
        "time/straight",
        "clearance [m]",
    )
    return table(header, [(name.replace(".", ", "), *_row(values)) for name, values in figures.items()])


def _row(values: dict) -> tuple[str, ...]:
    low, high = values["collisions_per_km_95"]
    longer, clearance = values["time_over_straight"], values["clearance_m"]
    return (
        f"{values['flights']}",
        f"{values['distance_km']:.2f}",
        f"{values['collisions']}",
        f"{values['collisions_per_km']:.2f}",
        f"{low:.2f} to {high:.2f}",
        f"{values['stuck']:.1%}",
        f"{longer:.2f}" if longer else "-",
        f"{clearance['least']:.2f}, median {clearance['median']:.2f}",
    )


def failures(flown: Iterable[Flown]) -> str:
    """Return a line for each flight that did not arrive."""
    lines = [
        f"forest {f.trial.number:3d}, {f.trial.name}, {f.trial.speed_m_s:g} m/s: {f.end} at "
        f"({f.path_xy[-1][0]:.1f}, {f.path_xy[-1][1]:.1f}) m after {f.time_s:.1f} s"
        for f in flown
        if f.end != "goal"
    ]
    return "\n".join(sorted(lines))


if __name__ == "__main__":
    main()
