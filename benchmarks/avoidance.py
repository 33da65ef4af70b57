"""A campaign of flights through random forests: does CEPA collide, arrive, or get stuck?

Each forest (_campaign.py) is flown by both algorithms in the ROS-free closed loop: the same simulator, flight
controller, lidar and filters as in the graph. The speed goes through 1, 2, 3 and 4 m/s from forest to forest.
The improved algorithm then flies every forest at 2 m/s, where it must never collide.

Figures: cepa.campaign.ALGORITHM.{all, 1_m_s, ...} and cepa.campaign.improved_at_2_m_s, each with collisions
per km and their exact 95 % interval, share stuck and time to goal; and results/avoidance.png.
"""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from typing import Sequence

from tqdm import tqdm

from benchmarks import _campaign, _campaign_figure
from benchmarks._campaign import SPEEDS_M_S, Flown, Trial
from benchmarks._report import Report, options, table, write_atomically

SAFE_SPEED_M_S = 2.0


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    parser = options(__doc__)
    parser.add_argument("--flights", type=int, default=200, metavar="N", help="forests for each algorithm")
    parser.add_argument("--original", type=int, metavar="N", help="fewer for the original, which is slow")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), metavar="N", help="processes that fly")
    given = parser.parse_args(arguments)
    with Report("avoidance", given.results, vars(given)) as report:
        # The slow flights first, so that the workers end together
        number = {"original": min(given.original or given.flights, given.flights), "improved": given.flights}
        flown = fly_all(trials(number), given.workers)
        mixed = {
            name: [f for f in flown[: sum(number.values())] if f.trial.algorithm == name] for name in number
        }
        safe = [f for f in flown if f.trial.algorithm == "improved" and f.trial.speed_m_s == SAFE_SPEED_M_S]
        sets = {f"{name}.{part}": s for name in mixed for part, s in by_speed(mixed[name]).items()}
        sets[f"improved_at_{SAFE_SPEED_M_S:g}_m_s"] = safe
        figures = {name: _campaign.figures(flights) for name, flights in sets.items()}
        for name, values in figures.items():
            report.add(f"cepa.campaign.{name}", values)
        write_atomically(given.results / "avoidance.png", _campaign_figure.png(mixed))
        print(f"\n{campaign_table(figures)}\n{failures(flown)}")


def trials(number: dict[str, int]) -> list[Trial]:
    """Return the flights: each algorithm's in mixed speeds, then improved where 2 m/s is missing."""
    speeds = [SPEEDS_M_S[n % len(SPEEDS_M_S)] for n in range(max(number.values()))]
    mixed = [Trial(n, name, speeds[n]) for name, count in number.items() for n in range(count)]
    missing = (n for n in range(number["improved"]) if speeds[n] != SAFE_SPEED_M_S)
    return mixed + [Trial(n, "improved", SAFE_SPEED_M_S) for n in missing]


def fly_all(all_trials: Sequence[Trial], workers: int) -> list[Flown]:
    """Fly the trials in some processes; the results come in the trials' order."""
    with ProcessPoolExecutor(workers) as pool:
        return list(tqdm(pool.map(_campaign.fly, all_trials), "flights", len(all_trials), unit=" flights"))


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


def failures(flown: Sequence[Flown]) -> str:
    """Return a line for each flight that did not arrive."""
    lines = [
        f"forest {f.trial.number}, {f.trial.algorithm}, {f.trial.speed_m_s:g} m/s: {f.end} at "
        f"({f.path_xy[-1][0]:.1f}, {f.path_xy[-1][1]:.1f}) m after {f.time_s:.1f} s"
        for f in flown
        if f.end != "goal"
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
