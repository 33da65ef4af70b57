"""Writes and reads a plan as YAML, which one may edit."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from flight_basics.errors import SurveyError
from flight_basics.geometry import Vector3
from input_schemas import read_made, structured
from inspection.camera.survey_camera import SurveyCamera
from inspection.files.whole import write_whole
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan import Draft, Flight, Leftover, PlannedView, SurveyPlan
from inspection.survey.views.candidates import View

HEAD = """# A survey plan. Edit photographs, then check: rosrun inspection survey_planner check PLAN
# at: place of the camera in the map, m. yaw: anticlockwise from x, deg. tilt: 0 level, 90 straight up, deg.
# way: corners of the way there from the photograph before, m, if it is not straight.
"""


@dataclass(frozen=True)
class PhotographEntry:
    """A photograph in a plan's file. yaw, tilt: deg. id: for the reader; its place in the list counts."""

    at: Vector3
    yaw: float
    tilt: float
    way: tuple[Vector3, ...] = ()
    id: Any = None

    @property
    def planned(self) -> PlannedView:
        """The photograph in a plan."""
        return PlannedView(View(self.at, math.radians(self.yaw), math.radians(self.tilt)), self.way)


@dataclass(frozen=True)
class FlightEntry:
    """A flight in a plan's file; see `Flight`."""

    photographs: tuple[PhotographEntry, ...]
    time_s: float = 0.0
    way_m: float = 0.0


@dataclass(frozen=True)
class LeftoverEntry:
    """What no photograph can show, in a plan's file; see `Leftover`."""

    part: str
    why: str
    area_m2: float
    at: Vector3


@dataclass(frozen=True)
class PlanFile:
    """The file of a plan; see `SurveyPlan`."""

    home: Vector3
    flights: tuple[FlightEntry, ...]
    source: str = ""
    camera: SurveyCamera = field(default_factory=SurveyCamera)
    asked: SurveyParameters = field(default_factory=SurveyParameters)
    flying: FlightParameters = field(default_factory=FlightParameters)
    figures: dict[str, float] = field(default_factory=dict)
    shares: dict[str, float] = field(default_factory=dict)
    left_out: tuple[LeftoverEntry, ...] = ()
    draft: Draft | None = None


def write_plan(path: Path, plan: SurveyPlan) -> None:
    """Write a plan.

    Raises:
        SurveyError: the file cannot be written.
    """
    import yaml

    content = {
        "source": plan.source,
        "home": [round(v, 3) for v in plan.home_m],
        "camera": {key: value for key, value in asdict(plan.camera).items() if key != "lens"},
        "asked": asdict(plan.asked),
        "flying": asdict(plan.flying),
        "figures": {key: round(value, 4) for key, value in plan.figures.items()},
        "shares": {key: round(value, 4) for key, value in plan.shares.items()},
        "left_out": [
            {
                "part": o.part,
                "why": o.why,
                "area_m2": round(o.area_m2, 3),
                "at": [round(v, 2) for v in o.place_m],
            }
            for o in plan.leftovers
        ],
    }
    if plan.draft is not None:
        content["draft"] = asdict(plan.draft)
    lines = [HEAD, yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=110), "flights:\n"]
    number = 0
    for flight in plan.flights:
        lines.append(f"- time_s: {flight.time_s:.0f}\n  way_m: {flight.way_m:.1f}\n  photographs:\n")
        for each in flight.views:
            number += 1
            v = each.view
            at = ", ".join(f"{c:.3f}" for c in v.place_m)
            way = f", way: {[list(c) for c in each.way_m]}" if each.way_m else ""
            lines.append(
                f"  - {{id: {number}, at: [{at}], yaw: {math.degrees(v.yaw_rad):.2f}, "
                f"tilt: {math.degrees(v.tilt_rad):.2f}{way}}}\n"
            )
    try:
        write_whole({path: "".join(lines).encode()})
    except OSError as error:
        raise SurveyError(f"{path} cannot be written: {error.strerror}.") from None


def read_plan(path: Path) -> SurveyPlan:
    """Read a plan.

    Raises:
        SurveyError: it cannot be read or makes no sense; the sentence names the file and the photograph.
    """
    return read_made(path, "The plan", parse_plan, SurveyError)


def parse_plan(content: object) -> SurveyPlan:
    """Return the plan in the content of a YAML file.

    Raises:
        SurveyError: one sentence that names the photograph and the fault.
    """
    told = structured(content, PlanFile, SurveyError)
    if not told.flights:
        raise SurveyError("The plan has no flights.")
    flights = (
        Flight(tuple(view.planned for view in each.photographs), each.time_s, each.way_m)
        for each in told.flights
    )
    leftovers = (Leftover(each.part, each.why, each.area_m2, each.at) for each in told.left_out)
    return SurveyPlan(
        told.source, told.home, told.camera, told.asked, told.flying, tuple(flights), told.figures,
        told.shares, tuple(leftovers), told.draft,
    )  # fmt: skip
