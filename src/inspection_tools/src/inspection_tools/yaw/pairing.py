"""Pairs each command with its reference by their stamps."""

from __future__ import annotations

from collections import deque
from typing import Any, Optional, Tuple

KEPT_REFERENCES = 64

Reference = Tuple[int, Any]
"""Stamp in ns, and value."""
Pair = Tuple[Any, Optional[Reference]]
"""A command and its reference, if there is one."""


class ReferencePairing:
    """Finds the reference of a command: the one with the same stamp, else the newest.

    Reference and command come over different connections, so a command may arrive before its reference. If
    the source shares stamps with the commands, the command waits for its reference. So the outcome does not
    depend on the order of arrival. If the next command comes first, the waiting one gets the newest
    reference. So every command is answered, and in order.

    Stamps are whole nanoseconds. Values may be anything.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget everything, as after a clock that jumped back."""
        self._references: deque[Reference] = deque(maxlen=KEPT_REFERENCES)  # oldest first
        self._shares_stamps = False
        self._held: tuple[int, Any] | None = None

    def offer_reference(self, stamp_ns: int, value: Any) -> list[Pair]:
        """Take in a reference. Return the (command, reference) pairs that it completes, at most one."""
        if self._references and stamp_ns < self._references[-1][0]:
            self._references.clear()  # the source's clock jumped back
        self._references.append((stamp_ns, value))
        if self._held is None or stamp_ns < self._held[0]:
            return []
        return self._release()

    def offer_command(self, stamp_ns: int, command: Any) -> list[Pair]:
        """Take in a command.

        Return the complete (command, reference) pairs, oldest first. A reference is a (stamp_ns, value), or
        None if there is none.
        """
        released = self._release()
        newest_ns = self._references[-1][0] if self._references else None
        if self._shares_stamps and newest_ns is not None and newest_ns < stamp_ns:
            self._held = (stamp_ns, command)
            self._shares_stamps = False  # until a reference with a command's stamp comes again
            return released
        return [*released, (command, self._find(stamp_ns))]

    def _release(self) -> list[Pair]:
        if self._held is None:
            return []
        (held_ns, command), self._held = self._held, None
        return [(command, self._find(held_ns))]

    def _find(self, stamp_ns: int) -> Reference | None:
        if not self._references:
            return None
        for reference in reversed(self._references):
            if reference[0] == stamp_ns:
                self._shares_stamps = True
                return reference
        self._shares_stamps = False
        return self._references[-1]
