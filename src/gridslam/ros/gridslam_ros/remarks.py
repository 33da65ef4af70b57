"""Reports each fault once. Sentences that differ only in numbers and names are one fault."""

from __future__ import annotations

import re
from typing import Callable

_PARTICULARS = re.compile(r'"[^"]*"|\d+')


def kind_of(sentence: object) -> str:
    """Return the part that sentences about the same fault have in common."""
    return _PARTICULARS.sub("", str(sentence))


class Remarks:
    """For a command: prints the first fault of each kind, and at the end their counts.

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
        """Print the count of each kind that came more than once."""
        for sentence, times in self._times.values():
            if times > 1:
                self._write(f"This came {times} times: {sentence}")
        self._times.clear()
