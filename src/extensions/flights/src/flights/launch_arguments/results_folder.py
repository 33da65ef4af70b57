"""Checks that results can be written to the requested folder."""

from __future__ import annotations

import os
from pathlib import Path

from flights.errors import ResultsError
from flights.worlds.scenario import absolute


def results_path(given: str) -> Path:
    """Return the folder for results, absolute; ~ is the user's home. Raises FlightsError."""
    return absolute("results", os.path.expanduser(given))


def check_results(given: str) -> None:
    """Check that a folder can be made, or written to; raises FlightsError with one sentence."""
    path = results_path(given)
    there = next(folder for folder in (path, *path.parents) if folder.exists())
    if not there.is_dir():
        raise ResultsError(f"{there} is a file; choose a folder for the results with results:=FOLDER.")
    if not os.access(there, os.W_OK | os.X_OK):
        raise ResultsError(f"{there} may not be written to; choose another folder with results:=FOLDER.")
