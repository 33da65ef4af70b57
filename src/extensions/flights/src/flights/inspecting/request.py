"""The request of an inspection."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Mapping

from flight_basics.errors import FlightBasicsError
from flights.errors import ScenarioError
from flights.exploring import request as exploring
from flights.exploring.request import ExploringRequest
from flights.worlds import scenario
from inspection.camera.survey_camera import SurveyCamera
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan_file import read_plan
from simulation_tools.camera.defects import defects_in
from simulation_tools.camera.effects.amounts import effects_in

PLAN_MARGIN_M = 0.25
"""Beyond the UAV's radius, in a plan that is made here: the flight's map is coarser than the drawing."""
SMALL_MARGIN_M = 0.0
"""The same for a small UAV: with 0.05 m, the plan ends at the first manhole."""
COMFORT_M = 1.05
"""Beyond the radius: 0.2 m more than CEPA's r_ub. Nearer, CEPA pushes the UAV about, and a photograph takes
longer. A small UAV's is `PLAN_MARGIN_M`."""
FINER = 0.02
"""95 % of 809 photographs were taken at most 0.1 m farther away than planned, of some 4.7 m."""


@dataclass(frozen=True)
class InspectingRequest:
    """An inspection.

    flight: as of an exploration. plan: file of it; None: it is made from a drawing (SDF world, mesh, or map
    of voxels) for `camera`, `asked` and `flying`, with so much CPU time of search. photographs: only the
    first so many; 0: all. second_look: take nearer photographs of cracks. supplement: take more of what the
    plan's did not show. draft: set out with the first photographs, and plan the others meanwhile. explore_s:
    explore first, for so long at most, and plan on the map of that; None: do not.
    """

    flight: ExploringRequest
    plan: Path | None
    drawing: Path
    photographs: int
    camera: SurveyCamera
    asked: SurveyParameters
    flying: FlightParameters
    search_s: float
    second_look: bool
    supplement: bool
    draft: bool = False
    explore_s: float | None = None


def read(asked: Mapping[str, Any], keep_m: float) -> InspectingRequest:
    """Read and check the request. asked: the node's parameters by name. keep_m: CEPA's r_lb.

    Raises:
        FlightsError, SimulationToolsError: one sentence.
    """
    scenario.number("photograph_time", asked.get("photograph_time", 3600.0), 1.0, exploring.LONGEST_S)
    flight = exploring.read(asked, keep_m)
    photographs = scenario.whole_number("photographs", asked.get("photographs", 0), 0, 100_000)
    search_s = scenario.number("search", asked.get("search", 20.0), 0.0, 86_400.0)
    path = str(asked.get("plan", "")).strip()
    drawing = str(asked.get("drawing", "")).strip()
    explore_s = _explore_s(asked)
    if explore_s is not None:
        if path or drawing:
            raise ScenarioError(
                "explore:=true plans on the map of the exploration; leave out plan:= and drawing:=."
            )
        longer_s = flight.limits.flight_timeout_s + explore_s
        flight = replace(flight, limits=replace(flight.limits, flight_timeout_s=longer_s))
    source = Path(drawing) if drawing else flight.description.scenario.world_path
    if not source.is_file():
        raise ScenarioError(f"{source}: there is no such drawing. Give a mesh, a world, or a map.bt.")
    second_look, supplement, draft = (
        scenario.flag(key, asked.get(key, False)) for key in ("second_look", "supplement", "draft")
    )
    try:
        camera = SurveyCamera(
            scenario.whole_number("width", asked.get("width", SurveyCamera.width), 16, 20_000),
            scenario.whole_number("height", asked.get("height", SurveyCamera.height), 16, 20_000),
            scenario.number("field_of_view", asked.get("field_of_view", 60.0), 1.0, 150.0),
            exposure=scenario.number("exposure", asked.get("exposure", SurveyCamera.exposure), 1e-6, 10.0),
        )
        wanted = SurveyParameters(
            resolution=scenario.number("detail", asked.get("detail", 1.0), 0.01, 100.0),
            radius=scenario.number("radius", asked.get("radius", 0.35), 0.05, 5.0),
            margin=SMALL_MARGIN_M if flight.description.model == "small_quad" else PLAN_MARGIN_M,
            comfort=PLAN_MARGIN_M if flight.description.model == "small_quad" else COMFORT_M,
            finer=FINER,
            voxel=0.05 if flight.description.model == "small_quad" else 0.1,
        )
        flying = _flying(scenario.number("passing", asked.get("passing", 0.0), 0.0, FlightParameters.speed))
        if path:
            _check_plan(Path(path), camera)
    except FlightBasicsError as error:
        raise ScenarioError(str(error)) from None
    _check_looks(asked, flight.description.scenario.world_path)
    given = Path(path) if path else None
    return InspectingRequest(
        flight, given, source, photographs, camera, wanted, flying, search_s, second_look, supplement,
        draft and not photographs, explore_s,
    )  # fmt: skip


def _flying(passing_m_s: float) -> FlightParameters:
    return FlightParameters(passing=True, passing_speed=passing_m_s) if passing_m_s else FlightParameters()


def _explore_s(asked: Mapping[str, Any]) -> float | None:
    time_s = scenario.number("explore_time", asked.get("explore_time", 600.0), 1.0, exploring.LONGEST_S)
    return time_s if scenario.flag("explore", asked.get("explore", False)) else None


def _check_looks(asked: Mapping[str, Any], world: Path) -> None:
    """Refuse what the camera would refuse when the flight has begun: effects, and the file of defects."""
    effects_in(str(asked.get("effects", "")))
    defects = str(asked.get("defects", "")).strip()
    defects_in(world, Path(defects) if defects else None)


def _check_plan(path: Path, camera: SurveyCamera) -> None:
    given = read_plan(path).camera
    if (given.width, given.height, given.field_of_view) != (
        camera.width,
        camera.height,
        camera.field_of_view,
    ):
        raise ScenarioError(
            f"{path} is for a camera of {given.width} x {given.height} px and {given.field_of_view:g} deg; "
            f"give settings:=FILE with width: {given.width}, height: {given.height} and "
            f"field_of_view: {given.field_of_view:g}."
        )
