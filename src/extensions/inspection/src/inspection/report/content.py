"""Puts together what the page shows of an inspection."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Mapping, Sequence
from urllib.parse import quote

from flight_basics.errors import FlightBasicsError
from inspection.files.coverage_record import MAP, CoverageRecord
from inspection.findings.kinds import FINDING_KINDS, FindingKind, kinds_of
from inspection.findings.merging import Finding
from inspection.photograph_poses.exif import read_exif
from inspection.report import records, tables
from inspection.report.comparison import Comparison, Survey, compared
from inspection.report.gauging.readings import read_readings
from inspection.report.gauging.spots import Gauging, gauging_spots, with_readings
from inspection.report.grades import AreaGrade, GradeRules, PlateState, areas_graded, plates_seen
from inspection.report.pictures import data_uri, small_pictures
from inspection.report.scene import UNKNOWN, Scene, scene_of
from inspection.report.sources import Inspection
from inspection.report.static_view import static_view
from inspection.report.view_data import view_data
from inspection.report.views import best_of, marks_of
from inspection.ship.ship import Ship
from inspection.survey.surface.edges import edge_places
from inspection.survey.surface.mesh_file import Mesh

NOT_KNOWN = "\N{EN DASH}"
STILLS = ((-115.0, "Port side and forward end"), (65.0, "Starboard side and aft end"))
"""Directions from which the still pictures look: from aft of starboard, and from ahead of port."""


@dataclass(frozen=True)
class Judged:
    """An inspection with what follows from it."""

    scene: Scene | None
    grades: Sequence[AreaGrade]
    plates: Sequence[PlateState]
    gaugings: Sequence[Gauging]
    comparison: Comparison | None
    remarks: Sequence[str] = ()


def judged(
    inspection: Inspection,
    ship: Ship,
    mesh: Mesh | None,
    last: Inspection | None,
    readings: Path | None,
    rules: GradeRules,
) -> Judged:
    """Return grades, plates, spots for thickness measurement and the comparison.

    Raises:
        ReportError: the file of readings cannot be used.
    """
    surface, findings = inspection.seen, inspection.findings
    scene = None if mesh is None else scene_of(mesh, inspection.surface)
    grades: Sequence[AreaGrade] = ()
    plates: Sequence[PlateState] = ()
    if surface is not None and findings is not None:
        if mesh is not None:
            edges = edge_places(mesh.triangles_m, mesh.joined)
            grades = areas_graded(ship, surface, edges, findings, rules)
            if inspection.red:  # rust may have the coating's colour
                grades = [replace(each, grade=None, other_grade=None) for each in grades]
        plates = plates_seen(ship, surface, findings)
    gaugings, remarks = gauging_spots(plates, rules), list[str]()
    if readings is not None:
        table = read_readings(readings, ship)
        gaugings = with_readings(gaugings, table.rows)
        if table.unused:
            remarks.append(f"Columns of {readings.name} that are not used: {', '.join(table.unused)}.")
    comparison = None
    if last is not None and last.findings is not None and findings is not None:
        comparison = compared(
            Survey(last.findings, last.seen, last.blind), Survey(findings, surface, inspection.blind)
        )
    if last is not None and comparison is None:
        remarks.append("There is no comparison: this survey has no findings.")
    return Judged(scene, grades, plates, gaugings, comparison, remarks)


def page_content(
    inspection: Inspection, ship: Ship, known: Judged, rules: GradeRules, out: Path
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what the page's template names, and what its viewer draws."""
    findings = inspection.findings or ()
    marks = marks_of(findings, inspection.shots, inspection.camera) if inspection.camera else []
    best = best_of(marks)
    thumbs, cuts, damaged = small_pictures(inspection.shots, best)
    remarks = [*inspection.remarks, *known.remarks]
    if damaged:
        remarks.append(f"{len(damaged)} photographs are damaged, the first {damaged[0]}.")
    lacking = len(inspection.shots) - len(thumbs) - len(damaged)
    if lacking:
        remarks.append(
            f"{lacking} of {len(inspection.shots)} photographs have no small picture here: the page would "
            "be too large. Their names open the originals."
        )
    if len(cuts) < len(best):
        remarks.append(
            f"{len(best) - len(cuts)} of {len(best)} findings have no picture here for the same reason."
        )
    if known.scene is None:
        remarks.append("No drawing of the surface was given, so there is no view of it.")
    remarks += records.mishaps(inspection)
    beside = _relative(inspection.photographs, out.parent) + "/"
    content = {
        "title": ship.name or "Inspection",
        "subtitle": ", ".join(each for each in (ship.space, _date(inspection)) if each),
        "figures": _figures(inspection, known, rules),
        "remarks": remarks,
        "stills": _stills(inspection, known.scene, ship),
        "particulars": ship.particulars_table(_serial(inspection)),
        "has_surface": inspection.surface is not None,
        "has_ship": bool(ship.frames),
        "grades": known.grades,
        "rules": rules,
        "matrices": tables.matrices(ship, known.plates),
        "findings": tables.finding_rows(findings, ship, inspection.surface, cuts, known.comparison),
        "without_pose": tables.rows_without_pose(inspection.without_pose, beside),
        "has_unposed": bool(inspection.without_pose),
        "marked": records.counted(len(inspection.without_pose), "photograph"),
        "searched": inspection.findings is not None,
        "counted_kinds": FINDING_KINDS,
        "kinds": kinds_of(each.kind for each in findings),
        "comparison": tables.comparison_table(known.comparison, ship) if known.comparison else None,
        "close_ups": tables.close_up_rows(findings, ship),
        "gaugings": [row for each in known.gaugings for row in each.rows()],
        "unseen": tables.unseen_tables(inspection, ship),
        "flights": records.flights(inspection),
        "quality": records.quality(inspection),
        "thumbs": _thumbs(inspection, thumbs, ship, out),
        "basis": records.basis(inspection),
        "written": datetime.now(UTC).strftime("%d %B %Y, %H:%M UTC"),
        "beside": beside,
    }
    view = view_data(known.scene, inspection.shots, inspection.camera, findings, marks, best)
    return content, view


def _serial(inspection: Inspection) -> dict[str, str]:
    """Return the camera's serial number as the first photograph tells it, if it does."""
    with suppress(FlightBasicsError):
        serial = read_exif(inspection.shots[0].path).serial if inspection.shots else ""
        return {"camera": f"serial number {serial} (told by the photographs)"} if serial else {}
    return {}


def _relative(path: Path, folder: Path) -> str:
    return os.path.relpath(path.resolve(), folder.resolve())


def _date(inspection: Inspection) -> str:
    """Return the date in result.json, or that of the newest photograph's file."""
    if inspection.result and inspection.result.date:
        return inspection.result.date
    if not inspection.shots:
        return ""
    newest = max(shot.path.stat().st_mtime for shot in inspection.shots)
    return datetime.fromtimestamp(newest, UTC).strftime("%d %B %Y")


def _figure_of_kind(kind: FindingKind, findings: Sequence[Finding], waiting: int) -> dict[str, str]:
    """Return how many findings of a kind there are. waiting: those of any kind that wait for a decision."""
    own = [each for each in findings if each.kind == kind.name]
    if kind.is_sized_by_area:
        more = f"{sum(each.area_m2 for each in own):.2f} m² in all"
    else:
        more = f"{records.counted(waiting, 'finding')} to be decided"
    return {"name": kind.heading, "value": str(len(own)), "more": more}


def _figures(inspection: Inspection, known: Judged, rules: GradeRules) -> list[dict[str, str]]:
    grade, of = tables.lowest_grade(known.grades, rules)
    coverage = inspection.coverage or CoverageRecord()
    share, reachable = coverage.share_of_reachable, coverage.reachable_m2
    seen, whole = (NOT_KNOWN, "not determined")
    if inspection.unsearched:
        whole = "not all photographs were searched"
    elif share is not None and reachable is not None:
        seen, whole = f"{100 * share:.1f} %", f"of {reachable:,.0f} m² within reach{_reference(coverage)}"
    findings = [each for each in inspection.findings or () if each.status != "dismissed"]
    waiting = sum(each.status in ("new", "under review") for each in findings)
    proposed = [each for each in known.gaugings if each.is_proposed]
    measured = len([each for each in known.gaugings if each.readings])
    above = sum(each.rust_share >= rules.pitting for each in known.plates)
    if inspection.findings is None:
        marks = [{"name": kind.heading, "value": NOT_KNOWN, "more": "not searched"} for kind in FINDING_KINDS]
    else:
        marks = [_figure_of_kind(kind, findings, waiting) for kind in FINDING_KINDS]
    return [
        {"name": "Lowest proposed grade", "value": grade, "more": of},
        {"name": "Surface seen", "value": seen, "more": whole},
        *marks,
        {
            "name": "Plates to gauge",
            "value": str(len(proposed)) if known.plates else NOT_KNOWN,
            "more": f"{above} with rust on {100 * rules.pitting:.0f} % or more"
            + (f"; {records.counted(measured, 'plate')} measured" if measured else ""),
        },
        {"name": "Photographs", "value": str(len(inspection.shots)), "more": _counts_in_words(inspection)},
    ]


def _reference(coverage: CoverageRecord) -> str:
    """Return what a share of the surface is one of, if that is less than a drawing."""
    if coverage.of != MAP:
        return ""
    drawing = coverage.drawing
    if drawing is None or drawing.share_of_reachable is None:
        return " that the flight mapped"
    share = 100 * drawing.share_of_reachable
    return f" that the flight mapped; {share:.1f} % of the drawing's {drawing.reachable_m2:,.0f} m²"


def _counts_in_words(inspection: Inspection) -> str:
    is_lit = all(shot.record.lux is not None for shot in inspection.shots)
    lacking = len(inspection.without_pose)
    told = "with position and light" if is_lit else "with position"
    return f"{told}; {lacking} more without position" if lacking else told


def _stills(inspection: Inspection, scene: Scene | None, ship: Ship) -> list[dict[str, str]]:
    if scene is None or not len(scene.triangles_m):
        return []
    closed = bool((scene.states != UNKNOWN).any())
    return [
        {
            "src": data_uri(
                static_view(scene, inspection.findings or (), ship.heading_deg + angle, closed=closed),
                "image/png",
            ),
            "told": told if ship.frames else f"View from {angle % 360:.0f}° to the x axis",
        }
        for angle, told in STILLS
    ]


def _thumbs(
    inspection: Inspection, thumbs: Mapping[int, bytes], ship: Ship, out: Path
) -> list[dict[str, Any]]:
    return [
        {
            "number": number,
            "name": shot.path.name,
            "href": quote(_relative(shot.path, out.parent)),
            "src": data_uri(thumbs[number]) if number in thumbs else "",
            "place": ship.describe(shot.record.position_m),
        }
        for number, shot in enumerate(inspection.shots)
    ]
