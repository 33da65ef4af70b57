"""Tells each fault once. Sentences that differ only in numbers and names are one fault."""

from __future__ import annotations

import re
from typing import Callable

_PARTICULARS = re.compile(r'"[^"]*"|\d+')


def kind_of(sentence: object) -> str:
    """Return what sentences about the same fault have in common."""
    return _PARTICULARS.sub("", str(sentence))


class Remarks:
    """For a command: says the first fault of each kind, and at the end how often it came.

    Args:
        write: shows a sentence to the user.
    """

    def __init__(self, write: Callable[[str], None]):
        self._write = write
        self._times: dict[str, list] = {}

    def say(self, sentence: object) -> None:
        """Say the sentence unless one of its kind has been said."""
        first = self._times.setdefault(kind_of(sentence), [sentence, 0])
        first[1] += 1
        if first[1] == 1:
            self._write(str(sentence))

    def sum_up(self) -> None:
        """Say how often each kind came, of those that came more than once."""
        for sentence, times in self._times.values():
            if times > 1:
                self._write(f"This came {times} times: {sentence}")
        self._times.clear()
