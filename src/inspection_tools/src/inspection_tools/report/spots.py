"""Spots proposed for close-up survey and for thickness measurement, and the readings taken there."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Mapping, Sequence

from inspection_tools.errors import ReportError
from inspection_tools.findings.findings_file import CONFIRMED, DISMISSED
from inspection_tools.findings.merging import Finding
from inspection_tools.report.grades import GradeRules, PlateState
from inspection_tools.ship.ship import SIDES, Plate, Ship

COLUMNS = ("frame", "strake", "side", "original_mm", "forward_mm", "aft_mm", "remark")
MOST_MM = 500.0
RUSTIEST = 5
"""Plates proposed besides those above the limit, if they are rusted at all."""


@dataclass(frozen=True)
class Gauging:
    """Thickness of one plate: original, forward and aft reading, mm; None: not measured."""

    plate: Plate
    why: str
    original_mm: float | None = None
    forward_mm: float | None = None
    aft_mm: float | None = None
    remark: str = ""

    @property
    def diminution_mm(self) -> float | None:
        """Mean loss of the readings there are, mm."""
        readings = [each for each in (self.forward_mm, self.aft_mm) if each is not None]
        if self.original_mm is None or not readings:
            return None
        return self.original_mm - sum(readings) / len(readings)

    @property
    def diminution_share(self) -> float | None:
        """Loss as a share of the original thickness."""
        lost = self.diminution_mm
        return None if lost is None or not self.original_mm else lost / self.original_mm


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
    """Return findings for a confirmatory close-up with the reason: cracks, then the largest rust."""
    stand = [each for each in findings if each.status != DISMISSED]
    cracks = sorted(
        (e for e in stand if e.kind == "crack"), key=lambda e: (e.status == CONFIRMED, -e.length_m)
    )
    rust = sorted((each for each in stand if each.kind == "rust"), key=lambda each: -each.area_m2)
    others = [each for each in stand if each.kind not in ("crack", "rust")]
    why = {"crack": "possible crack", "rust": "largest rust"}
    chosen = [*cracks[:most], *others, *rust[:RUSTIEST]]
    return [(each, why.get(each.kind, each.kind)) for each in chosen]


def with_readings(spots: Sequence[Gauging], ship: Ship, path: Path) -> list[Gauging]:
    """Return the spots with the readings of a CSV file; a plate that was not proposed is added.

    Raises:
        ReportError: one sentence that names the line and the fault.
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as stream:
            rows = list(csv.DictReader(stream, skipinitialspace=True))
    except OSError as error:
        raise ReportError(f"The readings {path} cannot be read: {error.strerror}.") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise ReportError(f"The readings {path} are not CSV ({error}).") from None
    plates = ship.plates()
    found = {each.plate: each for each in spots}
    for number, row in enumerate(rows, start=2):
        where = f"{path}, line {number}"
        plate = _plate(where, row, plates)
        spot = found.get(plate, Gauging(plate, "measured"))
        values: dict[str, Any] = {key: _thickness(f"{where}, {key}", row.get(key)) for key in COLUMNS[3:6]}
        found[plate] = replace(spot, **values, remark=str(row.get("remark") or ""))
    return list(found.values())


def _plate(where: str, row: Mapping[str, Any], plates: Sequence[Plate]) -> Plate:
    if not {"frame", "strake", "side"} <= set(row):
        raise ReportError(f"{where}: the columns must be {', '.join(COLUMNS)}.")
    frame, strake, side = (str(row[key] or "").strip() for key in ("frame", "strake", "side"))
    if side not in SIDES:
        raise ReportError(f'{where}: the side is "{side}"; give P or S.')
    for each in plates:
        if (
            frame.isdigit()
            and each.first <= int(frame) < each.last
            and (each.strake, each.side) == (strake, side)
        ):
            return each
    raise ReportError(f'{where}: the ship has no plate at frame "{frame}", strake "{strake}".')


def _thickness(where: str, given: object) -> float | None:
    text = str(given or "").strip().replace(",", ".")
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < MOST_MM:
        raise ReportError(f'{where}: "{given}" is no thickness in mm.')
    return value
