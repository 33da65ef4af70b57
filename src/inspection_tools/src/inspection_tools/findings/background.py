"""Starts the search of photographs in another process, and talks to it."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import NamedTuple

from inspection_tools.survey.views.candidates import View


class Answer(NamedTuple):
    """views: nearer photographs to take, in their order. says: a sentence."""

    views: tuple[View, ...]
    says: str


class BackgroundSearch:
    """Searches photographs of one plan while others are taken.

    Args:
        plan: file of the plan that is flown; its mesh is searched. closer: file for the plan of nearer ones.
    """

    def __init__(self, plan: Path, closer: Path) -> None:
        known = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "inspection_tools.findings.follower", str(plan), str(closer)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=known,
        )  # fmt: skip
        self._answer: Answer | None = None
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def add(self, photograph: Path) -> None:
        """Search a photograph, soon."""
        self._send(f"{photograph}\n")

    def ask(self) -> None:
        """All photographs have come: ask for the answer."""
        self._send("\n")

    @property
    def answer(self) -> Answer | None:
        """The answer; None: it has not come yet."""
        return self._answer

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._reader.join()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None and not stream.closed:
                stream.close()

    def _send(self, line: str) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(line)
            self._process.stdin.flush()
        except (OSError, ValueError):
            pass  # it has ended; the reader tells

    def _read(self) -> None:
        assert self._process.stdout is not None
        self._answer = _answer_in(self._process.stdout.readline(), self._process)


def _answer_in(line: str, process: subprocess.Popen) -> Answer:
    try:
        told = json.loads(line)
        views = tuple(View((x, y, z), yaw, tilt) for x, y, z, yaw, tilt in told["views"])
        if all(math.isfinite(value) for row in told["views"] for value in row):
            return Answer(views, str(told["says"]))
    except (ValueError, KeyError, TypeError):
        pass
    code = process.wait()
    return Answer((), f"The search of the photographs has ended (exit code {code}); there is no second look.")
