"""Computes and writes the report, for `./bringup.sh report`."""

from __future__ import annotations

import argparse
import signal
import sys
import time
from pathlib import Path
from typing import Sequence

from flights.errors import FlightsError
from flights.trials.run import run_trials
from flights.trials.store import Store
from flights.trials.workers import end, interrupted, open_workers
from flights.worlds.scenario import LIDARS
from master_thesis.chapter_8.plan import chosen, plan
from master_thesis.chapter_8.whole_page import write_whole_page
from master_thesis.report.pdf import write_pdf
from master_thesis.report.piece import TRIALS
from master_thesis.report.size import EXPERIMENTS, FULL, QUICK, SMALLEST, Size

WORKERS = 2
KEPT = "Interrupted; all finished pieces are kept; the next call goes on from here."


def main(arguments: Sequence[str] | None = None) -> int:
    """Compute missing pieces, write the page, and return the exit code."""
    for number in (signal.SIGINT, signal.SIGTERM):  # a shell ignores the first in the background
        signal.signal(number, signal.default_int_handler)
    given = _parser().parse_args(arguments)
    size = SMALLEST if given.smallest else QUICK if given.quick else FULL
    began_s = time.monotonic()
    try:
        pieces = chosen(plan(size), given.only, given.lidar)
        if not pieces:
            return _end("A report of this size has no such piece.", 2)
        page = given.out.resolve() / "index.html"
        with Store(page.with_name(TRIALS)) as store:
            try:
                with open_workers(given.workers) as workers:
                    failed = run_trials(pieces, store, workers, "report")
            except KeyboardInterrupt:
                return _interrupted(page, size, store)
            write_whole_page(page, size, store, failed)
        _say(f"\nThe report: {page}")
        _say("No PDF was asked for." if given.no_pdf else write_pdf(page, page.with_name("report.pdf")))
    except KeyboardInterrupt:
        return interrupted(KEPT)
    except FlightsError as error:
        return _end(str(error), 1)
    _say(f"It took {(time.monotonic() - began_s) / 60.0:.1f} min.")
    if failed:
        return _end(f"{len(failed)} of {len(pieces)} pieces failed, see the page; call again to try them.", 1)
    return 0


def _interrupted(page: Path, size: Size, store: Store) -> int:
    """Write the page of all finished pieces, if there are any, and return the exit code.

    Raises:
        KeyboardInterrupt: Ctrl-C again.
    """
    if any(store.get(piece) is not None for piece in plan(size)):
        _say("\nInterrupted: writing the page of what is there (Ctrl-C: without it).")
        write_whole_page(page, size, store)
        _say(f"The report, with gaps: {page}")
    return interrupted(KEPT)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="./bringup.sh report", description="Reproduce the thesis's chapter 8."
    )
    size = parser.add_mutually_exclusive_group()
    size.add_argument(
        "--quick", action="store_true", help="one seed of each experiment, about 5 minutes on two idle cores"
    )
    size.add_argument(
        "--smallest", action="store_true", help="seconds of flight, for tests of the report itself"
    )
    parser.add_argument(
        "--only", nargs="+", default=(), choices=EXPERIMENTS, metavar="NAME", help=", ".join(EXPERIMENTS)
    )
    parser.add_argument(
        "--lidar",
        nargs="+",
        default=(),
        choices=LIDARS,
        metavar="L",
        help="lidars of experiments 3 and 4: " + ", ".join(LIDARS),
    )
    parser.add_argument(
        "--out", type=Path, default=Path("results/report"), metavar="FOLDER", help="folder for the report"
    )
    parser.add_argument(
        "--workers", type=_workers, default=WORKERS, metavar="N", help="number of processes (default: 2)"
    )
    parser.add_argument("--no-pdf", action="store_true", help="write the page only")
    return parser


def _workers(text: str) -> int:
    if not text.isdigit() or not 1 <= int(text) <= 64:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of processes; give one from 1 to 64")
    return int(text)


def _say(words: str) -> None:
    print(words, flush=True)


def _end(words: str, code: int) -> int:
    print(words, file=sys.stderr, flush=True)
    return code


if __name__ == "__main__":
    end(main())
