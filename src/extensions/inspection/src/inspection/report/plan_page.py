"""The page that a surveyor reads and signs before the flight: what is photographed, and what is not."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from inspection.report.page import filled, write_page
from inspection.report.pictures import data_uri
from inspection.report.tables import left_out_rows
from inspection.report.words import counted
from inspection.ship.ship import Ship
from inspection.survey.picture import plan_png
from inspection.survey.plan import SurveyPlan
from inspection.survey.surface.mesh_file import NOT_SURVEYED
from inspection.survey.surface.patches import Patches

DPI = 130
NONE = "\N{EN DASH}"


def write_plan_page(path: Path, plan: SurveyPlan, patches: Patches | None, ship: Ship | None = None) -> None:
    """Write the page. patches: of the plan's surface; None: the page has no picture.

    Raises:
        ReportError: it cannot be written.
    """
    write_page(path, filled("plan.html", **plan_content(plan, patches, ship or Ship())))


def plan_content(plan: SurveyPlan, patches: Patches | None, ship: Ship) -> dict[str, Any]:
    """Return what `plan.html` names."""
    rows, left_out = flight_rows(plan, ship), left_out_rows(plan, ship)
    return {
        "title": ship.name or "Inspection",
        "subtitle": ", ".join(each for each in (ship.space, Path(plan.source).name) if each),
        "figures": _figures(plan, rows, left_out),
        "picture": data_uri(plan_png(plan, patches, DPI), "image/png") if patches is not None else "",
        "asked": _asked(plan),
        "particulars": ship.particulars_table(),
        "flights": rows,
        "reserve": plan.flying.reserve,
        "shares": [
            {"part": ship.part(name), "share": share}
            for name, share in plan.shares.items()
            if name != NOT_SURVEYED
        ],
        "left_out": left_out,
        "is_draft": plan.draft is not None,
        "written": datetime.now(UTC).strftime("%d %B %Y, %H:%M UTC"),
    }


def flight_rows(plan: SurveyPlan, ship: Ship) -> list[dict[str, Any]]:
    """Return a row for each flight. battery: share of a full one. numbers: of photographs."""
    rows, first = [], 1
    for number, flight in enumerate(plan.flights, start=1):
        last = first + len(flight.views) - 1
        used = flight.time_s / plan.flying.endurance_s
        rows.append(
            {
                "number": number,
                "photographs": len(flight.views),
                "numbers": f"{first} to {last}" if last > first else str(first),
                "begins": ship.describe(flight.views[0].view.place_m) if flight.views else NONE,
                "time_min": flight.time_s / 60.0,
                "way_m": flight.way_m,
                "battery": used,
                "energy_wh": used * plan.flying.battery,
            }
        )
        first = last + 1
    return rows


def _figures(plan: SurveyPlan, rows: list[dict[str, Any]], left_out: list[dict[str, Any]]) -> list[dict]:
    share, reachable_m2 = plan.figures.get("share"), plan.figures.get("reachable_m2")
    seen = NONE if share is None else f"{100.0 * share:.1f} %"
    whole = "not computed" if reachable_m2 is None else f"of {reachable_m2:,.0f} m\u00b2 within reach"
    if "mesh_m2" in plan.figures:
        whole += f"; the {plan.reference} has {plan.figures['mesh_m2']:,.0f} m\u00b2"
    unreachable_m2 = sum(row["area_m2"] for row in left_out)
    flights = counted(len(rows), "flight") + ("; more are planned during it" if plan.draft else "")
    area = f"{unreachable_m2:,.0f} m\u00b2"
    unreachable = (NONE, "not known yet") if plan.draft else (area, "reasons below")
    time_min = sum(row["time_min"] for row in rows)
    return [
        {"name": "Photographs", "value": str(len(plan.views)), "more": f"in {flights}"},
        {"name": "Surface to be seen", "value": seen, "more": whole},
        {"name": "Cannot be photographed", "value": unreachable[0], "more": unreachable[1]},
        {"name": "Time in the air", "value": f"{time_min:.0f} min", "more": "without changes of battery"},
        {
            "name": "Energy",
            "value": f"{sum(row['energy_wh'] for row in rows):.0f} Wh",
            "more": f"batteries of {plan.flying.battery:.0f} Wh",
        },
    ]


def _asked(plan: SurveyPlan) -> list[dict[str, str]]:
    asked, flying, camera = plan.asked, plan.flying, plan.camera
    x, y, z = plan.home_m
    names = ("mesh_m2", "room_m3", "other_rooms", "largest_other_room_m3")
    mesh_m2, room_m3, number, largest_m3 = (plan.figures.get(name) for name in names)
    told = []
    if room_m3 is not None and number is not None:
        others = counted(round(number), "other room")
        if number and largest_m3 is not None:
            others += f", the largest of {largest_m3:,.0f} m\u00b3; --home chooses another one"
        told.append(("Room", f"{room_m3:,.0f} m\u00b3 in which the UAV fits; {others}"))
    if mesh_m2 is not None:
        told.append(
            (
                f"The whole {plan.reference}",
                f"{mesh_m2:,.0f} m\u00b2, in this room or not, with both sides of sheets",
            )
        )
    rows = (
        *told,
        ("Detail", f"{asked.resolution:g} mm of the surface per pixel or finer, in the worst direction"),
        ("Direction of view", f"up to {asked.incidence:g}\u00b0 from square"),
        ("Camera", f"{camera.width} x {camera.height} px, {camera.field_of_view:g}\u00b0 across the width"),
        ("Kept from every surface", f"{asked.radius + asked.margin:g} m from the middle of the UAV"),
        ("Shoots", f"in passing, at {flying.passing_speed:g} m/s" if flying.passing else "at rest"),
        ("Take-off and landing", f"x {x:.1f}, y {y:.1f}, z {z:.1f} m"),
    )
    return [{"name": name, "value": value} for name, value in rows]
