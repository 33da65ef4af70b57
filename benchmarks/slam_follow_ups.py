"""What the thesis proposes after its maps of the hold (9.1.2), tried: middle, starting map, frequency, level.

- The TiM with the 15 m of the thesis's text, on the round trip and down the middle of the hold.
- The URG with a starting map: the one that the UTM made on a flight of its own.
- The UST with one of every so many scans: does the frequency matter?
- The M8, which sees the floor when the UAV leans, with and without levelling of its scans.

Without loop closure, which would hide the differences; otherwise as `slam_experiments`. Keys:
slam.follow_ups.CASE; and results/slam_follow_ups.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

from benchmarks.shared.results import Results, table
from benchmarks.shared.trials import run_crossed, trial_options
from benchmarks.slam_experiments import SEEDS
from flights.files import replace_file
from flights.mapping.mapping_flight import SCENARIOS, fly_and_record, parameters_of
from flights.mapping.slam_metrics import slam_metrics_of
from flights.mapping.slam_run import SlamRun, replay, true_path, true_walls
from flights.mapping.slam_setup import read_setup
from gridslam.evaluation import Walls
from gridslam.trajectory import Trajectory
from gridslam.warm_up import warm_up
from master_thesis.experiments_3_4.map_variants import medians

BRIEF_SEEDS = (1,)
METRICS = {
    "ate_rmse_m": ("ATE [m]", 3),
    "map_error_mean_m": ("map error [m]", 3),
    "map_error_p95_m": ("95 % [m]", 3),
    "wall_straightness_rms_m": ("bent by, rms [m]", 3),
    "wall_seen_share": ("wall seen", 2),
}


@dataclass(frozen=True)
class Case:
    """A flight, and the settings of SLAM. every: SLAM uses one of this many scans."""

    name: str
    lidar: str
    scenario: str = "hold"
    range_max_m: float = 0.0
    every: int = 1
    levelling: bool = True
    mapped_before_by: str = ""

    def __str__(self) -> str:
        return self.name


CASES = (
    Case("tim_15m_round_trip", "tim", range_max_m=15.0),
    Case("tim_15m_middle", "tim", "hold_middle", range_max_m=15.0),
    Case("urg", "urg"),
    Case("urg_with_starting_map", "urg", mapped_before_by="utm"),
    *(Case(f"ust_{40 // every}hz", "ust", every=every) for every in (1, 2, 4, 8, 20, 40)),
    Case("m8_levelled", "m8"),
    Case("m8_not_levelled", "m8", levelling=False),
)


def main(arguments: Sequence[str] | None = None) -> None:
    """Fly, map, print and write."""
    parser = trial_options(__doc__ or "")
    names = tuple(case.name for case in CASES)
    parser.add_argument("--seeds", nargs="+", type=int, default=None)
    parser.add_argument("--cases", nargs="+", default=names, choices=names)
    given = parser.parse_args(arguments)
    seeds = given.seeds or (BRIEF_SEEDS if given.brief else SEEDS)
    cases = [case for case in CASES if case.name in given.cases]
    with Results("slam_follow_ups", given.results, vars(given)) as results:
        found = run_crossed("slam_follow_ups", fly_and_map, given, case=cases, seed=seeds)
        middle = {case.name: medians([found[case, seed] for seed in seeds]) for case in cases}
        for name, metrics in middle.items():
            results.add(f"slam.follow_ups.{name}", metrics)
        text = as_markdown(middle, len(seeds))
        replace_file(given.results / "slam_follow_ups.md", text)
        print(f"\n{text}")


def fly_and_map(case: Case, seed: int) -> dict:
    """Fly a case once; return its map's metrics."""
    warm_up()
    run, truth, walls = _mapped(case, seed)
    metrics, _, _ = slam_metrics_of(run, truth, walls)
    cpu_ms = metrics.pop("cpu_ms_per_scan")
    return {**metrics, "cpu_ms": cpu_ms["mean"] if cpu_ms else None}


def _mapped(case: Case, seed: int) -> tuple[SlamRun, Trajectory, Walls]:
    scenario = SCENARIOS[case.scenario]
    parameters = parameters_of(case.scenario, case.lidar, seed, lidar_range_max_m=case.range_max_m)
    recording = fly_and_record(f"{case.name}, seed {seed}", parameters).one_of(case.every)
    before = None
    if case.mapped_before_by:  # another flight, so another seed
        before = _mapped(Case("before", case.mapped_before_by, case.scenario), seed + 1000)[0].grid
    session = read_setup(scenario.world).session(seed, loop_closure=False, starting_map=before)
    run = replay(recording, session, case.levelling)
    truth = true_path(recording.times_s, recording.truth)
    walls = true_walls(str(scenario.world_path), scenario.flight_height_m, scenario.start_xyz_yaw[:2])
    return run, truth, walls


def as_markdown(middle: dict, seeds: int) -> str:
    """Return the table of the cases."""
    header = ("case", *(heading for heading, _ in METRICS.values()))
    rows = [
        (name, *(f"{metrics[key]:.{digits}f}" for key, (_, digits) in METRICS.items()))
        for name, metrics in middle.items()
    ]
    return f"Medians over {seeds} seeds, without loop closure.\n\n{table(header, rows)}\n"


if __name__ == "__main__":
    main()
