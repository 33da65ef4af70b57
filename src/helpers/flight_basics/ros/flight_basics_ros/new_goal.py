"""A goal on its way from actionlib's callback to the thread that begins or refuses it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class NewGoal:
    """A goal that nobody has answered yet.

    actionlib holds two locks while a goal's callback runs, and a condition gives back only one of them. So
    the callback only stores the goal. It neither waits nor reads files.

    goal: of the action. identity: see `identity_of`. until_s: monotonic time until which it may wait for what
    is missing.
    """

    goal: Any
    identity: str
    until_s: float

    def is_due(self, missing: str, longer_s: float = 0.0) -> bool:
        """Return whether to answer it now.

        missing: what is not known yet, a sentence; empty: nothing. longer_s: it may wait for so much longer.
        """
        return not missing or time.monotonic() >= self.until_s + longer_s
