"""The folder of one run: results/<experiment>/<time>/ with result.json, CSV series and pictures.

A folder is never written twice, and a file appears under its name only when it is complete. result.json tells
a success only when every other file of the run is complete, and what was asked was done (`shortfall`).
"""

from __future__ import annotations

import csv
import io
import json
import os
import platform
import threading
from datetime import datetime
from importlib import metadata
from pathlib import Path
from typing import Iterable, Mapping, Sequence

from flights.errors import ResultsError
from flights.files import plain, replace_file
from flights.results.shortfall import shortfall

RESULT = "result.json"
INCOMPLETE = "The run ended before all files of its results were written; its last messages tell why."
_PHYSICS = ("pybullet", "pybullet-arm64", "embreex", "trimesh")
_PACKAGES = ("numpy", "numba", *_PHYSICS, "pymavlink", "matplotlib", "scipy")


class RunFolder:
    """A new folder for one run."""

    def __init__(self, root: Path, experiment: str, started: datetime) -> None:
        """Make ROOT/EXPERIMENT/YYYY-mm-dd_HH-MM-SS, with _1, _2, ... if there is one already.

        Raises:
            ResultsError: it cannot be made.
        """
        self._writing = threading.Lock()
        self._missing: list[str] = []
        self._newest: dict = {}
        parent = Path(root).expanduser().resolve() / experiment
        stamp = started.strftime("%Y-%m-%d_%H-%M-%S")
        try:
            parent.mkdir(parents=True, exist_ok=True)
            self.path = _make_unused(parent, stamp)
        except OSError as error:
            raise ResultsError(cannot(f"make a results folder in {parent}", error)) from error

    def write_json(self, name: str, content: dict) -> Path:
        """Write a JSON file. Numbers that are not finite become null, because JSON does not have them."""
        return self._write(name, _json(content))

    def lacks(self, sentence: str) -> None:
        """Note that a part of the results is missing, with the reason: the run is no success then."""
        self._missing.append(sentence)

    def write_result(self, content: dict, is_whole: bool = False) -> dict:
        """Write result.json, and return its content.

        is_whole: all files that tell of the flight are written; a report may follow. Until then, and if a
            part is missing, it tells no success.
        """
        self._newest = content
        told = self._with_failure(content, is_whole)
        self.write_json(RESULT, told)
        return told

    def write_csv(self, name: str, columns: Sequence[str], rows: Iterable[Sequence]) -> Path:
        """Write a CSV file with a header line; floats with nine significant digits."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([f"{v:.9g}" if isinstance(v, float) else v for v in row] for row in rows)
        return self._write(name, text.getvalue().encode("utf-8"))

    def write_files(self, contents: Mapping[str, bytes]) -> None:
        """Write several files, by name."""
        for name, content in contents.items():
            self._write(name, content)

    def seal(self, patience_s: float, left_out: str) -> dict:
        """Allow no more files, because the user ends the process. Return the content of result.json.

        It is the newest that `write_result` was given, and says what the user leaves out, in words.
        patience_s: wall time to wait for a file that is being written.
        """
        self._writing.acquire(timeout=patience_s)
        told = self._with_failure({**self._newest, "left_out": left_out}, is_whole=True)
        self._replace(self.path / RESULT, _json(told))
        return told

    def _with_failure(self, content: dict, is_whole: bool) -> dict:
        missing = self._missing if is_whole else [INCOMPLETE, *self._missing]
        wrong = [*missing, *filter(None, (shortfall(content),))]
        if not wrong:
            return content
        return {**content, "success": False, "failure": content["failure"] or wrong[0]}

    def _write(self, name: str, content: bytes) -> Path:
        with self._writing:
            return self._replace(self.path / name, content)

    def _replace(self, target: Path, content: bytes) -> Path:
        try:
            replace_file(target, content)
        except OSError as error:
            raise ResultsError(cannot(f"write {target}", error)) from error
        return target


def _json(content: dict) -> bytes:
    return (json.dumps(plain(content), indent=2, allow_nan=False) + "\n").encode("utf-8")


def _make_unused(parent: Path, stamp: str) -> Path:
    for attempt in range(10_000):
        path = parent / (f"{stamp}_{attempt}" if attempt else stamp)
        try:
            path.mkdir()
        except FileExistsError:
            continue
        return path
    raise FileExistsError(17, "ten thousand runs within a second", str(parent / stamp))


def cannot(what: str, error: OSError) -> str:
    """Return the sentence about something that cannot be done in a results folder."""
    return f"Cannot {what}: {error.strerror}; free some space or choose another folder with results:=FOLDER."


def machine() -> dict:
    """Return a description of the machine."""
    return {
        "cpu": _first_line_after("/proc/cpuinfo", "model name"),
        "cores": os.cpu_count(),
        "memory": _first_line_after("/proc/meminfo", "MemTotal"),
        "system": platform.platform(),
    }


def versions() -> dict:
    """Return the versions of Python, ROS and the packages that influence a flight."""
    found = {"python": platform.python_version(), "ros_distro": os.environ.get("ROS_DISTRO")}
    for package in _PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = None
    return found


def _first_line_after(path: str, key: str) -> str | None:
    try:
        with open(path, encoding="utf-8") as stream:
            return next((line.split(":", 1)[1].strip() for line in stream if line.startswith(key)), None)
    except OSError:
        return None
