"""Experiment 2 in variations: does the UAV escape from obstacles around it, or does it touch them?

Each scenario of figures 8.3 to 8.7 is flown in 20 small variations of the placement (each obstacle shifted by
up to 5 cm along x and y) by both algorithms, in the ROS-free closed loop: the same simulator, flight
controller, lidar and filters as in the graph. The improved algorithm must never touch.

Keys: cepa.emergency.SCENARIO.ALGORITHM.{flights, touched, left, min_clearance_m, ...}, and
results/emergency.png.
"""

from __future__ import annotations

import argparse
from typing import Sequence

from benchmarks.shared.results import Results, table
from benchmarks.shared.trials import run_crossed, trial_options
from flights.files import replace_file
from flights.results.picture_files import png
from flights.worlds.placements import SCENARIOS, placement
from flights.worlds.scenario import THESIS_ALGORITHMS
from master_thesis.experiment_2.variations import (
    Flown,
    fly_variation,
    variation_parameters,
    variations_metrics,
)
from master_thesis.experiment_2.variations_pictures import Paths, paths_figure


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    parser = trial_options(__doc__ or "")
    parser.add_argument(
        "--variations", type=int, default=20, metavar="N", help="variations of each scenario's placement"
    )
    parser.add_argument("--K", type=float, default=50.0, help="K of the emergency avoidance's filter, m/rad")
    given = parser.parse_args(arguments)
    with Results("emergency", given.results, vars(given)) as results:
        sets = fly_all(given)
        all_metrics = {names: variations_metrics(flights) for names, flights in sets.items()}
        for names, values in all_metrics.items():
            results.add("cepa.emergency." + ".".join(names), values)
        paths = {names: Paths.of(placement(names[0]), flights) for names, flights in sets.items()}
        replace_file(given.results / "emergency.png", png(paths_figure(paths)))
        print(f"\n{emergency_table(all_metrics)}")


def fly_all(given: argparse.Namespace) -> dict[tuple[str, str], list[Flown]]:
    """Return the flights by scenario and algorithm. Both get the same placements and the same noise."""
    axes = {
        "scenario": SCENARIOS,
        "algorithm": THESIS_ALGORITHMS,
        "variation": range(1, given.variations + 1),
        "k_filter": (given.K,),
    }
    sets: dict = {}
    for (scenario, algorithm, *_), found in run_crossed("emergency", fly, given, **axes).items():
        sets.setdefault((scenario, algorithm), []).append(Flown.of(found))
    return sets


def fly(scenario: str, algorithm: str, variation: int, k_filter: float) -> Flown:
    """Fly one variation of a placement."""
    return fly_variation(variation_parameters(scenario, algorithm, variation, k_filter))


def emergency_table(all_metrics: dict[tuple[str, str], dict]) -> str:
    """Return the campaign as a table."""
    header = (
        "scenario, algorithm",
        "flights",
        "touched",
        "left",
        "after [s]",
        "least clearance [m]",
        "median",
    )
    rows = [
        (
            ", ".join(names).replace("_", " "),
            values["flights"],
            values["touched"],
            values["left"],
            "-" if values["left_after_s"] is None else f"{values['left_after_s']:.1f}",
            f"{max(values['min_clearance_m'], 0.0):.3f}",
            f"{max(values['median_clearance_m'], 0.0):.3f}",
        )
        for names, values in all_metrics.items()
    ]
    return table(header, rows)


if __name__ == "__main__":
    main()
