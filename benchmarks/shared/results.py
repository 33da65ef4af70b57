"""Writes the benchmarks' numbers: results/benchmarks.json, and tables on the terminal.

A dotted key is a nested object: `cepa.empty.speedup` is `{"cepa": {"empty": {"speedup": ...}}}`.
"""

from __future__ import annotations

import argparse
import errno
import fcntl
import json
import os
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Iterable, NoReturn, Sequence

from flights.files import plain, replace_file
from flights.results.run_folder import machine, versions
from flights.results.sources import commit

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "results"
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)


class Results:
    """The numbers of one run of one benchmark, merged into FOLDER/benchmarks.json when the `with` ends well.

    Beside the numbers stands `runs.NAME`: date, commit, machine, versions, duration, options and the load
    averages before and after, so that a reader can judge the times.
    """

    def __init__(self, name: str, folder: Path = RESULTS, options: dict | None = None) -> None:
        """Begin. options: of the run, to be recorded with it."""
        self.name, self.folder = name, Path(folder)
        self._options = dict(options or {})
        self._numbers: dict[str, Any] = {}

    def add(self, key: str, value: Any) -> None:
        """Set the value of a dotted key. A mapping replaces everything there from an earlier run."""
        self._numbers[key] = value

    def __enter__(self) -> Results:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            self._give_up(error)
        self._started = time.perf_counter()
        self._load = os.getloadavg()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, raised: BaseException | None, *trace: object
    ) -> None:
        if isinstance(raised, OSError) and raised.errno in FULL:
            self._give_up(raised)
        if kind is not None:
            return
        run = {
            "date": datetime.now(UTC).isoformat(timespec="seconds"),
            "commit": commit(ROOT),
            "duration_s": round(time.perf_counter() - self._started, 1),
            "load_before": self._load,
            "load_after": os.getloadavg(),
            "options": self._options,
            "machine": machine(),
            "versions": versions(),
        }
        path = self.folder / "benchmarks.json"
        try:
            merge(path, {**self._numbers, f"runs.{self.name}": run})
        except OSError as error:
            self._give_up(error)
        print(f"\nNumbers in {path}, load average {self._load[0]:.1f}.")

    def _give_up(self, error: OSError) -> NoReturn:
        """End the benchmark with a sentence and exit code 1."""
        what, why = error.filename or self.folder, error.strerror
        sys.exit(f"bench {self.name}: Cannot write {what}: {why}; free some space, or choose another folder.")


def merge(path: Path, numbers: dict[str, Any]) -> None:
    """Set dotted keys in a JSON file, all or none. Two processes at a time lose nothing.

    Raises:
        ValueError: the file is no JSON object; it is left as it is.
    """
    path = Path(path)
    with open(path.with_suffix(".lock"), "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        content = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        if not isinstance(content, dict):
            raise ValueError(f"{path} holds no JSON object; move it away.")
        for key, value in numbers.items():
            _put(content, key.split("."), value)
        replace_file(path, json.dumps(plain(content), indent=2, allow_nan=False) + "\n")


def _put(content: dict, names: Sequence[str], value: Any) -> None:
    *above, last = names
    for name in above:
        if not isinstance(content.get(name), dict):
            content[name] = {}
        content = content[name]
    content[last] = value


def table(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Return a table as Markdown has it, its columns aligned: the first to the left, numbers to the right."""
    lines = [list(map(str, row)) for row in (header, *rows)]
    widths = [max(3, *(len(line[column]) for line in lines)) for column in range(len(header))]
    rule = ["-" * width if column == 0 else "-" * (width - 1) + ":" for column, width in enumerate(widths)]
    written = [_row(line, widths) for line in (lines[0], rule, *lines[1:])]
    return "\n".join(written)


def _row(cells: Sequence[str], widths: Sequence[int]) -> str:
    first = cells[0].ljust(widths[0])
    return "| " + " | ".join([first, *(c.rjust(w) for c, w in zip(cells[1:], widths[1:]))]) + " |"


def options(description: str) -> argparse.ArgumentParser:
    """Return a parser with the options that every benchmark has."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--results", type=Path, default=RESULTS, help="folder to write into")
    parser.add_argument("--brief", action="store_true", help="measure less, in a shorter time")
    return parser
