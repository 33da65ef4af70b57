"""Spots proposed for close-up survey and for thickness measurement, and the readings taken there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, Sequence

from inspection.findings.findings_file import CONFIRMED, DISMISSED
from inspection.findings.kinds import kind_of
from inspection.findings.merging import Finding
from inspection.report.gauging.readings import Reading
from inspection.report.grades import GradeRules, PlateState
from inspection.ship.ship import Plate

RUSTIEST = 5
"""Plates proposed besides those above the limit, if they are rusted at all."""
THICKER = 1.1
"""A reading above so many times the original thickness is no plate of that thickness."""
MEASURED = "measured"


@dataclass(frozen=True)
class Gauging:
    """Thickness of one plate. readings: all that were taken; the least of them is the official one."""

    plate: Plate
    why: str
    readings: tuple[Reading, ...] = ()

    @property
    def is_proposed(self) -> bool:
        """Whether the photographs are the reason."""
        return self.why != MEASURED

    @property
    def official(self) -> Reading | None:
        """The row with the least reading; None: nothing was measured."""
        return min(self.readings, key=lambda each: each.least_mm or math.inf, default=None)

    def original_mm(self, reading: Reading) -> float | None:
        """Return the original thickness for a reading: its own, or the one that the others all tell."""
        told = {each.original_mm for each in self.readings if each.original_mm is not None}
        return reading.original_mm or (told.pop() if len(told) == 1 else None)

    def diminution_mm(self, reading: Reading) -> float | None:
        """Return what the lower reading lacks of the original thickness, at least 0; None: not known."""
        original_mm, least_mm = self.original_mm(reading), reading.least_mm
        if original_mm is None or least_mm is None or least_mm > THICKER * original_mm:
            return None
        return max(original_mm - least_mm, 0.0)

    def rows(self) -> list[GaugingRow]:
        """Return a row of the table for each reading, or one that is to be filled."""
        return [self._row(each) for each in self.readings] or [GaugingRow(self.plate.text, self.why)]

    def _row(self, reading: Reading) -> GaugingRow:
        original_mm, lost_mm = self.original_mm(reading), self.diminution_mm(reading)
        doubt = []
        if original_mm is not None and lost_mm is None:
            doubt = ["check: it is thicker than the original"]
        elif original_mm is None:
            doubt = ["the original thickness is not given"]
        return GaugingRow(
            self.plate.text,
            self.why,
            reading.frame,
            original_mm,
            reading.forward_mm,
            reading.aft_mm,
            lost_mm,
            None if lost_mm is None or original_mm is None else lost_mm / original_mm,
            "; ".join([*([reading.remark] if reading.remark else []), *doubt]),
            len(self.readings) > 1 and reading is self.official,
        )


class GaugingRow(NamedTuple):
    """A row of the table of thickness. lost_mm, lost: of the lower reading. is_least: of a plate's rows."""

    plate: str
    why: str
    frame: str = ""
    original_mm: float | None = None
    forward_mm: float | None = None
    aft_mm: float | None = None
    lost_mm: float | None = None
    lost: float | None = None
    remark: str = ""
    is_least: bool = False


def gauging_spots(plates: Sequence[PlateState], rules: GradeRules) -> list[Gauging]:
    """Return the plates whose thickness is to be measured: above the limit, and the most rusted others."""
    worst = sorted((each for each in plates if each.rust_m2 > 0.0), key=lambda each: -each.rust_share)
    above = [each for each in worst if each.rust_share >= rules.pitting]
    others = [each for each in worst if each.rust_share < rules.pitting][:RUSTIEST]
    limit = f"rust on {100 * rules.pitting:.0f} % of the plate or more"
    return [Gauging(each.plate, limit) for each in above] + [
        Gauging(each.plate, "among the most rusted plates") for each in others
    ]


def close_up_spots(findings: Sequence[Finding], most: int = 30) -> list[tuple[Finding, str]]:
    """Return findings for a confirmatory close-up with the reason: lines, others, then the largest rust."""
    stand = [each for each in findings if each.status != DISMISSED]
    kinds = [kind_of(each.kind) for each in stand]
    lines = [each for each, kind in zip(stand, kinds) if kind.is_line]
    rust = [each for each, kind in zip(stand, kinds) if kind.counts_for_coating]
    others = [each for each in stand if each not in lines and each not in rust]
    lines.sort(key=lambda each: (each.status == CONFIRMED, -each.length_m))
    rust.sort(key=lambda each: -each.area_m2)
    return [(each, kind_of(each.kind).close_up) for each in (*lines[:most], *others, *rust[:RUSTIEST])]


def with_readings(spots: Sequence[Gauging], readings: Sequence[Reading]) -> list[Gauging]:
    """Return the spots with all readings; a plate that was not proposed is added."""
    found = {each.plate: each for each in spots}
    for reading in readings:
        spot = found.get(reading.plate, Gauging(reading.plate, MEASURED))
        found[reading.plate] = replace(spot, readings=(*spot.readings, reading))
    return list(found.values())
