"""The page of a plan whose draft is flown, as soon as the plan is complete."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Callable

from flight_basics.errors import SurveyError
from inspection.survey.plan_file import read_plan

LOOK_S = 1.0
"""Wall time between two looks at the file."""


class WholePlanPage:
    """Waits in a thread until the file of a draft holds the whole plan; then its page is written, once.

    Args:
        plan_file: of the plan; it is replaced when the plan is complete. write_page: called in the thread.
            Returns whether there is a page.
    """

    def __init__(self, plan_file: Path, write_page: Callable[[], bool]) -> None:
        self._plan_file, self._write_page = plan_file, write_page
        self._is_over, self._is_written = threading.Event(), False
        self._thread: threading.Thread | None = None

    def watch(self) -> None:
        """Begin to look at the file of a draft."""
        self._thread = threading.Thread(target=self._watch, args=(self._version(),), daemon=True)
        self._thread.start()

    def end(self) -> bool:
        """Look no more; a page that is being written is awaited. Return whether one was written."""
        self._is_over.set()
        if self._thread is not None:
            self._thread.join()
        return self._is_written

    def _watch(self, draft: int) -> None:
        while not self._is_over.wait(LOOK_S):
            if self._version() != draft:
                try:
                    is_whole = read_plan(self._plan_file).draft is None
                except SurveyError:  # the survey tells it
                    return
                self._is_written = is_whole and self._write_page()
                return

    def _version(self) -> int:
        try:
            return self._plan_file.stat().st_mtime_ns
        except OSError:
            return 0
