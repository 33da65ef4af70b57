"""What the records tell of flights, photographs and programs, for the page."""

from __future__ import annotations

import platform
import statistics
from importlib import metadata
from pathlib import Path
from typing import Any, Mapping, Sequence

from inspection.report.sources import Inspection
from inspection.report.words import counted

COLUMNS = ("time_min", "way_m", "battery_start", "battery_end")
"""Of the table of flights. A column without a value is left out."""
PACKAGES = ("numpy", "scipy", "embreex", "pillow", "trimesh")


def flights(inspection: Inspection) -> dict[str, Any]:
    """Return the flights of result.json, or else those of the plan.

    result.json: flights: [{photographs or purpose, time_s, way_m, battery_start, battery_end}], charges 0..1;
    exploration: {known_m3, home_s, unknown: [{border_m2, why}]}; or inspection: {taken, asked, shots, swaps,
    flight_s, reason}.
    """
    result, told = inspection.result or {}, []
    flown, whole = result.get("flights"), result.get("inspection")
    told += _explored(result.get("exploration"))
    if isinstance(whole, Mapping):
        told += _flown(whole, len(inspection.plan.views) if inspection.plan else 0)
    if isinstance(flown, list) and flown and all(isinstance(each, Mapping) for each in flown):
        told.append(f"{counted(len(flown), 'flight')} as flown, each on one battery:")
        return {"told": told, **_table(flown)}
    if inspection.plan:
        planned = [
            {"photographs": len(each.views), "time_s": each.time_s, "way_m": each.way_m}
            for each in inspection.plan.flights
        ]
        told.append(f"{counted(len(planned), 'flight')} as planned, each on one battery:")
        return {"told": told, **_table(planned)}
    return {"told": told or ["The flights are not recorded."], **_table([])}


def _explored(whole: object) -> list[str]:
    """Return in words what the record tells of the flight before the photographs, which mapped the space."""
    if not isinstance(whole, Mapping) or not isinstance(whole.get("known_m3"), (int, float)):
        return []
    words = f"Before the photographs, {whole['known_m3']:,.0f} m³ of the space were mapped in flight"
    if isinstance(whole.get("home_s"), (int, float)):
        words += f", in {whole['home_s'] / 60.0:.1f} min"
    areas: dict[str, float] = {}
    for each in whole.get("unknown") or ():
        areas[str(each["why"])] = areas.get(str(each["why"]), 0.0) + float(each["border_m2"])
    left = "; ".join(f"{area:.1f} m²: {why}" for why, area in areas.items())
    return [
        f"{words}. Openings into what stays unknown: {left}." if left else f"{words}. All of it is known."
    ]


def _flown(whole: Mapping[str, Any], planned: int) -> list[str]:
    """Return in words what the record tells of the flights together. planned: photographs of the plan."""
    taken, asked, shots, swaps, flight_s = (
        whole.get(key) for key in ("taken", "asked", "shots", "swaps", "flight_s")
    )
    words = []
    if isinstance(taken, int) and isinstance(asked, int):
        again = f", in {counted(shots, 'shot')}" if isinstance(shots, int) else ""
        words.append(f"{taken} of {counted(asked, 'photograph')} were taken{again}.")
        if asked < planned:
            words.append(f"Only {asked} of the plan's {planned} photographs were asked for.")
    if isinstance(flight_s, (int, float)):
        changed = f"; the battery was changed {counted(swaps, 'time')}" if isinstance(swaps, int) else ""
        words.append(f"The flights took {flight_s / 60.0:.1f} min{changed}.")
    if isinstance(whole.get("reason"), str):
        words.append(str(whole["reason"]))
    return [" ".join(words)] if words else []


def mishaps(inspection: Inspection) -> list[str]:
    """Return in words what result.json tells of contacts (touched: names of parts), or of another failure."""
    result, told = inspection.result or {}, []
    touched, failure = result.get("touched"), result.get("failure")
    names = [str(each) for each in touched] if isinstance(touched, list) else []
    if names:
        parts = ", ".join(each.rsplit("::", 1)[-1].replace("_", " ") for each in names)
        told.append(f"The aircraft touched the structure in flight: {parts}.")
    if isinstance(failure, str) and not any(each in failure for each in names):
        told.append(f"The inspection did not end as planned: {failure}")
    return told


def _table(flights: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the rows, and of which columns any row has a value."""
    rows = [_flight_row(number, each) for number, each in enumerate(flights, start=1)]
    has = {name: any(row[name] is not None for row in rows) for name in COLUMNS}
    return {"rows": rows, "has": has}


def _flight_row(number: int, given: Mapping[str, Any]) -> dict[str, Any]:
    def value(key: str, scale: float = 1.0) -> float | None:
        held = given.get(key)
        return scale * held if isinstance(held, (int, float)) and not isinstance(held, bool) else None

    photographs = given.get("photographs")
    return {
        "number": number,
        "photographs": len(photographs)
        if isinstance(photographs, list)
        else photographs or given.get("purpose"),
        "time_min": value("time_s", 1.0 / 60.0),
        "way_m": value("way_m"),
        "battery_start": value("battery_start"),
        "battery_end": value("battery_end"),
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
    coverage = inspection.coverage or {}
    if "resolution_mm_per_px" in coverage:
        rows.append(
            ("Asked of a photograph", f"{coverage['resolution_mm_per_px']:g} mm per pixel on the surface")
        )
    return [{"name": name, "value": value} for name, value in rows]


def basis(inspection: Inspection) -> list[dict[str, str]]:
    """Return seed, versions and the drawing of the surface."""
    result = inspection.result or {}
    rows = [("Folder", inspection.folder.resolve().name)]
    for key, name in (("world", "Space"), ("seed", "Seed"), ("commit", "Version of the software")):
        if isinstance(result.get(key), (str, int)):
            rows.append((name, Path(str(result[key])).stem if key == "world" else str(result[key])))
    versions = result.get("versions")
    if not isinstance(versions, Mapping):
        versions = {"Python": platform.python_version()} | {name: _version(name) for name in PACKAGES}
    rows.append(("Programs", ", ".join(f"{name} {version}" for name, version in versions.items() if version)))
    if inspection.coverage:
        rows.append(("Surface", Path(str(inspection.coverage.get("surface", ""))).name))
    return [{"name": name, "value": value} for name, value in rows]


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""
