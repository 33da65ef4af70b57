"""What has changed since the last survey."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Collection, Sequence

import numpy as np

from flight_basics.errors import ReportError
from inspection.findings.findings_file import DISMISSED
from inspection.findings.merging import Finding
from inspection.findings.pairing import has_grown, meetings_of
from inspection.report.sources import Inspection
from inspection.survey.surface_record import SurfaceRecord

APPEARED, GROWN, AS_BEFORE, NOT_SEEN_BEFORE = "new", "grown", "as before", "not looked at before"
LEAST_COMMON, ON_M, FEW = 0.5, 0.3, 5
"""Two surveys of one space have so much of their surface in common; so many findings tell it, too."""


@dataclass(frozen=True)
class Comparison:
    """Changes by the finding's number, and the last survey's findings that have none now.

    last: (now's number -> last survey's findings there, the nearest first). gone: the photographs show the
    place. unseen: they do not.
    """

    change: dict[int, str] = field(default_factory=dict)
    last: dict[int, tuple[Finding, ...]] = field(default_factory=dict)
    gone: tuple[Finding, ...] = ()
    unseen: tuple[Finding, ...] = ()


def check_comparable(last: Inspection, now: Inspection) -> None:
    """Raise ReportError if the last survey has no findings, or is of another space than this one."""
    if last.findings is None:
        raise ReportError(
            f"{last.folder}: the last survey has no findings to compare with. "
            "Run findings in it, or leave out --last."
        )
    if now.surface is None:
        return
    shares = []
    if last.surface is not None:
        shares = [_on(last.surface, now.surface), _on(now.surface, last.surface)]
    elif len(last.findings) >= FEW:
        places = np.array([each.position_m for each in last.findings])
        shares = [float((now.surface.patches_at(places, None, ON_M) >= 0).mean())]
    if shares and max(shares) < LEAST_COMMON:
        raise ReportError(
            f"{last.folder}: the last survey is of another space, or in another map: {100 * max(shares):.0f} "
            "% of its surface lies where that of this survey does. Give the last survey of this space."
        )


def _on(one: SurfaceRecord, other: SurfaceRecord) -> float:
    """Return the share of a surface, by area, that lies on another one."""
    there = other.patches_at(one.points_m, one.normals, max(one.side_m, other.side_m)) >= 0
    return float(one.areas_m2[there].sum() / max(one.areas_m2.sum(), 1e-9))


def compared(last: Survey, now: Survey) -> Comparison:
    """Compare two surveys in the same map.

    Those that met in one place belong together, even if they have grown into one, or are told in parts now.
    """
    meetings = meetings_of(last.findings, now.findings)
    of: dict[int, list[Finding]] = {}
    for i, j in meetings:
        of.setdefault(now.findings[j].id, []).append(last.findings[i])
    met = {i for i, _ in meetings}
    missing = [each for k, each in enumerate(last.findings) if k not in met and each.status != DISMISSED]
    looked, before = now.looked_at(missing), last.looked_at(now.findings)
    change = {}
    for each, was in zip(now.findings, before):
        if each.id in of:
            change[each.id] = GROWN if has_grown(of[each.id], each) else AS_BEFORE
        else:
            change[each.id] = APPEARED if was else NOT_SEEN_BEFORE
    gone = tuple(each for each, seen in zip(missing, looked) if seen)
    unseen = tuple(each for each, seen in zip(missing, looked) if not seen)
    return Comparison(change, {number: tuple(each) for number, each in of.items()}, gone, unseen)


@dataclass(frozen=True)
class Survey:
    """What is compared of a survey.

    surface: what its photographs show; None: no place counts as looked at. blind: kinds of findings that they
    cannot show, so that none of these counts as looked for.
    """

    findings: Sequence[Finding]
    surface: SurfaceRecord | None
    blind: Collection[str] = ()

    def looked_at(self, findings: Sequence[Finding]) -> list[bool]:
        """Return whether the survey would have shown each of these findings."""
        if self.surface is None or not findings:
            return [False] * len(findings)
        places = np.array([each.position_m for each in findings])
        on = self.surface.patches_at(places, np.array([each.normal for each in findings]))
        return [
            bool(k >= 0 and self.surface.is_shown[k]) and each.kind not in self.blind
            for k, each in zip(on, findings)
        ]
