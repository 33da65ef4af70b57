"""What has changed since the last survey."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Sequence

import numpy as np

from flight_basics.errors import ReportError
from inspection.findings.findings_file import DISMISSED
from inspection.findings.kinds import kind_of
from inspection.findings.merging import Finding
from inspection.findings.pairing import pairs_of
from inspection.report.sources import Inspection
from inspection.survey.surface_record import SurfaceRecord

APPEARED, GROWN, AS_BEFORE, NOT_SEEN_BEFORE = "new", "grown", "as before", "not looked at before"
GROWTH_AREA, GROWTH_LENGTH = 1.25, 1.2
LEAST_GROWTH_M2, LEAST_GROWTH_M = 0.001, 0.03
"""Below these, two photographs of one place may differ."""
LEAST_COMMON, ON_M, FEW = 0.5, 0.3, 5
"""Two surveys of one space have so much of their surface in common; so many findings tell it, too."""


@dataclass(frozen=True)
class Comparison:
    """Changes by the finding's number, and the last survey's findings that have none now.

    last: (now's number -> last survey's finding). gone: the photographs show the place. unseen: they do not.
    """

    change: dict[int, str] = field(default_factory=dict)
    last: dict[int, Finding] = field(default_factory=dict)
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


def compared(
    last: Sequence[Finding],
    now: Sequence[Finding],
    last_surface: SurfaceRecord | None,
    surface: SurfaceRecord | None,
) -> Comparison:
    """Compare two surveys in the same map. Without a surface record no place counts as looked at."""
    pairs = pairs_of(last, now)
    of = {now[j].id: last[i] for i, j in pairs}
    missing = [each for k, each in enumerate(last) if k not in {i for i, _ in pairs}]
    missing = [each for each in missing if each.status != DISMISSED]
    looked = _looked_at(missing, surface)
    before = _looked_at(now, last_surface)
    change = {}
    for each, was in zip(now, before):
        if each.id in of:
            change[each.id] = GROWN if _grown(of[each.id], each) else AS_BEFORE
        else:
            change[each.id] = APPEARED if was else NOT_SEEN_BEFORE
    gone = tuple(each for each, seen in zip(missing, looked) if seen)
    return Comparison(change, of, gone, tuple(each for each, seen in zip(missing, looked) if not seen))


def _grown(last: Finding, now: Finding) -> bool:
    if kind_of(now.kind).is_sized_by_area:
        return now.area_m2 > max(GROWTH_AREA * last.area_m2, last.area_m2 + LEAST_GROWTH_M2)
    return now.length_m > max(GROWTH_LENGTH * last.length_m, last.length_m + LEAST_GROWTH_M)


def _looked_at(findings: Sequence[Finding], surface: SurfaceRecord | None) -> list[bool]:
    if surface is None or not findings:
        return [False] * len(findings)
    places = np.array([each.position_m for each in findings])
    on = surface.patches_at(places, np.array([each.normal for each in findings]))
    return [bool(k >= 0 and surface.is_shown[k]) for k in on]
