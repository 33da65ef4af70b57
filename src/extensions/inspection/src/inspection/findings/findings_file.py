"""The file of findings: status and remark are the surveyor's, and stay when findings are made anew."""

from __future__ import annotations

import fcntl
import json
import os
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Iterator, Mapping, Sequence

from flight_basics.errors import ReportError
from input_schemas import read_made, structured
from inspection.files.whole import write_whole
from inspection.findings.kinds import kind_of
from inspection.findings.merging import STATUSES, Finding
from inspection.findings.pairing import has_grown, meetings_of, pairs_of
from inspection.findings.picture.on_pictures import MarkedPicture
from inspection.photographs.listing import LeftOut
from inspection.photographs.searched import LeftOutEntry

NEW, UNDER_REVIEW, CONFIRMED, DISMISSED = STATUSES
WEIGHTS = (DISMISSED, NEW, UNDER_REVIEW, CONFIRMED)
"""Of several decisions on one place the last one counts."""
MOSTLY = 3.0
"""Of what is more than so many times as large, most was not there to be judged. Chosen: other photographs may
show twice as much of one thing.
"""


@dataclass(frozen=True)
class SearchRecord:
    """What findings.json holds.

    searched: names of the photographs in which findings were looked for; None: an older program did not tell.
    left_out: those that could not be searched, with the reason. red: names of those whose coating is as red
    as rust: rust of its colour is not told from it. without_pose: what is marked on pictures alone. flawed:
    those that were searched, but are blurred or written upon, with a sentence for each flaw. rests_on: by
    photograph, the digest of what was searched; see `photographs.searched`.
    """

    findings: tuple[Finding, ...] = ()
    searched: tuple[str, ...] | None = None
    left_out: tuple[LeftOut, ...] = ()
    red: tuple[str, ...] = ()
    without_pose: tuple[MarkedPicture, ...] = ()
    flawed: tuple[LeftOut, ...] = ()
    rests_on: Mapping[str, str] = field(default_factory=dict)


def read_findings(path: Path) -> list[Finding]:
    """Read the findings of a file; raises ReportError as `read_search`."""
    return list(read_search(path).findings)


@dataclass(frozen=True)
class FindingsFile:
    """What is in a file of findings; see `SearchRecord`."""

    findings: tuple[Finding, ...]
    searched: tuple[str, ...] | None = None
    left_out: tuple[LeftOutEntry, ...] = ()
    red: tuple[str, ...] = ()
    without_pose: tuple[MarkedPicture, ...] = ()
    flawed: tuple[LeftOutEntry, ...] = ()
    rests_on: dict[str, str] = field(default_factory=dict)


def read_search(path: Path) -> SearchRecord:
    """Read a file of findings.

    Raises:
        ReportError: one sentence that names the file, the finding and the fault.
    """
    return read_made(path, "The findings", _search_in, ReportError)


def _search_in(content: object) -> SearchRecord:
    told = structured(content, FindingsFile, ReportError, other_keys=True)
    if len({each.id for each in told.findings}) < len(told.findings):
        raise ReportError("Two findings have the same id. Give each its own.")
    left_out, flawed = (tuple(each.left_out for each in given) for given in (told.left_out, told.flawed))
    return SearchRecord(
        told.findings, told.searched, left_out, told.red, told.without_pose, flawed, told.rests_on
    )


def write_findings(path: Path, record: SearchRecord) -> None:
    """Write a file of findings, whole or not at all. Raises ReportError."""
    rows = ",\n".join(json.dumps(asdict(each)) for each in record.findings)
    searched = "" if record.searched is None else f'"searched": {json.dumps(record.searched)}, '
    left_out, flawed = (
        json.dumps([{"photograph": each.name, "why": each.why} for each in told])
        for told in (record.left_out, record.flawed)
    )
    searched += f'"flawed": {flawed}, ' if record.flawed else ""
    searched += f'"rests_on": {json.dumps(record.rests_on)}, ' if record.rests_on else ""
    searched += f'"red": {json.dumps(record.red)}, ' if record.red else ""
    searched += (
        f'"without_pose": {json.dumps([asdict(each) for each in record.without_pose])}, '
        if record.without_pose
        else ""
    )
    text = f'{{"frame": "map", {searched}"left_out": {left_out}, "findings": [\n{rows}\n]}}\n'
    try:
        write_whole({path: text.encode()})
    except OSError as error:
        raise ReportError(f"{path} cannot be written: {error.strerror}.") from None


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Keep others from changing a file of findings between reading and writing it.

    Raises:
        ReportError: its folder cannot be used.
    """
    try:
        descriptor = os.open(path.parent, os.O_RDONLY)
    except OSError as error:
        raise ReportError(f"{path} cannot be written: {error.strerror}.") from None
    try:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def with_decisions(before: Sequence[Finding], now: Sequence[Finding]) -> list[Finding]:
    """Return findings that were made anew, with number, status and remark of those before.

    What a surveyor has judged stays, even if it is not found again. Where several were, what weighs most
    counts. What was dismissed is to be judged again if most of it is new.
    """
    number = {j: before[i].id for i, j in pairs_of(before, now)}
    of: dict[int, list[Finding]] = {}
    for i, j in meetings_of(before, now):
        of.setdefault(j, []).append(before[i])
    used = {each.id for own in of.values() for each in own}
    judged = [e for e in before if e.id not in used and (e.status != NEW or e.remark)]
    following = max((each.id for each in before), default=0) + 1
    kept = []
    for j, each in enumerate(now):
        if j in number:
            kept.append(_judged(replace(each, id=number[j]), of[j]))
        else:
            kept.append(replace(each, id=following))
            following += 1
    return sorted([*kept, *judged], key=lambda each: each.id)


def _judged(now: Finding, before: Sequence[Finding]) -> Finding:
    """Return a finding with what was decided on those in its place."""
    remarks = dict.fromkeys(each.remark for each in before if each.remark)
    status = max((each.status for each in before), key=WEIGHTS.index)
    if status == DISMISSED and has_grown(before, now, MOSTLY):
        status = UNDER_REVIEW
        remarks[f"dismissed when it was {kind_of(now.kind).size_in_words(before[0])}"] = None
    return replace(now, status=status, remark="; ".join(remarks))


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
