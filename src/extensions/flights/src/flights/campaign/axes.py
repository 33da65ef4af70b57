"""What may vary from trial to trial: the names that a campaign's `trials:` may hold, and their values."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any, Mapping

from cepa import ALGORITHMS, CepaError, CepaParameters
from flights.baselines import BASELINES
from flights.errors import CampaignError
from flights.flight.conditions import BOUNDS, Conditions
from flights.mapping.mapping_flight import SCENARIOS
from flights.worlds.drawn.barriers import FENCE, GLASS
from flights.worlds.drawn.kept_out import KEEP_OUT
from flights.worlds.drawn.manholes import HOSE, MANHOLES, NOTHING, PERSON
from flights.worlds.drawn.movers import ABREAST, CROSSING, HEAD_ON, SINKING, SMALL_UAV
from flights.worlds.drawn.overhead import OBSTACLES
from flights.worlds.drawn.traps import BUG_TRAP, TRAPS, U
from flights.worlds.experiment_1 import GOAL_X_M
from flights.worlds.scenario import CLOUD_LIDARS, FLIGHT_HEIGHT_M, LIDARS
from flights.worlds.scenario import SCENARIOS as EXPERIMENT_WORLDS
from gridslam import SlamError, SlamParameters
from input_schemas import InputError, structured

Value = bool | int | float | str
Settings = Mapping[str, Any]
"""What a case is flown with: for each axis a value of its kind, defaults included; None if it has none."""

KINDS = ("flight", "mapping")
FOREST, MIXED_FOREST, HALLWAY, HOLD = "random_forest", "mixed_forest", "random_hallway", "beamed_hold"
SPACED_FOREST, THICK_FOREST, DEAD_ENDS, OFFICE = "spaced_forest", "thick_forest", "dead_ends", "office"
DEEP_DEAD_END, DOORS = "deep_dead_end", "doors"
BARRIERS = (FENCE, GLASS)
MAPPING_WORLDS = (HOLD, "room", "hold", "hold_middle")
MEETINGS = (CROSSING, HEAD_ON)
DRAWN_MEETINGS = (ABREAST, SINKING, SMALL_UAV)
"""What meets the UAV there is drawn with its speed."""
_26_M_FORESTS = (FOREST, MIXED_FOREST, SPACED_FOREST, KEEP_OUT)
_26_M_ROOMS = (HALLWAY, OFFICE, DOORS, BUG_TRAP, *OBSTACLES)
_26_M_WORLDS = (*_26_M_FORESTS, *_26_M_ROOMS, *BARRIERS, *MEETINGS, *DRAWN_MEETINGS)
DRAWN_DISTANCES_M = {
    **dict.fromkeys(_26_M_WORLDS, 26.0),
    DEAD_ENDS: 34.0,
    DEEP_DEAD_END: 30.0,
    MANHOLES: 9.0,
    THICK_FOREST: 54.0,
}
"""From start to goal in a world drawn at random; in the experiments' own as there."""
FLIGHT_WORLDS = (*DRAWN_DISTANCES_M, *EXPERIMENT_WORLDS)
MODELS = "iris", "small_quad"
STEERING = (*ALGORITHMS, *BASELINES)
CEPA_PREFIX, SLAM_PREFIX = "cepa.", "slam."


@dataclass(frozen=True)
class Axis:
    """A name of `trials:`. default: None if world or lidar decide. worlds: the only ones that know it."""

    name: str
    kind: type
    default: Value | None = None
    bounds: tuple[float, float] = (-math.inf, math.inf)
    choices: tuple[str, ...] = ()
    worlds: tuple[str, ...] = ()

    def checked(self, value: Any) -> Any:
        """Return a value in the axis's type; raises CampaignError in one sentence."""
        if self.choices:
            if not isinstance(value, str) or value not in self.choices:
                choices = ", ".join(self.choices)
                raise CampaignError(f"There is no {self.name} {value!r}; choose from {choices}.")
            return value
        try:
            value = structured(value, self.kind)
        except InputError as error:
            raise CampaignError(str(error).replace("The top level", self.name)) from None
        low, high = self.bounds
        if not low <= value <= high:
            raise CampaignError(f"{self.name} must be from {low:g} to {high:g}, not {value:g}.")
        return value


_COMMON = (
    Axis("lidar", str, "ust", choices=tuple(dict.fromkeys((*LIDARS, *CLOUD_LIDARS)))),
    Axis("lidar_range_m", float, bounds=(1.0, 200.0)),
    Axis("height_m", float, FLIGHT_HEIGHT_M, bounds=(0.5, 3.0)),
)
_FLIGHT = (
    Axis("world", str, choices=FLIGHT_WORLDS),
    Axis("density_per_m2", float, 0.10, bounds=(0.0, 0.16), worlds=(FOREST,)),
    Axis("width_m", float, 3.0, bounds=(1.2, 20.0), worlds=(HALLWAY,)),
    Axis("mover_speed_m_s", float, 1.0, bounds=(0.0, 5.0), worlds=MEETINGS),
    Axis("depth_m", float, 12.0, bounds=(3.0, 20.0), worlds=(DEEP_DEAD_END,)),
    Axis("door_m", float, 1.0, bounds=(0.8, 3.0), worlds=(DOORS,)),
    Axis("trap", str, U, choices=tuple(TRAPS), worlds=(BUG_TRAP,)),
    Axis("behind", str, NOTHING, choices=(NOTHING, PERSON, HOSE), worlds=(MANHOLES,)),
    Axis("distance_m", float, bounds=(6.5, 60.0)),
    Axis("model", str, "iris", choices=MODELS),
    Axis("algorithm", str, "improved", choices=STEERING),
    Axis("speed_m_s", float, 2.0, bounds=(0.2, 8.0)),
    Axis("range_finders", bool, False),
    *(Axis(name, float, getattr(Conditions(), name), bounds) for name, bounds in BOUNDS.items()),
    *_COMMON,
)
_MAPPING = (
    Axis("world", str, choices=MAPPING_WORLDS),
    Axis("beam_width_m", float, 1.0, bounds=(0.0, 2.5), worlds=(HOLD,)),
    Axis("beam_spacing_m", float, 3.0, bounds=(2.0, 10.0), worlds=(HOLD,)),
    *(axis for axis in _COMMON if axis.name != "height_m"),
    Axis("speed_m_s", float, bounds=(0.2, 2.0)),
    Axis("duration_s", float, bounds=(1.0, 3600.0)),
    Axis("slam.loop_closure", bool, True),
    Axis("slam.levelling", bool, True),
)
_TEXT = ("speed_fractions",)  # lists of numbers are no single value of an axis


def _parameter_axes(prefix: str, parameters: type, without: tuple[str, ...]) -> tuple[Axis, ...]:
    defaults = [(field.name, field.default) for field in fields(parameters) if field.name not in without]
    return tuple(
        Axis(prefix + name, float if default is None else type(default)) for name, default in defaults
    )


_CEPA = _parameter_axes(CEPA_PREFIX, CepaParameters, _TEXT)
_SLAM = _parameter_axes(SLAM_PREFIX, SlamParameters, ("seed", "threads"))
_BY_KIND = {"flight": (*_FLIGHT, *_CEPA), "mapping": (*_MAPPING, *_CEPA, *_SLAM)}


def axes_of(kind: str) -> dict[str, Axis]:
    """Return all that may vary in campaigns of a kind, by name."""
    return {axis.name: axis for axis in _BY_KIND[kind]}


def with_defaults(kind: str, given: Settings) -> Settings:
    """Return a trial's settings: those given, and the defaults of all axes but single parameters.

    An axis that the world does not have is None.

    Raises:
        CampaignError: the settings do not go together.
    """
    known, world = axes_of(kind), given["world"]
    for name in given:
        worlds = known[name].worlds
        if worlds and world not in worlds:
            raise CampaignError(f"{name} is of the world {', '.join(worlds)} only, not of {world}.")
    parameters = {n: value for n, value in given.items() if n.startswith((CEPA_PREFIX, SLAM_PREFIX))}
    plain = (axis for axis in _BY_KIND[kind] if not axis.name.startswith((CEPA_PREFIX, SLAM_PREFIX)))
    defaults = {
        axis.name: None if axis.worlds and world not in axis.worlds else axis.default for axis in plain
    }
    settings: dict[str, Any] = {**defaults, **{n: v for n, v in given.items() if n in defaults}, **parameters}
    if kind == "flight" and settings["distance_m"] is None:
        settings["distance_m"] = DRAWN_DISTANCES_M.get(world, GOAL_X_M)
    if kind == "mapping" and settings["speed_m_s"] is None:
        settings["speed_m_s"] = SCENARIOS[scenario_name(world)].speed_m_s
    _check_parameters(settings)
    return settings


def scenario_name(world: str) -> str:
    """Return the name of the scenario by which a world is mapped."""
    return "hold" if world == HOLD else world


def _check_parameters(settings: Settings) -> None:
    slam = parameters_in(settings, SLAM_PREFIX)
    for name in ("loop_closure", "levelling"):
        slam.pop(name, None)
    try:
        CepaParameters(**parameters_in(settings, CEPA_PREFIX))
        SlamParameters(**slam)
    except (CepaError, SlamError) as error:
        raise CampaignError(f"These parameters do not go together: {error}") from None


def parameters_in(settings: Settings, prefix: str) -> dict[str, Any]:
    """Return the settings of one prefix, without it."""
    return {name[len(prefix) :]: value for name, value in settings.items() if name.startswith(prefix)}
