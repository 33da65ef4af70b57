"""The tables of the page, in a surveyor's words."""

from __future__ import annotations

from typing import Any, Mapping, Sequence
from urllib.parse import quote

import numpy as np

from inspection.files.coverage_record import CoverageRecord
from inspection.findings.kinds import kind_of
from inspection.findings.merging import SURE, Finding
from inspection.findings.picture.on_pictures import MarkedPicture
from inspection.report.comparison import Comparison
from inspection.report.gauging.spots import close_up_spots
from inspection.report.grades import GradeRules, PlateState
from inspection.report.pictures import data_uri
from inspection.report.sources import Inspection
from inspection.ship.ship import SIDES, Ship
from inspection.survey.plan import SurveyPlan
from inspection.survey.surface_record import SurfaceRecord

SHARES = (0.0, 0.005, 0.03, 0.15)
"""Rusted shares of a plate above which the table's colour gets darker."""
LEAST_SEEN = 0.5
MOST_ROWS = 25
NO_PLATE = "on no plate of the ship's file: frames, stiffeners, floors and what stands inside"
NO_PLATES = "the whole space: no ship's file divides it into plates"
SIDE_NAMES = {"P": "Port", "S": "Starboard"}


def size_of(finding: Finding) -> str:
    """Return the size as one says it."""
    return kind_of(finding.kind).size_in_words(finding)


def finding_rows(
    findings: Sequence[Finding],
    ship: Ship,
    surface: SurfaceRecord | None,
    cuts: Mapping[int, bytes],
    comparison: Comparison | None,
) -> list[dict[str, Any]]:
    """Return a row for each finding, the largest first, those that were dismissed last."""
    order = {"confirmed": 0, "under review": 1, "new": 2, "dismissed": 3}
    rows = []
    things = _things(findings, surface, ship)
    for each, thing in zip(findings, things):
        place, kind = ship.describe(each.position_m, each.normal), kind_of(each.kind).word
        place += f", \N{PLUS-MINUS SIGN} {SURE * each.deviation_m:.2f} m" if each.deviation_m else ""
        change, was = "", ""
        if comparison:
            change = comparison.change.get(each.id, "")
            told = [
                size_of(one) + ("" if one.status in ("new", each.status) else f", {one.status}")
                for one in comparison.last.get(each.id, ())
            ]
            was = f"was {' and '.join(told)}" if told else ""
        rows.append(
            {
                "id": each.id, "kind": kind, "place": place, "thing": thing, "size": size_of(each),
                "status": each.status, "remark": each.remark, "photographs": len(each.photographs),
                "change": change, "was": was, "told": f"Finding {each.id}: {kind}, {size_of(each)}. {place}.",
                "picture": data_uri(cuts[each.id]) if each.id in cuts else "",
                "order": (order[each.status], each.kind, -each.area_m2, -each.length_m),
            }
        )  # fmt: skip
    return sorted(rows, key=lambda row: row["order"])


def rows_without_pose(marked: Sequence[MarkedPicture], beside: str) -> list[dict[str, str]]:
    """Return a row for each photograph that was searched without a pose and shows something.

    beside: where the photographs lie, from the page.
    """
    rows = []
    for each in marked:
        kinds = [kind_of(mark.kind).word for mark in each.marks]
        if kinds:
            told = ", ".join(f"{kinds.count(kind)} x {kind}" for kind in sorted(set(kinds)))
            largest = max(each.marks, key=lambda mark: mark.size_px)
            left, top, right, bottom = largest.box_px
            kind = kind_of(largest.kind).word
            at = f"{kind}, {left} to {right} px across, {top} to {bottom} px down"
            rows.append(
                {
                    "name": each.photograph,
                    "href": quote(beside + each.photograph),
                    "told": told,
                    "largest": at,
                }
            )
    return rows


def _things(findings: Sequence[Finding], surface: SurfaceRecord | None, ship: Ship) -> list[str]:
    """Return the name of the thing that each finding is on."""
    if surface is None or not findings:
        return [""] * len(findings)
    places = np.array([each.position_m for each in findings])
    on = surface.patches_at(places, np.array([each.normal for each in findings]), 0.3)
    return [ship.part(surface.names[surface.parts[k]]) if k >= 0 else "" for k in on]


def comparison_table(comparison: Comparison, ship: Ship) -> dict[str, Any]:
    """Return the numbers of changes, and the last survey's findings that are gone or were not seen."""
    counts: dict[str, int] = {}
    for change in comparison.change.values():
        counts[change] = counts.get(change, 0) + 1
    words = [f"{number} {change}" for change, number in sorted(counts.items())]
    words += [f"{len(comparison.gone)} gone", f"{len(comparison.unseen)} not looked at again"]
    groups = (
        ("Gone: the new photographs show the place", comparison.gone),
        ("Not looked at again", comparison.unseen),
    )
    return {
        "told": "Findings: " + ", ".join(words) + ".",
        "groups": [
            {
                "name": name,
                "rows": [
                    {
                        "id": each.id, "kind": kind_of(each.kind).word, "size": size_of(each),
                        "place": ship.describe(each.position_m, each.normal), "status": each.status,
                        "remark": each.remark,
                    }
                    for each in group
                ],
            }
            for name, group in groups
            if group
        ],
    }  # fmt: skip


def matrices(ship: Ship, plates: Sequence[PlateState]) -> list[dict[str, Any]]:
    """Return a table of strakes by frames for each side."""
    tables = []
    for side in SIDES:
        own = {(each.plate.strake, each.plate.first): each for each in plates if each.plate.side == side}
        columns = sorted({(each.plate.first, each.plate.last) for each in own.values()})
        names = [each.name for each in ship.strakes if any(key[0] == each.name for key in own)]
        rows = [
            {"name": name, "cells": [_cell(own.get((name, first))) for first, _ in columns]}
            for name in reversed(names)
        ]
        if rows:
            heads = [f"{first}\N{EN DASH}{last}" for first, last in columns]
            tables.append({"name": SIDE_NAMES[side], "columns": heads, "rows": rows})
    return tables


def _cell(state: PlateState | None) -> dict[str, str] | None:
    if state is None or (state.area_m2 < 0.05 and not state.findings):
        return None
    seen = state.seen_m2 / state.area_m2 if state.area_m2 > 0.0 else 0.0
    look = f"r{sum(state.rust_share > share for share in SHARES)}"
    numbers = ", ".join(str(each) for each in state.findings)
    told = f"{state.plate.text}: {state.area_m2:.1f} m², {100 * seen:.0f} % seen"
    return {
        "look": look if seen >= LEAST_SEEN else "unseen",
        "text": f"{100 * state.rust_share:.1f} %" if state.seen_m2 > 0.0 else "\N{EN DASH}",
        "more": f"{len(state.findings)} findings"
        if len(state.findings) > 1
        else "1 finding"
        if numbers
        else "",
        "told": told + (f"; findings {numbers}" if numbers else ""),
    }


def close_up_rows(findings: Sequence[Finding], ship: Ship) -> list[dict[str, Any]]:
    """Return the findings proposed for a close-up."""
    return [
        {
            "id": each.id,
            "why": why,
            "place": ship.describe(each.position_m, each.normal),
            "size": size_of(each),
        }
        for each, why in close_up_spots(findings)
    ]


def unseen_tables(inspection: Inspection, ship: Ship) -> dict[str, Any]:
    """Return what was not seen: within reach by place, and out of reach with the plan's reasons."""
    surface, coverage = inspection.surface, inspection.coverage or CoverageRecord()
    words = coverage.in_words
    if words and coverage.resolution_mm_per_px is not None:
        words.append(
            f"A surface counts as shown at {coverage.resolution_mm_per_px:g} mm per pixel or finer and up to "
            f"{coverage.incidence_deg or 0:g}° from square."
        )
    opened: list[dict[str, Any]] = []
    if surface is not None:
        unreachable_m2 = float((surface.areas_m2 * (1.0 - surface.reachable)).sum())
        words.append(f"{unreachable_m2:,.0f} m² of the surface are out of reach.")
        if coverage.mesh_m2 is not None:
            words.append(
                f"The surface is that of the room in which the UAV flies, {surface.areas_m2.sum():,.0f} m². "
                f"The whole mesh has {coverage.mesh_m2:,.0f} m², both sides of its sheets."
            )
        opened = _open_rows(surface, ship)
    left_out = left_out_rows(inspection.plan, ship) if inspection.plan else []
    not_taken = _not_taken(inspection, ship)
    if not words and not left_out:
        words.append("It is not known what was not seen.")
    return {"words": words, "open": opened, "left_out": left_out, "not_taken": not_taken}


def _not_taken(inspection: Inspection, ship: Ship) -> list[dict[str, str]]:
    """Return the photographs of the plan that the flight left out, by its record."""
    held = inspection.result.inspection if inspection.result else None
    views = inspection.plan.views if inspection.plan else ()
    rows = []
    for each in held.left_out if held else ():
        known = 0 < each.photograph <= len(views)
        place = ship.describe(views[each.photograph - 1].place_m) if known else ""
        rows.append({"number": str(each.photograph), "place": place, "why": each.why})
    return rows


def _open_rows(surface: SurfaceRecord, ship: Ship) -> list[dict[str, Any]]:
    missing = surface.open_m2 > 0.0
    points, areas = surface.points_m[missing], surface.open_m2[missing]
    plates, of = ship.plates(), ship.plates_of(points, surface.normals[missing])
    no_plate = NO_PLATE if len(plates) else NO_PLATES
    rows: list[dict[str, Any]] = []
    for number in np.unique(of):
        area_m2 = float(areas[of == number].sum())
        rows.append({"place": plates[number].text if number >= 0 else no_plate, "area_m2": area_m2})
    rows.sort(key=lambda row: -row["area_m2"])
    rest = rows[MOST_ROWS:]
    if rest:
        total = sum(row["area_m2"] for row in rest)
        rows = [*rows[:MOST_ROWS], {"place": f"{len(rest)} further plates", "area_m2": total}]
    return [row for row in rows if row["area_m2"] >= 0.05]


def left_out_rows(plan: SurveyPlan, ship: Ship) -> list[dict[str, Any]]:
    """Return what cannot be photographed by a plan, by part and reason, the largest first."""
    groups: dict[tuple[str, str], list] = {}
    for each in plan.leftovers:
        groups.setdefault((each.part, each.why), []).append(each)
    rows = []
    for (part, why), own in groups.items():
        largest = max(own, key=lambda each: each.area_m2)
        rows.append(
            {
                "part": ship.part(part), "why": why, "area_m2": sum(each.area_m2 for each in own),
                "place": ship.describe(largest.place_m),
            }
        )  # fmt: skip
    return sorted((row for row in rows if row["area_m2"] >= 0.05), key=lambda row: -row["area_m2"])


def lowest_grade(grades: Sequence[Any], rules: GradeRules) -> tuple[str, str]:
    """Return the lowest grade of the areas, and how many areas have one."""
    from inspection.report.grades import GRADES

    known = [each.grade for each in grades if each.grade]
    if not known:
        return "\N{EN DASH}", "no area was seen enough"
    lowest, without = max(known, key=GRADES.index), len(grades) - len(known)
    of = f"lowest of {len(known)} graded area{'s' * (len(known) > 1)}"
    return lowest, f"{of}; {without} not graded" if without else of
