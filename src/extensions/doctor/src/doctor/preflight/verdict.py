"""What a check found: one sentence, and what to do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

FINE, FAILED, NOT_CHECKED = 0, 1, 2
"""Exit codes: all passed; one failed; no check was possible."""


@dataclass(frozen=True)
class Verdict:
    """name: of the check. sentence: what was found. remedy: what to do; empty if the check is passed."""

    name: str
    sentence: str
    remedy: str = ""

    @property
    def passed(self) -> bool:
        """Whether there is nothing to do."""
        return not self.remedy

    def __str__(self) -> str:
        if self.passed:
            return f"passed  {self.name}: {self.sentence}."
        return f"failed  {self.name}: {self.sentence}. -> {self.remedy}."


def exit_code(verdicts: Sequence[Verdict]) -> int:
    """Return `FINE` if all checks are passed, else `FAILED`."""
    return FINE if all(verdict.passed for verdict in verdicts) else FAILED
