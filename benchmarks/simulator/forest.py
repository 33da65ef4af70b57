"""Our loop without ROS through Experiment 1's forest, and other simulators in the same minutes."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import Any, Mapping, Sequence

from tqdm import tqdm

from benchmarks.peers.turns import Turns, flies, sentences
from benchmarks.shared.results import table
from benchmarks.shared.speed import Speed, medians, timed
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from master_thesis.experiment_1.scenario_flight import scenario_parameters

OURS = "ours: forest, UST at 40 Hz, CEPA, estimator, MAVLink, PyBullet at 250 Hz"
HEADER = ("simulator", "RTF", "RTF, process", "RTF, wall", "ours by it (asked: > 1)", "ours by it, process")


def fly(seed: int) -> Speed:
    """Fly the forest once. What counts is the way from the start of the course to its goal."""
    with ClosedLoop(scenario_parameters("forest", seed=seed)) as loop:
        loop.run_to(Phase.FLYING)

        def to_the_goal() -> float:
            began_s = loop.time_s
            loop.run_to(Phase.HOVERING)
            return loop.time_s - began_s

        return timed(to_the_goal)


def fly_beside(
    names: Sequence[str], rounds: int, folder: Path, programs: Mapping[str, Path] = MappingProxyType({})
) -> tuple[dict[str, float], dict[str, dict]]:
    """Fly ours and each peer by turns; return our medians, and for each peer its medians or why it has none.

    names, folder, programs: as `Turns`. A peer's figures: rtf, rtf_process, rtf_wall, and ours_by_it and
    ours_by_it_process, our factor divided by its factor. A peer that fails has only `left_out`, a sentence.
    """
    peers = Turns(names, folder, programs)
    ours: list[Speed] = []
    for seed in tqdm(range(1, rounds + 1), "forest"):
        ours.append(fly(seed))
        peers.fly()
    here = medians(ours)
    found = {
        name: figures if "left_out" in figures else _compared(here, figures)
        for name, figures in peers.figures().items()
    }
    return here, found


def peers_table(ours: Mapping[str, float], peers: Mapping[str, Mapping[str, Any]]) -> str:
    """Return ours and the peers as a table; below it a sentence for each that is left out."""
    rows = [(OURS, *_factors(ours), "", "")]
    rows += [
        (flies(name), *_factors(found), f"{found['ours_by_it']:.2f}", f"{found['ours_by_it_process']:.2f}")
        for name, found in peers.items()
        if "left_out" not in found
    ]
    clocks = (
        "RTF: simulated time by the CPU time of the thread that flies, of its whole process, by the wall. "
        "Of PX4 and Gazebo all threads count, and of PX4 our physics, too."
    )
    return "\n\n".join((table(HEADER, rows), clocks, *sentences(peers)))


def _compared(ours: Mapping[str, float], theirs: Mapping[str, float]) -> dict[str, float]:
    ratios = {
        "ours_by_it": ours["rtf"] / theirs["rtf"],
        "ours_by_it_process": ours["rtf_process"] / theirs["rtf_process"],
    }
    return {**theirs, **ratios}


def _factors(found: Mapping[str, float]) -> tuple[str, str, str]:
    return f"{found['rtf']:.1f}", f"{found['rtf_process']:.1f}", f"{found['rtf_wall']:.1f}"
