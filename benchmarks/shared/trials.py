"""Runs the trials of a benchmark in processes and keeps them, so that an interrupted benchmark can go on."""

from __future__ import annotations

import argparse
import itertools
import os
from typing import Any, Callable, Iterable, NoReturn, Sequence

from benchmarks.shared.results import options
from flights.trials.run import run_trials
from flights.trials.store import Store
from flights.trials.trial import Trial, several_versions
from flights.trials.workers import count, end, interrupted, open_workers

AGAIN = "call again with --resume to go on."


def trial_options(description: str) -> argparse.ArgumentParser:
    """Return a parser with the options of every benchmark that runs trials."""
    parser = options(description)
    parser.add_argument("--workers", type=count, default=os.cpu_count(), metavar="N", help="processes")
    parser.add_argument("--resume", action="store_true", help="go on from an interrupted or failed run")
    return parser


def run_all(name: str, trials: Sequence[Trial], given: argparse.Namespace) -> list[Any]:
    """Run trials, and return their results in order. given: the options; NAME_trials.jsonl keeps the trials.

    If some trials fail, or after Ctrl-C, it ends the process with a sentence.
    """
    try:
        path = given.results / f"{name}_trials.jsonl"
        with Store(path, fresh=not given.resume) as store, open_workers(given.workers) as workers:
            failed = run_trials(trials, store, workers, name)
            rows = [row for row in map(store.get, trials) if row is not None]
    except KeyboardInterrupt:
        end_interrupted()
    if failed:
        raise SystemExit(f"{len(failed)} of {len(trials)} trials failed; {AGAIN}")
    print(several_versions(rows) or "")
    return [row.result for row in rows]


def run_crossed(
    name: str, run: Callable[..., Any], given: argparse.Namespace, /, **axes: Iterable[Any]
) -> dict[tuple, Any]:
    """Run a function with every combination of its arguments' values; return the results by combination."""
    combinations = list(itertools.product(*axes.values()))
    trials = [Trial(" ".join(map(str, values)), run, dict(zip(axes, values))) for values in combinations]
    return dict(zip(combinations, run_all(name, trials, given)))


def end_interrupted() -> NoReturn:
    """End the process after Ctrl-C."""
    end(interrupted(f"\nInterrupted; {AGAIN}"))
