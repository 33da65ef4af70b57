"""Reads the YAML file of a mission."""

from __future__ import annotations

from pathlib import Path
from typing import Mapping

from flight_basics.errors import MissionError, ParameterError
from flight_basics.yaml_file import read_yaml
from inspection_tools.mission.waypoints import Waypoint

MOST_LAPS = 1000
_KEYS = ("x", "y", "z", "yaw", "tolerance", "hold")


def read_mission(path: str | Path) -> tuple[Waypoint, ...]:
    """Return the waypoints of a YAML file: see `parse_mission` for its form.

    Raises:
        MissionError: it cannot be read or makes no sense. The sentence names the file.
    """
    return read_yaml(path, "The mission", parse_mission, MissionError)


def parse_mission(content: object) -> tuple[Waypoint, ...]:
    """Return the waypoints (a tuple) from the content of a YAML file.

    The content is a list of waypoints, or a mapping with these keys:
      - `waypoints`: the list. Each entry is "x y z" or "x y z yaw", as text, as a list, or as a mapping with
        these keys and a `tolerance` and `hold` of its own.
      - `tolerance`, `hold`: for waypoints without their own.
      - `laps`: number of times to fly the list.
    Units are metres, radians and seconds.

    Raises:
        MissionError: one sentence that names the waypoint and the fault.
    """
    if isinstance(content, Mapping):
        unknown = sorted(set(content) - {"waypoints", "tolerance", "hold", "laps"}, key=str)
        if unknown:
            raise MissionError(f"A mission has waypoints, tolerance, hold and laps, but no '{unknown[0]}'.")
        common = {key: content[key] for key in ("tolerance", "hold") if key in content}
        listed, laps = content.get("waypoints"), content.get("laps", 1)
    else:
        common, listed, laps = {}, content, 1
    if not isinstance(listed, list) or not listed:
        raise MissionError("The mission has no waypoints; give a list of 'x y z' or 'x y z yaw'.")
    if isinstance(laps, bool) or not isinstance(laps, int) or not 1 <= laps <= MOST_LAPS:
        raise MissionError(f"laps is {laps!r}; it must be a whole number from 1 to {MOST_LAPS}.")
    return laps * tuple(_waypoint(number, given, common) for number, given in enumerate(listed, start=1))


def _waypoint(number: int, given: object, common: Mapping) -> Waypoint:
    values = {**common, **_as_mapping(number, given)}
    unknown = sorted(set(values) - set(_KEYS), key=str)
    missing = [key for key in "xyz" if key not in values]
    if unknown or missing:
        wrong = f"has no {missing[0]}" if missing else f"has a '{unknown[0]}', which is unknown"
        raise MissionError(f"Waypoint {number} {wrong}; its keys are {', '.join(_KEYS)}.")
    position = tuple(values.pop(axis) for axis in "xyz")
    names = {"yaw": "yaw_rad", "tolerance": "tolerance_m", "hold": "hold_s"}
    try:
        return Waypoint(position, **{names[key]: value for key, value in values.items()})
    except ParameterError as error:
        raise MissionError(f"Waypoint {number}: {error}") from None


def _as_mapping(number: int, given: object) -> dict:
    if isinstance(given, Mapping):
        return dict(given)
    words = given.replace(",", " ").split() if isinstance(given, str) else given
    if isinstance(words, list) and len(words) in (3, 4):
        try:
            return dict(zip(_KEYS, (float(word) for word in words)))
        except (TypeError, ValueError, OverflowError):
            pass
    raise MissionError(f"Waypoint {number} is {given!r}; give three or four numbers: x y z or x y z yaw.")
