"""Reads the YAML file of a mission."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping

from flight_basics.checks import check_parameters, limited
from flight_basics.errors import MissionError
from input_schemas import read_made, structured
from inspection_tools.mission.waypoints import Waypoint

MOST_LAPS = 1000
_AXES = ("x", "y", "z", "yaw")


@dataclass(frozen=True)
class WaypointEntry:
    """A waypoint in a mission's file; see `Waypoint`. Raises ParameterError as that."""

    x: float
    y: float
    z: float
    yaw: float | None = None
    tolerance: float = Waypoint.tolerance_m
    hold: float = Waypoint.hold_s

    def __post_init__(self) -> None:
        _ = self.waypoint

    @property
    def waypoint(self) -> Waypoint:
        """The waypoint in a mission."""
        return Waypoint((self.x, self.y, self.z), self.yaw, self.tolerance, self.hold)


@dataclass(frozen=True)
class MissionFile:
    """The file of a mission.

    tolerance, hold: of waypoints without their own. laps: number of times to fly the list.
    """

    waypoints: tuple[WaypointEntry, ...]
    tolerance: float | None = None
    hold: float | None = None
    laps: int = limited(1, 1, MOST_LAPS)

    def __post_init__(self) -> None:
        check_parameters(self)


def read_mission(path: str | Path) -> tuple[Waypoint, ...]:
    """Return the waypoints of a YAML file: see `parse_mission` for its form.

    Raises:
        MissionError: it cannot be read or makes no sense. The sentence names the file.
    """
    return read_made(path, "The mission", parse_mission, MissionError)


def parse_mission(content: object) -> tuple[Waypoint, ...]:
    """Return the waypoints (a tuple) from the content of a YAML file.

    The content is a list of waypoints, or a mapping as in `MissionFile`. Each waypoint is "x y z" or
    "x y z yaw", as text, as a list, or as a mapping. Units are metres, radians and seconds.

    Raises:
        MissionError: one sentence that names the waypoint and the fault.
    """
    given = content if isinstance(content, Mapping) else {"waypoints": content}
    listed = given.get("waypoints")
    if not isinstance(listed, list) or not listed:
        raise MissionError("The mission has no waypoints; give a list of 'x y z' or 'x y z yaw'.")
    common = {key: given[key] for key in ("tolerance", "hold") if given.get(key) is not None}
    entries = [_as_mapping(each, common) for each in listed]
    told = structured({**given, "waypoints": entries}, MissionFile, MissionError)
    return told.laps * tuple(each.waypoint for each in told.waypoints)


def _as_mapping(given: object, common: Mapping[str, Any]) -> object:
    words = given.replace(",", " ").split() if isinstance(given, str) else given
    if isinstance(words, list) and len(words) <= len(_AXES):
        given = dict(zip(_AXES, map(_number_in, words)))
    return {**common, **given} if isinstance(given, Mapping) else given


def _number_in(word: object) -> object:
    try:
        return float(word) if isinstance(word, str) else word
    except ValueError:
        return word
