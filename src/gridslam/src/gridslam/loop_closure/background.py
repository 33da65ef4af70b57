"""Work that is done beside the filter, and taken at a fixed stamp."""

from __future__ import annotations

from concurrent.futures import Executor
from typing import Callable

from gridslam.loop_closure.correction import Correction


class BackgroundWork:
    """Runs a function in another thread.

    Args:
        thread: runs it.
        begun_s: stamp of the scan that led to the work, s.
        due_s: the result is taken at the first scan with this stamp or a later one, s.
        work: returns the correction, or None.
    """

    def __init__(
        self, thread: Executor, begun_s: float, due_s: float, work: Callable[[], Correction | None]
    ) -> None:
        self.begun_s, self.due_s = begun_s, due_s
        self._future = thread.submit(work)

    def is_due(self, stamp_s: float) -> bool:
        """Return whether the result is to be taken at a stamp. It is, too, if the clock went back."""
        return not self.begun_s <= stamp_s < self.due_s

    def result(self) -> Correction | None:
        """Wait for the result and return it. An exception of the work is raised here."""
        return self._future.result()
