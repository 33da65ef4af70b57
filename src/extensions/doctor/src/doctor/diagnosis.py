"""A diagnosis is one line: severity, place, fault, remedy. Scripts get an exit code."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Sequence

ERROR, WARNING, NOTE = SEVERITIES = ("error", "warning", "note")
"""An error stops something from working. A warning may. A note is information."""

FINE, BROKEN, NOT_EXAMINED = 0, 1, 2
"""Exit codes: no error; an error; the examination was not possible."""


@dataclass(frozen=True)
class Diagnosis:
    """A fault. where: a node, topic, frame, file or package. remedy: often a command."""

    severity: str
    where: str
    what: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.severity:<7} {self.where}: {self.what}. -> {self.remedy}"


def ordered(diagnoses: Sequence[Diagnosis]) -> list[Diagnosis]:
    """Return each diagnosis once, the worst first. Equal ones keep their order."""
    return sorted(dict.fromkeys(diagnoses), key=lambda diagnosis: SEVERITIES.index(diagnosis.severity))


def exit_code(diagnoses: Sequence[Diagnosis]) -> int:
    """Return `BROKEN` if any diagnosis is an error, else `FINE`."""
    return BROKEN if any(diagnosis.severity == ERROR for diagnosis in diagnoses) else FINE


def as_text(diagnoses: Sequence[Diagnosis], examined: str) -> str:
    """Return a line for each diagnosis, and one about what was examined."""
    counts = [sum(diagnosis.severity == severity for diagnosis in diagnoses) for severity in SEVERITIES]
    told = ", ".join(
        f"{count} {severity}{'s' * (count != 1)}" for count, severity in zip(counts, SEVERITIES) if count
    )
    return "\n".join([*map(str, ordered(diagnoses)), f"Examined: {examined}. {told or 'Nothing is wrong'}."])


def as_json(diagnoses: Sequence[Diagnosis], examined: str) -> str:
    """Return the diagnoses as JSON."""
    content = {
        "examined": examined,
        "exit_code": exit_code(diagnoses),
        "findings": [asdict(diagnosis) for diagnosis in ordered(diagnoses)],
    }
    return json.dumps(content, indent=2)
