"""A finding is one line: severity, place, fault, remedy. Scripts get an exit code."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Sequence

ERROR, WARNING, NOTE = SEVERITIES = ("error", "warning", "note")
"""An error stops something from working. A warning may. A note is information."""

FINE, BROKEN, NOT_EXAMINED = 0, 1, 2
"""Exit codes: no error; an error; the examination was not possible."""


@dataclass(frozen=True)
class Finding:
    """A fault. where: a node, topic, frame, file or package. remedy: often a command."""

    severity: str
    where: str
    what: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.severity:<7} {self.where}: {self.what}. -> {self.remedy}"


def ordered(findings: Sequence[Finding]) -> list[Finding]:
    """Return each finding once, the worst first. Equal ones keep their order."""
    return sorted(dict.fromkeys(findings), key=lambda finding: SEVERITIES.index(finding.severity))


def exit_code(findings: Sequence[Finding]) -> int:
    """Return `BROKEN` if any finding is an error, else `FINE`."""
    return BROKEN if any(finding.severity == ERROR for finding in findings) else FINE


def as_text(findings: Sequence[Finding], examined: str) -> str:
    """Return a line for each finding, and one about what was examined."""
    counts = [sum(finding.severity == severity for finding in findings) for severity in SEVERITIES]
    told = ", ".join(
        f"{count} {severity}{'s' * (count != 1)}" for count, severity in zip(counts, SEVERITIES) if count
    )
    return "\n".join([*map(str, ordered(findings)), f"Examined: {examined}. {told or 'Nothing is wrong'}."])


def as_json(findings: Sequence[Finding], examined: str) -> str:
    """Return the findings as JSON."""
    content = {
        "examined": examined,
        "exit_code": exit_code(findings),
        "findings": [asdict(finding) for finding in ordered(findings)],
    }
    return json.dumps(content, indent=2)
