"""Runs missing trials, and stores each as soon as it is finished."""

from __future__ import annotations

import os
import sys
import time
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Sequence

from tqdm import tqdm

from flights.files import plain
from flights.results.sources import commit
from flights.trials.store import Store
from flights.trials.trial import Failed, Row, Trial
from flights.trials.workers import ThisProcess, Workers

_BAR = "{desc}|{bar}| {elapsed}, {remaining} left{postfix}"
_SENTENCE_MAX = 300
WORKER_DIED = "The processes that ran it were killed again and again (is there memory enough?)."


@cache
def version() -> str:
    """Return the version of the code that this process runs."""
    return commit(Path(__file__).parent)


def run_trials(
    trials: Sequence[Trial], store: Store, workers: Workers, what: str, quiet: bool = False
) -> list[Failed]:
    """Run the trials that are missing in the store.

    Return those that failed; the next call retries them. Long trials begin first. Trials that must run alone
    come last, in this process. what: their name in the progress bar. quiet: show no progress bar.

    Raises:
        KeyboardInterrupt: by Ctrl-C; all finished trials are kept.
        TrialsError: the store cannot be written, or the scheduler is gone.
    """
    rows = [store.get(trial) for trial in trials]
    missing = [trial for trial, row in zip(trials, rows) if row is None]
    done = len(trials) - len(missing)
    if done and not quiet:
        _say(f"{done} of {len(trials)} trials are there from before.")
        others = sum(row is not None and row.commit != version() for row in rows)
        if others:
            _say(f"Another version of the code computed {others} of them; give another folder to start anew.")
    if version().startswith("no-git.") and not quiet:
        _say("There is no git here. A digest of the sources stands in place of the commit.")
    missing.sort(key=lambda trial: -trial.cost_s)
    progress = tqdm(
        total=sum(trial.cost_s for trial in missing), desc=what, bar_format=_BAR, disable=quiet or not missing
    )
    progress.set_postfix_str(f"{done}/{len(trials)} done")  # the first one may take minutes
    failed: list[Failed] = []
    try:
        with progress:
            for alone, who in ((False, workers), (True, ThisProcess())):
                for trial, result in who.results(_run, [t for t in missing if t.alone is alone]):
                    if isinstance(result, Row):
                        store.add(result)
                    else:
                        why = result if isinstance(result, str) else WORKER_DIED
                        failed.append(Failed(trial, why))
                        progress.write(f"{trial.title or trial.name} failed: {why}", file=sys.stderr)
                    done += 1
                    progress.set_postfix_str(f"{done}/{len(trials)} {trial.title}", refresh=False)
                    progress.update(trial.cost_s)
    except BaseException:
        workers.kill()
        raise
    return failed


def _run(trial: Trial) -> Row | str:
    """Run one trial. Return its row, or a sentence with the reason of its failure."""
    load, wall_s, cpu_s = os.getloadavg()[0], time.perf_counter(), time.process_time()
    try:
        result = plain(trial.run(**trial.given))
    except Exception as error:  # one trial's fault must not end the others
        said = " ".join(str(error).split())[:_SENTENCE_MAX]
        return said if said.endswith(".") else f"{type(error).__name__}: {said}"
    return Row(
        trial.name,
        trial.digest,
        version(),
        datetime.now(UTC).isoformat(timespec="seconds"),
        round(time.perf_counter() - wall_s, 3),
        round(time.process_time() - cpu_s, 3),
        load,
        result,
    )


def _say(sentence: str) -> None:
    print(sentence, file=sys.stderr, flush=True)
