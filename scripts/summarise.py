#!/usr/bin/env python3
"""Print a run's result folder and main figures. Exit with 0 only if the run and its roslaunch succeeded.

usage: summarise.py RESULT_JSON [EXIT_CODE_OF_ROSLAUNCH]    (with the workspace's environment)
"""

from __future__ import annotations

import signal

signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C during the slow imports: no traceback

import sys
from pathlib import Path

from flights.errors import ResultsError
from flights.results import run_summary
from input_schemas import read_made
from master_thesis.experiment_2 import summary as trial_summary


def headline(result: dict) -> str:
    """Return a run's figures in a few lines."""
    if result["experiment"] == "experiment_2":
        return trial_summary.headline(result)
    if result["experiment"] in ("experiment_3", "experiment_4"):
        from master_thesis.experiments_3_4 import (  # takes half a second, and only these two need it
            slam_summary,
        )

        return slam_summary.headline(result)
    if result["experiment"] == "explore":
        from flights.exploring import summary

        return summary.headline(result)
    if result["experiment"] == "inspection":
        from flights.inspecting import summary as inspection_summary

        return inspection_summary.headline(result)
    return run_summary.headline(result)


def main(path: Path, launch_code: int = 0) -> int:
    """Print the summary of one result.json. launch_code: roslaunch's exit code."""

    def made(result: dict) -> tuple[str, bool, str | None]:
        try:
            return headline(result), result["success"], run_summary.truth_digest(path.parent, result)
        except (LookupError, TypeError, ValueError, AttributeError) as error:
            raise ResultsError(
                f"was changed, or is of another version: {error!r}. It is not summarised."
            ) from None

    try:
        told, success, digest = read_made(path, "The record", made, ResultsError)
    except ResultsError as error:
        print(error, file=sys.stderr)
        return 1
    print(f"\nResults in {path.parent}:\n{told}")
    print(f"  {'digest of truth.csv':<22} {digest}\n" if digest else "")
    if not success:
        print("The run failed; see result.json and ROS's logs.")
        return 1
    if launch_code:
        print(f"roslaunch gave up with code {launch_code}, so the run failed; the reason stands above.")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), *map(int, sys.argv[2:])))
