"""Finds out that no scan comes, by the stamps of odometry: it needs no timer and works in simulated time."""

from __future__ import annotations

from typing import Callable

TOLERANCE_NS = 1_000_000


class ScanWatch:
    """Tells when the UAV must brake because no scan was answered for too long."""

    def __init__(self, warn: Callable[[str], None]) -> None:
        self._warn = warn
        self.restart()

    def restart(self) -> None:
        """Forget the last answer, as after a clock that jumped back."""
        self._answered_ns: int | None = None
        self._moves = False

    def on_answer(self, scan_ns: int, moves: bool) -> None:
        """Take in that a scan was answered, and whether the answer is to move."""
        self._answered_ns, self._moves = scan_ns, moves

    def must_brake(self, now_ns: int, commit_s: float) -> bool:
        """Return whether the last answer is older than ``commit_s``, and warn.

        At exactly ``commit_s`` the scan of this very stamp may still come, as in lockstep.
        """
        if self._answered_ns is None or not self._moves:
            return False
        age_ns = now_ns - self._answered_ns
        if age_ns <= 1e9 * commit_s + TOLERANCE_NS:
            return False
        self._warn(f"No scan was answered for {1e-9 * age_ns:.3f} s; braking until one comes.")
        return True
