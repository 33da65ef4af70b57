"""Writes and reads a plan as YAML, which one may edit."""

from __future__ import annotations

import math
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, Mapping

from flight_basics.errors import SurveyError
from flight_basics.yaml_file import read_yaml
from inspection.camera.survey_camera import SurveyCamera
from inspection.files.whole import write_whole
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan import Draft, Flight, Leftover, PlannedView, SurveyPlan
from inspection.survey.views.candidates import View

HEAD = """# A survey plan. Edit photographs, then check: rosrun inspection survey_planner check PLAN
# at: place of the camera in the map, m. yaw: anticlockwise from x, deg. tilt: 0 level, 90 straight up, deg.
# way: corners of the way there from the photograph before, m, if it is not straight.
"""
LONGEST_S = 86_400.0
"""Of the search that completes a draft; the UAV waits for it."""
KEYS = ("source", "home", "camera", "asked", "flying", "figures", "shares", "left_out", "draft", "flights")


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
    return read_yaml(path, "The plan", parse_plan, SurveyError)


def parse_plan(content: object) -> SurveyPlan:
    """Return the plan in the content of a YAML file.

    Raises:
        SurveyError: one sentence that names the photograph and the fault.
    """
    if not isinstance(content, Mapping):
        raise SurveyError("A plan is a mapping with the keys " + ", ".join(KEYS) + ".")
    _refuse_unknown("A plan", content, KEYS)
    if not isinstance(content.get("flights"), list) or not content["flights"]:
        raise SurveyError("The plan has no flights.")
    flights, number = [], 0
    for count, given in enumerate(content["flights"], start=1):
        if not isinstance(given, Mapping) or not isinstance(given.get("photographs"), list):
            raise SurveyError(f"Flight {count} has no list of photographs.")
        _refuse_unknown(f"Flight {count}", given, ("time_s", "way_m", "photographs"))
        views = []
        for each in given["photographs"]:
            number += 1
            views.append(_view(number, each))
        times = [_number(f"{key} of flight {count}", given.get(key, 0.0)) for key in ("time_s", "way_m")]
        flights.append(Flight(tuple(views), *times))
    return SurveyPlan(
        str(content.get("source", "")),
        _place("home", content.get("home")),
        _parameters(SurveyCamera, "camera", content),
        _parameters(SurveyParameters, "asked", content),
        _parameters(FlightParameters, "flying", content),
        tuple(flights),
        {str(k): _number(str(k), v) for k, v in dict(content.get("figures") or {}).items()},
        {str(k): _number(str(k), v) for k, v in dict(content.get("shares") or {}).items()},
        tuple(
            Leftover(str(o["part"]), str(o["why"]), _number("area_m2", o["area_m2"]), _place("at", o["at"]))
            for o in content.get("left_out") or []
        ),
        _draft(content),
    )


def _draft(content: Mapping) -> Draft | None:
    given = content.get("draft")
    if given is None:
        return None
    if not isinstance(given, Mapping):
        raise SurveyError(f"draft is {given!r}; it must be a mapping with seed and search_s.")
    _refuse_unknown("draft", given, ("seed", "search_s"))
    seed, search_s = (_number(f"{key} of draft", given.get(key)) for key in ("seed", "search_s"))
    if seed < 0.0 or seed != int(seed) or not 0.0 <= search_s <= LONGEST_S:
        raise SurveyError(
            f"draft has the seed {seed:g} and {search_s:g} s of search; the seed must be a whole number from "
            f"0, the time 0 to {LONGEST_S:g} s."
        )
    return Draft(int(seed), search_s)


def _refuse_unknown(what: str, given: Mapping, known: tuple[str, ...]) -> None:
    unknown = sorted(set(given) - set(known), key=str)
    if unknown:
        raise SurveyError(
            f"{what} has a key '{unknown[0]}', which is unknown; its keys are {', '.join(known)}."
        )


def _view(number: int, given: Any) -> PlannedView:
    name = f"Photograph {number}"
    if not isinstance(given, Mapping):
        raise SurveyError(f"{name} is {given!r}; give it at, yaw and tilt.")
    _refuse_unknown(name, given, ("id", "at", "yaw", "tilt", "way"))
    yaw, tilt = (_number(f"{key} of photograph {number}", given.get(key)) for key in ("yaw", "tilt"))
    way = given.get("way") or []
    if not isinstance(way, list):
        raise SurveyError(f"{name} has a way that is no list of places.")
    place = _place(f"at of photograph {number}", given.get("at"))
    corners = tuple(_place(f"way of photograph {number}", each) for each in way)
    return PlannedView(View(place, math.radians(yaw), math.radians(tilt)), corners)


def _number(name: str, given: Any) -> float:
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not math.isfinite(given):
        raise SurveyError(f"{name} is {given!r}; it must be a finite number.")
    return float(given)


def _place(name: str, given: Any) -> tuple[float, float, float]:
    if not isinstance(given, list) or len(given) != 3:
        raise SurveyError(f"{name} is {given!r}; it must be three numbers: [x, y, z], m.")
    x, y, z = (_number(name, each) for each in given)
    return x, y, z


def _parameters(kind: Any, key: str, content: Mapping) -> Any:
    given = content.get(key) or {}
    if not isinstance(given, Mapping):
        raise SurveyError(f"{key} is {given!r}; it must be a mapping.")
    _refuse_unknown(key, given, tuple(each.name for each in fields(kind)))
    return kind(**given)
