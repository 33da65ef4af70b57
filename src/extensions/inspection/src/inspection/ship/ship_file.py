"""Reads the YAML file of a ship."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Mapping

from flight_basics.errors import ShipError
from flight_basics.yaml_file import read_yaml
from inspection.ship.ship import PARTICULARS, SIDES, Area, Ship, Strake

KEYS = (
    "name",
    "space",
    "ap",
    "heading",
    "frames",
    "plate_frames",
    "strakes",
    "areas",
    "parts",
    "particulars",
)
MOST_FRAMES = 2000


def read_ship(path: Path) -> Ship:
    """Read a ship.

    Raises:
        ShipError: one sentence that names the file, the entry and the fault.
    """
    return read_yaml(path, "The ship", parse_ship, ShipError)


def parse_ship(content: object) -> Ship:
    """Return the ship in the content of a YAML file.

    Raises:
        ShipError: one sentence.
    """
    given = _mapping("A ship", content, KEYS)
    frames, frames_m = _frames(given.get("frames"))
    strakes = tuple(_strake(each) for each in _list("strakes", given.get("strakes", [])))
    _refuse_same("strake", [each.name for each in strakes])
    for k, one in enumerate(strakes):
        for other in strakes[:k]:
            if _meet(one.breadth_m, other.breadth_m) and _meet(one.height_m, other.height_m):
                raise ShipError(f"The strakes {other.name} and {one.name} overlap in breadth and height.")
    areas = tuple(_area(each, frames, strakes) for each in _list("areas", given.get("areas", [])))
    _refuse_same("area", [each.name for each in areas])
    for k, area in enumerate(areas):
        for before in areas[:k]:
            if _areas_meet(area, before):
                raise ShipError(f'The areas "{before.name}" and "{area.name}" overlap.')
    plate = given.get("plate_frames", 1)
    if isinstance(plate, bool) or not isinstance(plate, int) or not 1 <= plate < len(frames):
        raise ShipError(f"plate_frames is {plate!r}; give the number of frames along one plate.")
    ap = _list("ap", given.get("ap", [0.0, 0.0, 0.0]))
    if len(ap) != 3:
        raise ShipError(f"ap is {ap!r}; give three numbers: [x, y, z] in the map, m.")
    x, y, z = (_number("ap", each) for each in ap)
    heading = _number("heading", given.get("heading", 0.0))
    names = (str(given.get("name", "")), str(given.get("space", "")))
    parts = given.get("parts") or {}
    if not isinstance(parts, Mapping):
        raise ShipError(f"parts is {parts!r}; give words for things of the mesh: {{ground_plane: tank top}}.")
    words = {str(key): str(value) for key, value in parts.items()}
    given_particulars = given.get("particulars") or {}
    if given_particulars:
        _mapping("particulars", given_particulars, tuple(PARTICULARS))
    particulars = {str(key): str(value) for key, value in given_particulars.items() if value is not None}
    return Ship(*names, (x, y, z), heading, frames, frames_m, strakes, areas, plate, words, particulars)


def _frames(given: object) -> tuple[tuple[int, ...], tuple[float, ...]]:
    runs = _list("frames", given)
    if not runs:
        raise ShipError("frames is empty; give runs such as {from: 0, to: 40, spacing: 800}.")
    numbers: list[int] = []
    at_m: list[float] = []
    for each in runs:
        run = _mapping("A run of frames", each, ("from", "to", "spacing", "at"))
        first, last = (_whole(key, run.get(key)) for key in ("from", "to"))
        spacing_mm = _number("spacing", run.get("spacing"))
        told = f"The frames {first} to {last}"
        if not 0 < last - first <= MOST_FRAMES or spacing_mm <= 0.0:
            raise ShipError(f"{told} need a higher number at the end, and a spacing above 0 mm.")
        if numbers and first < numbers[-1]:
            raise ShipError(f"{told} overlap with those before, which end at {numbers[-1]}.")
        if numbers and first > numbers[-1]:
            raise ShipError(f"{told} leave a gap after frame {numbers[-1]}; begin them there.")
        begin_m = _begin_m(told, run, first, at_m)
        skip = 1 if numbers else 0
        numbers += list(range(first + skip, last + 1))
        at_m += [begin_m + 1e-3 * spacing_mm * k for k in range(skip, last - first + 1)]
    return tuple(numbers), tuple(at_m)


def _begin_m(told: str, run: Mapping, first: int, before_m: list[float]) -> float:
    """Return where a run begins, forward of AP."""
    if "at" not in run:
        if before_m or first == 0:
            return before_m[-1] if before_m else 0.0
        raise ShipError(f"{told} do not begin at 0; give at: the distance of frame {first} from the AP, m.")
    at_m = _number("at", run["at"])
    if before_m and abs(at_m - before_m[-1]) > 1e-3:
        raise ShipError(
            f"{told} begin {at_m:g} m forward of the AP, but frame {first} already stands at "
            f"{before_m[-1]:g} m."
        )
    return at_m


def _strake(given: object) -> Strake:
    entry = _mapping("A strake", given, ("name", "breadth", "height"))
    name = _name("A strake", entry)
    whole = {"breadth": (0.0, math.inf), "height": (-math.inf, math.inf)}
    return Strake(name, *(_range(f"{key} of strake {name}", entry.get(key), whole[key]) for key in whole))


def _area(given: object, frames: tuple[int, ...], strakes: tuple[Strake, ...]) -> Area:
    entry = _mapping("An area", given, ("name", "frames", "sides", "strakes", "parts"))
    name = _name("An area", entry)
    between = None
    if "frames" in entry:
        ends = [_whole(f"frames of {name}", each) for each in _list(f"frames of {name}", entry["frames"])]
        if len(ends) != 2 or ends[0] >= ends[1] or not set(ends) <= set(frames):
            raise ShipError(
                f'The area "{name}" has the frames {ends}; give two from {frames[0]} to {frames[-1]}, '
                "the lower first."
            )
        between = (ends[0], ends[1])
    sides = tuple(str(each) for each in _list(f"sides of {name}", entry.get("sides", list(SIDES))))
    if not sides or not set(sides) <= set(SIDES):
        raise ShipError(f'The area "{name}" has the sides {list(sides)}; give P, S or both.')
    known = {each.name for each in strakes}
    own = _names(name, "strakes", entry)
    if own is not None and not set(own) <= known:
        raise ShipError(f'The area "{name}" has the strake {sorted(set(own) - known)[0]}, which is unknown.')
    return Area(name, between, sides, own, _names(name, "parts", entry))


def _areas_meet(one: Area, other: Area) -> bool:
    frames = one.frames is None or other.frames is None or _meet(one.frames, other.frames)
    pairs = ((one.strakes, other.strakes), (one.parts, other.parts))
    shared = all(a is None or b is None or set(a) & set(b) for a, b in pairs)
    return bool(frames and shared and set(one.sides) & set(other.sides))


def _meet(one: tuple[float, float], other: tuple[float, float]) -> bool:
    return one[0] < other[1] and other[0] < one[1]


def _names(area: str, key: str, entry: Mapping) -> tuple[str, ...] | None:
    return tuple(str(v) for v in _list(f"{key} of {area}", entry[key])) if key in entry else None


def _refuse_same(what: str, names: list[str]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ShipError(f'There are two {what}s of the name "{twice[0]}".')


def _mapping(what: str, given: object, keys: tuple[str, ...]) -> Mapping:
    if not isinstance(given, Mapping):
        raise ShipError(f"{what} is {given!r}; it needs the keys {', '.join(keys)}.")
    unknown = sorted(set(given) - set(keys), key=str)
    if unknown:
        raise ShipError(
            f'{what} has the key "{unknown[0]}", which is unknown; its keys are {", ".join(keys)}.'
        )
    return given


def _list(name: str, given: object) -> list:
    if not isinstance(given, list):
        raise ShipError(f"{name} is {given!r}; it must be a list.")
    return given


def _name(what: str, entry: Mapping) -> str:
    if entry.get("name") in (None, ""):
        raise ShipError(f"{what} has no name.")
    return str(entry["name"])


def _range(name: str, given: object, default: tuple[float, float]) -> tuple[float, float]:
    if given is None:
        return default
    ends = [_number(name, each) for each in _list(name, given)]
    if len(ends) != 2 or ends[0] >= ends[1]:
        raise ShipError(f"The {name} is {given!r}; give two numbers in m, the lower first.")
    return ends[0], ends[1]


def _whole(name: str, given: Any) -> int:
    if isinstance(given, bool) or not isinstance(given, int):
        raise ShipError(f"{name} is {given!r}; it must be a whole number.")
    return given


def _number(name: str, given: Any) -> float:
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not math.isfinite(given):
        raise ShipError(f"{name} is {given!r}; it must be a finite number.")
    return float(given)
