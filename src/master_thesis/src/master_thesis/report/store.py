"""The pieces that are done, each in a folder of its own that appears when it is complete."""

from __future__ import annotations

import fcntl
import json
import shutil
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator

from master_thesis.errors import ResultsError
from master_thesis.report.piece import Made, Piece
from master_thesis.results.run_folder import plain

_UNFINISHED = ".unfinished-"


@dataclass(frozen=True)
class Done:
    """A piece that is done. facts: when, by which commit, how long it took, at which load."""

    numbers: dict
    facts: dict
    folder: Path

    def figure(self, name: str) -> bytes:
        """Return an SVG file."""
        return (self.folder / f"{name}.svg").read_bytes()


class Store:
    """The folder of all pieces."""

    def __init__(self, folder: Path) -> None:
        """Take up a folder, or make it.

        Raises:
            ResultsError: it cannot be made.
        """
        self.folder = Path(folder)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ResultsError(f"Cannot make the folder {folder}: {error.strerror}.") from None

    def get(self, piece: Piece) -> Done | None:
        """Return a piece that is done with these very inputs, or None."""
        folder = self.folder / piece.name
        try:
            content = json.loads((folder / "piece.json").read_text(encoding="utf-8"))
            if content["digest"] != piece.digest:
                return None
            return Done(content["numbers"], content["facts"], folder)
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def put(self, piece: Piece, made: Made, facts: dict) -> None:
        """Keep a piece: all of its files at once.

        Raises:
            ResultsError: they cannot be written.
        """
        content = {
            "digest": piece.digest,
            "given": piece.given,
            "inputs": piece.inputs,
            "facts": facts,
            "numbers": made.numbers,
        }
        target = self.folder / piece.name
        try:
            folder = Path(tempfile.mkdtemp(prefix=_UNFINISHED, dir=self.folder))
            folder.chmod(0o755)
            for name, svg in made.figures.items():
                (folder / f"{name}.svg").write_bytes(svg)
            text = json.dumps(plain(content), indent=1, allow_nan=False, default=str) + "\n"
            (folder / "piece.json").write_text(text, encoding="utf-8")
            shutil.rmtree(target, ignore_errors=True)
            folder.rename(target)
        except OSError as error:
            raise ResultsError(f"Cannot write {target}: {error.strerror}; free some space.") from None

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Let no other report write here meanwhile.

        Raises:
            ResultsError: another one does.
        """
        with open(self.folder / ".lock", "w", encoding="utf-8") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                sentence = (
                    f"Another report is being computed in {self.folder.parent}; wait, or give --out FOLDER."
                )
                raise ResultsError(sentence) from None
            yield

    def clear_up(self) -> None:
        """Remove what processes that were ended have left half-written."""
        for folder in self.folder.glob(f"{_UNFINISHED}*"):
            shutil.rmtree(folder, ignore_errors=True)
