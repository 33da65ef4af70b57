"""What the records tell of flights, photographs and programs, for the page."""

from __future__ import annotations

import platform
import statistics
from importlib import metadata
from pathlib import Path
from typing import Any, Sequence

from inspection.files.run_record import Explored, FlownFlight, RunRecord, Surveyed
from inspection.report.sources import Inspection
from inspection.report.words import counted

COLUMNS = ("time_min", "way_m", "battery_start", "battery_end")
"""Of the table of flights. A column without a value is left out."""
PACKAGES = ("numpy", "scipy", "embreex", "pillow", "trimesh")


def flights(inspection: Inspection) -> dict[str, Any]:
    """Return the flights of result.json, or else those of the plan."""
    result, told = inspection.result or RunRecord(), list[str]()
    told += _explored(result.exploration)
    if result.inspection is not None:
        told += _flown(result.inspection, len(inspection.plan.views) if inspection.plan else 0)
    if result.flights:
        told.append(f"{counted(len(result.flights), 'flight')} as flown, each on one battery:")
        return {"told": told, **_table(result.flights)}
    if inspection.plan:
        planned = [FlownFlight(len(e.views), "", e.time_s, e.way_m) for e in inspection.plan.flights]
        told.append(f"{counted(len(planned), 'flight')} as planned, each on one battery:")
        return {"told": told, **_table(planned)}
    return {"told": told or ["The flights are not recorded."], **_table([])}


def _explored(whole: Explored | None) -> list[str]:
    """Return in words what the record tells of the flight before the photographs, which mapped the space."""
    if whole is None or whole.known_m3 is None:
        return []
    words = f"Before the photographs, {whole.known_m3:,.0f} m³ of the space were mapped in flight"
    if whole.home_s is not None:
        words += f", in {whole.home_s / 60.0:.1f} min"
    areas: dict[str, float] = {}
    for each in whole.unknown:
        areas[each.why] = areas.get(each.why, 0.0) + each.border_m2
    left = "; ".join(f"{area:.1f} m²: {why}" for why, area in areas.items())
    return [
        f"{words}. Openings into what stays unknown: {left}." if left else f"{words}. All of it is known."
    ]


def _flown(whole: Surveyed, planned: int) -> list[str]:
    """Return in words what the record tells of the flights together. planned: photographs of the plan."""
    words = []
    if whole.taken is not None and whole.asked is not None:
        again = f", in {counted(whole.shots, 'shot')}" if whole.shots is not None else ""
        words.append(f"{whole.taken} of {counted(whole.asked, 'photograph')} were taken{again}.")
        if whole.asked < planned:
            words.append(f"Only {whole.asked} of the plan's {planned} photographs were asked for.")
    if whole.flight_s is not None:
        changed = (
            f"; the battery was changed {counted(whole.swaps, 'time')}" if whole.swaps is not None else ""
        )
        words.append(f"The flights took {whole.flight_s / 60.0:.1f} min{changed}.")
    if whole.reason:
        words.append(whole.reason)
    return [" ".join(words)] if words else []


def mishaps(inspection: Inspection) -> list[str]:
    """Return in words what result.json tells of contacts, or of another failure."""
    result, told = inspection.result or RunRecord(), []
    if result.touched:
        parts = ", ".join(each.rsplit("::", 1)[-1].replace("_", " ") for each in result.touched)
        told.append(f"The aircraft touched the structure in flight: {parts}.")
    if result.failure and not any(each in result.failure for each in result.touched):
        told.append(f"The inspection did not end as planned: {result.failure}")
    return told


def _table(flights: Sequence[FlownFlight]) -> dict[str, Any]:
    """Return the rows, and of which columns any row has a value."""
    rows = [_flight_row(number, each) for number, each in enumerate(flights, start=1)]
    has = {name: any(row[name] is not None for row in rows) for name in COLUMNS}
    return {"rows": rows, "has": has}


def _flight_row(number: int, flown: FlownFlight) -> dict[str, Any]:
    return {
        "number": number,
        "photographs": flown.told,
        "time_min": None if flown.time_s is None else flown.time_s / 60.0,
        "way_m": flown.way_m,
        "battery_start": flown.battery_start,
        "battery_end": flown.battery_end,
    }


def quality(inspection: Inspection) -> list[dict[str, str]]:
    """Return light, blur and camera of the photographs."""
    records = [shot.record for shot in inspection.shots]
    if not records:
        return []
    lux = [each.lux for each in records if each.lux is not None]
    light = f"{statistics.median(lux):,.0f} lx (least {min(lux):,.0f})" if lux else "not given"
    if 0 < len(lux) < len(records):
        light += f", of {len(lux)} photographs; of the others it is not given"
    rows = [("Light in the middle of a photograph", light)]
    told = [each.blur_px for each in records if each.shift_m is not None or each.blur_px > 0.0]
    rows.append(("Blur by motion, greatest", f"{max(told):.1f} px" if told else "not given"))
    if inspection.camera:
        camera = inspection.camera
        rows.append(
            ("Camera", f"{camera.width} x {camera.height} px, {camera.field_of_view:.0f}° across the width")
        )
    asked_mm = inspection.coverage.resolution_mm_per_px if inspection.coverage else None
    if asked_mm is not None:
        rows.append(("Asked of a photograph", f"{asked_mm:g} mm per pixel on the surface"))
    return [{"name": name, "value": value} for name, value in rows]


def basis(inspection: Inspection) -> list[dict[str, str]]:
    """Return seed, versions and the drawing of the surface."""
    result = inspection.result or RunRecord()
    told = (
        ("Space", Path(result.world).stem),
        ("Seed", result.seed),
        ("Version of the software", result.commit),
    )
    rows = [("Folder", inspection.folder.resolve().name), *(row for row in told if row[1])]
    versions = result.versions or {
        "Python": platform.python_version(), **{name: _version(name) for name in PACKAGES}
    }  # fmt: skip
    rows.append(("Programs", ", ".join(f"{name} {version}" for name, version in versions.items() if version)))
    if inspection.coverage:
        rows.append(("Surface", inspection.coverage.reference))
    return [{"name": name, "value": value} for name, value in rows]


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""
