"""Experiment 2 over and over: does the UAV get out when obstacles appear around it, or does it touch them?

Each scenario of figures 8.3 to 8.7 is flown in 20 small variations of the placement (each obstacle shifted by
up to 5 cm along x and y) by both algorithms, in the ROS-free closed loop: the same simulator, flight
controller, lidar and filters as in the graph. The improved algorithm must never touch.

Figures: cepa.emergency.SCENARIO.ALGORITHM.{flights, touched, left, min_clearance_m, ...}, and
results/emergency.png.
"""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

import numpy as np
from tqdm import tqdm

from benchmarks._emergency_figure import Paths, png
from benchmarks._report import ROOT, Report, options, table, write_atomically
from cepa import CepaParameters
from master_thesis.emergency import report as emergency_report
from master_thesis.emergency.description import TrialDescription, flown, in_freeze_frame
from master_thesis.emergency.let_go import LetGoParameters, let_go
from master_thesis.worlds.placements import R_LB_M, SCENARIOS, placement
from master_thesis.worlds.scenario import ALGORITHMS

WORLD = ROOT / "src/master_thesis/worlds/empty.world"
REFUSED = "emergency open section"
"""The improved algorithm's reason when the original's proposal leads into an obstacle or cancels out."""


@dataclass(frozen=True)
class Flown:
    """What came of one flight.

    proposal_refused: the improved algorithm has another proposal than the original for the first scan.
    path_xy: (n, 2) in the frame of the placement. touch_xy: (2,) where the UAV was at its first contact.
    """

    scenario: str
    algorithm: str
    merit: dict
    proposal_refused: bool
    path_xy: np.ndarray
    touch_xy: np.ndarray | None


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, print and write."""
    parser = options(__doc__)
    parser.add_argument(
        "--variations", type=int, default=20, metavar="N", help="of each scenario's placement"
    )
    parser.add_argument("--K", type=float, default=50.0, help="K of the emergency avoidance's filter, m/rad")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), metavar="N", help="processes that fly")
    given = parser.parse_args(arguments)
    with Report("emergency", given.results, vars(given)) as report:
        flown = fly_all(trials(given.variations, given.K), given.workers)
        sets = {
            (scenario, algorithm): [f for f in flown if (f.scenario, f.algorithm) == (scenario, algorithm)]
            for scenario in SCENARIOS
            for algorithm in ALGORITHMS
        }
        all_figures = {names: figures(flights) for names, flights in sets.items()}
        for names, values in all_figures.items():
            report.add("cepa.emergency." + ".".join(names), values)
        paths = {names: Paths.of(placement(names[0]), flights) for names, flights in sets.items()}
        write_atomically(given.results / "emergency.png", png(paths))
        print(f"\n{emergency_table(all_figures)}")


def trials(variations: int, k_filter: float) -> list[LetGoParameters]:
    """Return every flight; both algorithms meet the same placements and the same noise."""
    parameters = CepaParameters(r_lb=R_LB_M, k_filter=k_filter)
    return [
        LetGoParameters(str(WORLD), scenario, algorithm, variation, seed=variation, cepa=parameters)
        for scenario in SCENARIOS
        for algorithm in ALGORITHMS
        for variation in range(1, variations + 1)
    ]


def fly_all(all_trials: Sequence[LetGoParameters], workers: int) -> list[Flown]:
    """Fly the trials in some processes; the results come in the trials' order."""
    with ProcessPoolExecutor(workers) as pool:
        return list(tqdm(pool.map(fly, all_trials), "flights", len(all_trials), unit=" flights"))


def fly(parameters: LetGoParameters) -> Flown:
    """Fly one trial and measure it."""
    trial = let_go(parameters)
    if trial.failure is not None:
        raise RuntimeError(f"{parameters.scenario}, variation {parameters.variation}: {trial.failure}")
    description = TrialDescription(
        parameters.scenario,
        parameters.algorithm,
        parameters.lidar,
        parameters.seed,
        Path(parameters.world),
        parameters.cepa,
    )
    merit = emergency_report.figures_of_merit(trial, emergency_report.clearances(description, trial))
    poses = flown(trial)
    path_xy = in_freeze_frame(trial, poses[:, 1:4])[:, :2]
    touch = np.searchsorted(poses[:, 0], min(trial.touched.values())) if trial.touched else None
    proposed = emergency_report.proposals_of(description, trial)[0]
    return Flown(
        parameters.scenario,
        parameters.algorithm,
        merit,
        proposed.reason == REFUSED,
        path_xy,
        None if touch is None else path_xy[min(touch, len(path_xy) - 1)],
    )


def figures(flights: Sequence[Flown]) -> dict:
    """Return what the flights of one scenario and algorithm come to."""
    clearances = [flight.merit["min_clearance_m"] for flight in flights]
    left_s = [flight.merit["left_after_s"] for flight in flights if flight.merit["left"]]
    return {
        "flights": len(flights),
        "touched": sum(flight.merit["collision"] for flight in flights),
        "left": len(left_s),
        "left_after_s": float(np.median(left_s)) if left_s else None,
        "min_clearance_m": min(clearances),
        "median_clearance_m": float(np.median(clearances)),
        "original_proposal_refused": sum(flight.proposal_refused for flight in flights),
    }


def emergency_table(all_figures: dict[tuple[str, str], dict]) -> str:
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
        for names, values in all_figures.items()
    ]
    return table(header, rows)


if __name__ == "__main__":
    main()
