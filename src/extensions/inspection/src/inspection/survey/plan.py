"""A survey plan: flights of photographs, what they show, and what cannot be shown."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, field

from flight_basics.checks import check_parameters, limited
from inspection.camera.survey_camera import SurveyCamera
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.surface.mesh_file import reference_of
from inspection.survey.views.candidates import View


@dataclass(frozen=True)
class PlannedView:
    """A photograph, and corners of the way to it from the one before, if that way is not straight."""

    view: View
    way_m: tuple[tuple[float, float, float], ...] = ()


@dataclass(frozen=True)
class Flight:
    """Photographs on one battery; time_s: from take-off to landing, way_m: its length."""

    views: tuple[PlannedView, ...]
    time_s: float
    way_m: float


@dataclass(frozen=True)
class Leftover:
    """A part of the surface that no photograph can show. part: name of the thing; place_m: in its middle."""

    part: str
    why: str
    area_m2: float
    place_m: tuple[float, float, float]


@dataclass(frozen=True)
class Draft:
    """How the flights that a plan lacks are sought.

    seed: of all that is drawn; search_s: CPU time, s; the UAV waits for it.

    Raises:
        ParameterError: a value out of range.
    """

    seed: int = limited(MISSING, 0, 2**63)
    search_s: float = limited(MISSING, 0.0, 86_400.0)

    def __post_init__(self) -> None:
        check_parameters(self)


@dataclass(frozen=True)
class SurveyPlan:
    """What is flown.

    Attributes:
        source: file of the surface. home_m: place of take-off in the map's frame.
        camera, asked, flying: parameters. flights: in their order.
        figures: area_m2, reachable_m2, share, photographs, their LP bound, the tour's and so on.
        shares: of what is reachable, by thing. leftovers: what cannot be shown.
        draft: the flights are settled, and others will follow (`planner.completed`); None: these are all.
    """

    source: str
    home_m: tuple[float, float, float]
    camera: SurveyCamera
    asked: SurveyParameters
    flying: FlightParameters
    flights: tuple[Flight, ...]
    figures: dict[str, float] = field(default_factory=dict)
    shares: dict[str, float] = field(default_factory=dict)
    leftovers: tuple[Leftover, ...] = ()
    draft: Draft | None = None

    @property
    def reference(self) -> str:
        """What its surface is, and its shares are of: a map of a flight, or a drawing."""
        return reference_of(tuple(self.shares))

    @property
    def views(self) -> tuple[View, ...]:
        """All photographs in their order."""
        return tuple(each.view for flight in self.flights for each in flight.views)
