"""Computes what is missing of the report, two pieces at a time, and says how far it is."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Callable, Sequence

from master_thesis.errors import MasterThesisError
from master_thesis.report.piece import Piece
from master_thesis.report.store import Store
from master_thesis.results.sources import commit

HERE = Path(__file__).parent
Say = Callable[[str], None]


@dataclass(frozen=True)
class Failed:
    """A piece that came to nothing, and the sentence that says why."""

    piece: Piece
    why: str


def compute(pieces: Sequence[Piece], store: Store, workers: int, say: Say) -> list[Failed]:
    """Compute the pieces that are not done yet; return those that failed.

    Raises:
        KeyboardInterrupt: by Ctrl-C; what is finished is kept.
        ResultsError: the pieces cannot be kept.
    """
    store.clear_up()
    found = [(piece, store.get(piece)) for piece in pieces]
    missing = [piece for piece, done in found if done is None]
    if len(missing) < len(pieces):
        say(f"{len(pieces) - len(missing)} of {len(pieces)} pieces are there from before.")
    here = commit(HERE)
    others = sum(done is not None and done.facts["commit"] != here for _, done in found)
    if others:
        say(f"{others} of them were computed by another version of the code; give --out to compute all anew.")
    progress = _Progress(missing, workers, say)
    beside, alone = ([p for p in missing if p.alone is flag] for flag in (False, True))
    try:
        failed = _in_pool(beside, store, workers, progress)
        return failed + _in_pool(alone, store, 1, progress)
    finally:
        store.clear_up()


def _in_pool(pieces: Sequence[Piece], store: Store, workers: int, progress: _Progress) -> list[Failed]:
    """Compute in worker processes, dear pieces first, so that none is left alone at the end."""
    if not pieces:
        return []
    failed: list[Failed] = []
    sources = commit(HERE)
    pool = ProcessPoolExecutor(workers, initializer=_begin_worker)
    try:
        running: dict[Future, Piece] = {
            pool.submit(_compute, piece, store.folder, sources): piece
            for piece in sorted(pieces, key=lambda piece: -piece.cost_s)
        }
        while running:
            over, _ = wait(running, timeout=1.0, return_when=FIRST_COMPLETED)
            for future in over:
                piece = running.pop(future)
                took_s, why = _outcome(future)
                if why is not None:
                    failed.append(Failed(piece, why))
                progress.over(piece, took_s, why)
    except BaseException:
        for process in multiprocessing.active_children():
            process.terminate()
        raise
    finally:
        pool.shutdown()
    return failed


def _outcome(future: Future) -> tuple[float, str | None]:
    try:
        return future.result()
    except BrokenProcessPool:
        return 0.0, "a worker process was killed (is there memory enough?); call again to go on."


class _Ended(SystemExit):
    """The parent has ended this worker."""


def _begin_worker() -> None:
    """Leave Ctrl-C to the parent, which ends its workers; they clear up what they have started."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _end_worker)


def _end_worker(*_) -> None:
    raise _Ended


def _compute(piece: Piece, folder: Path, sources: str | None) -> tuple[float, str | None]:
    """Compute and keep one piece; return the seconds it took, and why it failed if it did."""
    store = Store(folder)
    began_s, began_cpu_s, load = time.monotonic(), time.process_time(), os.getloadavg()[0]
    try:
        made = piece.make(**piece.given)
    except _Ended:
        os._exit(1)  # the pool would take it for the piece's outcome, and begin another one
    except MasterThesisError as error:
        return time.monotonic() - began_s, str(error)
    except Exception as error:  # one piece's fault must not cost the others
        return time.monotonic() - began_s, f"{type(error).__name__}: {error}"
    took_s = time.monotonic() - began_s
    facts = {
        "date": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "commit": sources,
        "took_s": round(took_s, 2),
        "cpu_s": round(time.process_time() - began_cpu_s, 2),
        "load": load,
    }
    store.put(piece, made, facts)
    return took_s, None


class _Progress:
    """One line for each piece, with an estimate of what is left."""

    def __init__(self, pieces: Sequence[Piece], workers: int, say: Say) -> None:
        self._say, self._of, self._done = say, len(pieces), 0
        self._workers = workers
        self._left_s = sum(piece.cost_s for piece in pieces)
        self._expected_s = self._took_s = 0.0
        if pieces:
            left = _duration(self._left_s / workers)
            say(f"{len(pieces)} pieces to compute, in about {left} on an idle machine.")

    def over(self, piece: Piece, took_s: float, why: str | None) -> None:
        """Take note of a piece that is over."""
        self._done += 1
        self._left_s -= piece.cost_s
        if why is None:
            self._expected_s += piece.cost_s
            self._took_s += took_s
        words = f"{took_s:.0f} s" if why is None else f"failed: {why}"
        self._say(f"[{self._done:3d}/{self._of}] {piece.title}: {words}{self._left()}")

    def _left(self) -> str:
        if self._done == self._of or not self._expected_s:
            return ""
        left_s = self._left_s * self._took_s / self._expected_s / self._workers
        return f"; about {_duration(left_s)} left"


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"
