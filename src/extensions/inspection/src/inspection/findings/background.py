"""Starts the search of photographs in another process, and talks to it."""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Sequence

from input_schemas import InputError, structured
from inspection.survey.views.candidates import View

ENDING_S = 10.0
"""Wall time in which a search that answers no more has ended."""


class SearchTargets(NamedTuple):
    """What the photographs of a survey are searched for while it is flown.

    open: photographs of what no photograph shows well enough. cracks: nearer ones of cracks.
    """

    open: bool = True
    cracks: bool = True


class Answer(NamedTuple):
    """views: photographs to take, in their order. says: a sentence. is_last: they are nearer ones."""

    views: tuple[View, ...]
    says: str
    is_last: bool = True


@dataclass(frozen=True)
class AnswerLine:
    """An answer as the process writes it. views: x, y, z in m, yaw and tilt in rad."""

    views: tuple[tuple[float, float, float, float, float], ...]
    says: str
    is_last: bool


class BackgroundSearch:
    """Searches photographs of one plan while others are taken.

    Args:
        plan: file of the plan that is flown; its mesh is searched. closer: file for the plan of nearer ones.
        targets: what the answers ask for.
    """

    def __init__(self, plan: Path, closer: Path, targets: SearchTargets) -> None:
        known = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        self._process = subprocess.Popen(
            [
                sys.executable, "-m", "inspection.findings.follower", str(plan), str(closer),
                json.dumps(targets), str(os.getpid()),
            ],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=known,
        )  # fmt: skip
        self._answers: queue.SimpleQueue[Answer] = queue.SimpleQueue()
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._writer = threading.Thread(target=self._write, daemon=True)
        self._reader.start()
        self._writer.start()

    def add(self, photograph: Path) -> None:
        """Search a photograph, soon."""
        self._send(f"{photograph}\n")

    def ask(self, left_out: Sequence[View] = ()) -> None:
        """All photographs have come, but for these: ask for an answer."""
        self._send(json.dumps([each.place_m for each in left_out]) + "\n")

    def take_answer(self) -> Answer | None:
        """Return an answer, once; None: it has not come yet."""
        try:
            return self._answers.get_nowait()
        except queue.Empty:
            return None

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._lines.put("")
        self._writer.join()
        self._reader.join()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None and not stream.closed:
                with suppress(OSError):  # lines that it did not read
                    stream.close()

    def _send(self, line: str) -> None:
        self._lines.put(line)

    def _write(self) -> None:
        """Pass the lines on. The pipe may be full while a photograph is searched; nobody waits for that."""
        assert self._process.stdin is not None
        try:
            while line := self._lines.get():
                self._process.stdin.write(line)
                self._process.stdin.flush()
        except (OSError, ValueError):
            pass  # it has ended; the reader tells

    def _read(self) -> None:
        assert self._process.stdout is not None
        is_last = False
        while not is_last:
            answer = _answer_in(self._process.stdout.readline(), self._process)
            is_last = answer.is_last
            self._answers.put(answer)


def _answer_in(line: str, process: subprocess.Popen) -> Answer:
    with suppress(ValueError, InputError):
        told = structured(json.loads(line), AnswerLine)
        views = tuple(View((x, y, z), yaw, tilt) for x, y, z, yaw, tilt in told.views)
        return Answer(views, told.says, told.is_last)
    try:
        code = process.wait(ENDING_S)
    except subprocess.TimeoutExpired:
        process.kill()  # it said something that nobody understands, and goes on
        code = process.wait()
    return Answer(
        (), f"The search of the photographs has ended (exit code {code}); no more photographs are asked for."
    )
