"""The file of finished trials: one line of JSON for each, written as soon as it is finished."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
from pathlib import Path
from typing import IO

from flights.errors import TrialsError
from flights.files import plain, replace_file
from flights.trials.trial import Row, Trial
from input_schemas import InputError, structured


class Store:
    """A file of finished trials, locked while it is open. Use it as a context manager.

    If a process ends while it writes a line, only that trial is lost. If a name occurs twice, the later line
    counts.
    """

    def __init__(self, path: Path, fresh: bool = False) -> None:
        """Open a file, or create it. fresh: forget its content.

        Raises:
            TrialsError: another process uses the file, or it is damaged or cannot be written.
        """
        self.path = Path(path).expanduser()
        self._lock = self._locked()
        try:
            self._rows = {} if fresh else self._read()
            self._stream = self._begin()
        except BaseException:
            self._lock.close()
            raise

    def _locked(self) -> IO[str]:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            lock = open(self.path.with_name(f".{self.path.name}.lock"), "w", encoding="utf-8")  # noqa: SIM115
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                lock.close()
                raise
        except BlockingIOError:
            sentence = (
                f"Another process writes trials into {self.path.parent}; wait, or choose another folder."
            )
            raise TrialsError(sentence) from None
        except OSError as error:
            raise TrialsError(f"The folder {self.path.parent} cannot be used: {error.strerror}.") from None
        return lock

    def _read(self) -> dict[str, Row]:
        """Return the rows by name. The last line counts only if it is complete."""
        content = self.path.read_bytes() if self.path.exists() else b""
        rows = {}
        for number, line in enumerate(content.split(b"\n")[:-1], start=1):
            try:
                row = structured(json.loads(line), Row)
            except (ValueError, InputError):
                raise TrialsError(f"{self.path} is damaged in line {number}; move it away.") from None
            rows[row.name] = row
        return rows

    def _begin(self) -> IO[bytes]:
        """Write only the rows that count. Return the file, open for appending."""
        try:
            replace_file(self.path, b"".join(map(_line, self._rows.values())))
            return open(self.path, "ab")
        except OSError as error:
            raise TrialsError(f"Cannot write {self.path}: {error.strerror}; free some space.") from None

    def get(self, trial: Trial) -> Row | None:
        """Return the row of a trial if it was computed from the same inputs, or None."""
        row = self._rows.get(trial.name)
        return row if row is not None and row.digest == trial.digest else None

    def add(self, row: Row) -> None:
        """Keep a row and write it to the disk; raises TrialsError."""
        try:
            self._stream.write(_line(row))
            self._stream.flush()
            os.fsync(self._stream.fileno())
        except OSError as error:
            raise TrialsError(f"Cannot write {self.path}: {error.strerror}; free some space.") from None
        self._rows[row.name] = row

    def close(self) -> None:
        """Unlock the file."""
        with contextlib.suppress(OSError):  # of a full disk, which `add` has told
            self._stream.close()
        self._lock.close()

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _line(row: Row) -> bytes:
    return json.dumps(plain(row), allow_nan=False).encode("utf-8") + b"\n"
