"""How often gridslam takes one place for another that looks alike: a hundred seeded worlds.

Rows of equal rooms, parallel corridors, and halls with the same beam every few metres; lidars of 5.6 to 10 m
and odometry that drifts. A closure is false if it is wrong by more than a metre or 0.3 rad: the next room,
corridor or beam is at least 2.5 m away. Keys: slam.repeated.{worlds, closures, false_closures,
closure_error_max_m}.
"""

from __future__ import annotations

import sys
from typing import Sequence

import numpy as np
from tqdm import tqdm

from benchmarks.shared.results import ROOT, Results, options, table

sys.path.append(str(ROOT / "src/gridslam/test"))

from repeated_worlds import closure_errors, world

FALSE_M, FALSE_RAD = 1.0, 0.3


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print and write."""
    parser = options(__doc__)
    parser.add_argument("--worlds", type=int, default=100, metavar="NUMBER", help="seeds 0 to NUMBER - 1")
    given = parser.parse_args(arguments)
    with Results("slam_repeated", given.results, vars(given)) as results:
        errors: dict[str, list[np.ndarray]] = {}
        for seed in tqdm(range(given.worlds), "worlds"):
            errors.setdefault(world(seed).name, []).append(closure_errors(seed))
        rows = [(name, len(each), *summary(np.concatenate(each))) for name, each in errors.items()]
        closures, false, worst_m = summary(np.concatenate([one for each in errors.values() for one in each]))
        values = {"worlds": given.worlds, "closures": closures, "false_closures": false}
        results.add("slam.repeated", {**values, "closure_error_max_m": worst_m})
        print(table(("kind", "worlds", "closures", "false", "greatest error, m"), rows))


def summary(errors: np.ndarray) -> tuple[int, int, float]:
    """Return the number of closures, that of false ones, and the greatest error (m) of errors (n, 2)."""
    false = (errors[:, 0] > FALSE_M) | (errors[:, 1] > FALSE_RAD)
    return len(errors), int(false.sum()), float(errors[:, 0].max(initial=0.0))


if __name__ == "__main__":
    main()
