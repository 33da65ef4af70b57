"""The file of findings: status and remark are the surveyor's, and stay when findings are made anew."""

from __future__ import annotations

import json
import math
import os
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Mapping, Sequence

import numpy as np

from inspection_tools.errors import ReportError
from inspection_tools.findings.merging import Finding

NEW, UNDER_REVIEW, CONFIRMED, DISMISSED = STATUSES = ("new", "under review", "confirmed", "dismissed")
APART_M = 0.15
"""Positions of one finding in two runs, or in two surveys, differ by less, besides half its length."""


def read_findings(path: Path) -> list[Finding]:
    """Read a file of findings.

    Raises:
        ReportError: one sentence that names the file, the finding and the fault.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ReportError(f"The findings {path} cannot be read: {error.strerror}.") from None
    except ValueError as error:
        raise ReportError(f"The findings {path} are not JSON ({error}).") from None
    entries = content.get("findings") if isinstance(content, Mapping) else None
    if not isinstance(entries, list):
        raise ReportError(f'{path}: there is no list "findings" in it.')
    found = [_finding(path, number, each) for number, each in enumerate(entries, start=1)]
    if len({each.id for each in found}) < len(found):
        raise ReportError(f"{path}: two findings have the same id. Give each its own.")
    return found


def _finding(path: Path, number: int, given: Any) -> Finding:
    where = f"{path}, entry {number}"
    try:
        known: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value for key, value in given.items()
        }
        finding = Finding(**known)
        numbers = (*finding.position_m, *finding.normal, finding.length_m, finding.area_m2)
        good = len(numbers) == 8 and all(math.isfinite(each) for each in numbers)
        places_m = np.array(finding.places_m, float).reshape(len(finding.places_m), 3)
        good &= bool(np.isfinite(places_m).all())
        good &= isinstance(finding.id, int) and all(isinstance(each, str) for each in finding.photographs)
    except (TypeError, ValueError, AttributeError) as error:
        raise ReportError(f"{where}: is no finding ({error}).") from None
    if not good:
        raise ReportError(f"{where}: it needs a whole id, finite numbers, and names of photographs.")
    if finding.status not in STATUSES:
        raise ReportError(f'{where}: the status is "{finding.status}"; give one of {", ".join(STATUSES)}.')
    return replace(finding, remark=str(finding.remark), places_m=tuple(map(tuple, places_m.tolist())))


def write_findings(path: Path, findings: Sequence[Finding]) -> None:
    """Write a file of findings, whole or not at all. Raises ReportError."""
    rows = ",\n".join(json.dumps(asdict(each)) for each in findings)
    partial = path.with_name(path.name + ".part")
    try:
        partial.write_text(f'{{"frame": "map", "findings": [\n{rows}\n]}}\n', encoding="utf-8")
        os.replace(partial, path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise ReportError(f"{path} cannot be written: {error.strerror}.") from None


def pairs_of(before: Sequence[Finding], now: Sequence[Finding]) -> list[tuple[int, int]]:
    """Return pairs (index before, index now) of one kind in one place, the nearest first; each once."""
    if not before or not now:
        return []
    places = [np.array([each.position_m for each in group]) for group in (before, now)]
    lengths = [np.array([each.length_m for each in group]) for group in (before, now)]
    apart_m = np.linalg.norm(places[0][:, None] - places[1][None], axis=2)
    same = np.array([[a.kind == b.kind for b in now] for a in before])
    allowed = same & (apart_m <= APART_M + 0.5 * np.maximum(lengths[0][:, None], lengths[1][None]))
    rows, columns = np.nonzero(allowed)
    left, right, pairs = set(range(len(before))), set(range(len(now))), []
    for k in np.argsort(apart_m[rows, columns], kind="stable"):
        i, j = int(rows[k]), int(columns[k])
        if i in left and j in right:
            pairs.append((i, j))
            left.remove(i)
            right.remove(j)
    return pairs


def with_decisions(before: Sequence[Finding], now: Sequence[Finding]) -> list[Finding]:
    """Return findings that were made anew, with number, status and remark of those before.

    What a surveyor has judged stays, even if it is not found again.
    """
    of = {j: before[i] for i, j in pairs_of(before, now)}
    used = {each.id for each in of.values()}
    judged = [e for e in before if e.id not in used and (e.status != NEW or e.remark)]
    following = max((each.id for each in before), default=0) + 1
    kept = []
    for j, each in enumerate(now):
        if j in of:
            kept.append(replace(each, id=of[j].id, status=of[j].status, remark=of[j].remark))
        else:
            kept.append(replace(each, id=following))
            following += 1
    return sorted([*kept, *judged], key=lambda each: each.id)


def decide(findings: Sequence[Finding], number: int, status: str, remark: str | None) -> list[Finding]:
    """Return the findings with a surveyor's status, and remark if there is one, of one of them.

    Raises:
        ReportError: there is no such finding, or no such status.
    """
    if status not in STATUSES:
        raise ReportError(f'"{status}" is no status; give one of {", ".join(STATUSES)}.')
    if number not in {each.id for each in findings}:
        raise ReportError(f"There is no finding {number}; there are {len(findings)}.")

    def judged(each: Finding) -> Finding:
        return replace(each, status=status, remark=each.remark if remark is None else remark)

    return [judged(each) if each.id == number else each for each in findings]
