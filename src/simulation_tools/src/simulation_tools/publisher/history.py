"""The last messages of one topic."""

from __future__ import annotations

from collections import deque
from typing import Any, Iterable

KEPT_NS = 6_000_000_000
"""A command may be 5 s old (command_timeout), and a decision looks 0.3 s further back."""


class History:
    """The values of the last seconds with their stamps, and the one before them."""

    def __init__(self) -> None:
        self._items: deque = deque()

    def add(self, stamp_ns: int, value: Any) -> None:
        """Take in a value."""
        self._items.append((stamp_ns, value))
        while len(self._items) > 1 and self._items[1][0] <= stamp_ns - KEPT_NS:
            self._items.popleft()

    def at(self, stamp_ns: float) -> Any:
        """Return the newest value that is not newer than a stamp, or None."""
        return self.item_at(stamp_ns)[1]

    def at_or_oldest(self, stamp_ns: float) -> Any:
        """Return the value that `at` returns; the oldest if all are newer, None if there is none."""
        stamp, value = self.item_at(stamp_ns)
        return value if stamp is not None or not self._items else self._items[0][1]

    def stamp_at(self, stamp_ns: float) -> int | None:
        """Return the stamp of the value that `at` returns."""
        return self.item_at(stamp_ns)[0]

    def item_at(self, stamp_ns: float) -> tuple[int | None, Any]:
        """Return the value that `at` returns, with its stamp before it."""
        for stamp, value in reversed(self._items):
            if stamp <= stamp_ns:
                return stamp, value
        return None, None

    def at_each(self, stamps_ns: Iterable[float]) -> list[tuple[int, Any]]:
        """Return the stamp and the value that `at` returns for each of some rising stamps, none twice."""
        found: list[tuple[int, Any]] = []
        for stamp_ns in stamps_ns:
            stamp, value = self.item_at(stamp_ns)
            if stamp is not None and (not found or stamp > found[-1][0]):
                found.append((stamp, value))
        return found

    def newest(self) -> Any:
        """Return the value that came last, or None."""
        return self._items[-1][1] if self._items else None

    def clear(self) -> None:
        """Forget everything."""
        self._items.clear()
