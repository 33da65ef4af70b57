"""Reads the YAML file of a ship."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

from flight_basics.errors import ShipError
from flight_basics.geometry import Vector3
from input_schemas import MaybeInfinite, read_made, structured
from inspection.ship.ship import PARTICULARS, SIDES, Area, Ship, Strake

MOST_FRAMES = 2000


@dataclass(frozen=True)
class FramesEntry:
    """A run of frames in a ship's file. spacing: mm. at: of the first, forward of the AP, m."""

    from_: int
    to: int
    spacing: float
    at: float | None = None


@dataclass(frozen=True)
class StrakeEntry:
    """A strake in a ship's file; see `Strake`."""

    name: str
    breadth: tuple[MaybeInfinite, MaybeInfinite] = (MaybeInfinite(0.0), MaybeInfinite(math.inf))
    height: tuple[MaybeInfinite, MaybeInfinite] = (MaybeInfinite(-math.inf), MaybeInfinite(math.inf))


@dataclass(frozen=True)
class ShipFile:
    """The file of a ship; see `Ship`. parts: words for things of the mesh."""

    frames: tuple[FramesEntry, ...]
    name: str = ""
    space: str = ""
    ap: Vector3 = (0.0, 0.0, 0.0)
    heading: float = 0.0
    plate_frames: int = 1
    strakes: tuple[StrakeEntry, ...] = ()
    areas: tuple[Area, ...] = ()
    parts: dict[str, str] = field(default_factory=dict)
    particulars: dict[str, str | None] = field(default_factory=dict)


def read_ship(path: Path) -> Ship:
    """Read a ship.

    Raises:
        ShipError: one sentence that names the file, the entry and the fault.
    """
    return read_made(path, "The ship", parse_ship, ShipError)


def parse_ship(content: object) -> Ship:
    """Return the ship in the content of a YAML file.

    Raises:
        ShipError: one sentence.
    """
    told = structured(content, ShipFile, ShipError)
    frames, frames_m = _frames(told.frames)
    strakes = tuple(_strake(each) for each in told.strakes)
    _refuse_same("strake", [each.name for each in strakes])
    for k, one in enumerate(strakes):
        for other in strakes[:k]:
            if _meet(one.breadth_m, other.breadth_m) and _meet(one.height_m, other.height_m):
                raise ShipError(f"The strakes {other.name} and {one.name} overlap in breadth and height.")
    _refuse_same("area", [each.name for each in told.areas])
    for k, area in enumerate(told.areas):
        _check_area(area, frames, strakes)
        for before in told.areas[:k]:
            if _areas_meet(area, before):
                raise ShipError(f'The areas "{before.name}" and "{area.name}" overlap.')
    if not 1 <= told.plate_frames < len(frames):
        raise ShipError(f"plate_frames is {told.plate_frames}; give the number of frames along one plate.")
    unknown = sorted(set(told.particulars) - set(PARTICULARS))
    if unknown:
        raise ShipError(
            f"particulars has the key '{unknown[0]}', which is unknown; it may have the keys "
            f"{', '.join(PARTICULARS)}."
        )
    particulars = {key: value for key, value in told.particulars.items() if value is not None}
    return Ship(
        told.name, told.space, told.ap, told.heading, frames, frames_m, strakes, told.areas,
        told.plate_frames, told.parts, particulars,
    )  # fmt: skip


def _frames(runs: tuple[FramesEntry, ...]) -> tuple[tuple[int, ...], tuple[float, ...]]:
    if not runs:
        raise ShipError("frames is empty; give runs such as {from: 0, to: 40, spacing: 800}.")
    numbers: list[int] = []
    at_m: list[float] = []
    for run in runs:
        first, last, spacing_mm = run.from_, run.to, run.spacing
        told = f"The frames {first} to {last}"
        if not 0 < last - first <= MOST_FRAMES or spacing_mm <= 0.0:
            raise ShipError(f"{told} need a higher number at the end, and a spacing above 0 mm.")
        if numbers and first < numbers[-1]:
            raise ShipError(f"{told} overlap with those before, which end at {numbers[-1]}.")
        if numbers and first > numbers[-1]:
            raise ShipError(f"{told} leave a gap after frame {numbers[-1]}; begin them there.")
        begin_m = _begin_m(told, run, at_m)
        skip = 1 if numbers else 0
        numbers += list(range(first + skip, last + 1))
        at_m += [begin_m + 1e-3 * spacing_mm * k for k in range(skip, last - first + 1)]
    return tuple(numbers), tuple(at_m)


def _begin_m(told: str, run: FramesEntry, before_m: list[float]) -> float:
    """Return where a run begins, forward of AP."""
    if run.at is None:
        if before_m or run.from_ == 0:
            return before_m[-1] if before_m else 0.0
        raise ShipError(
            f"{told} do not begin at 0; give at: the distance of frame {run.from_} from the AP, m."
        )
    if before_m and abs(run.at - before_m[-1]) > 1e-3:
        raise ShipError(
            f"{told} begin {run.at:g} m forward of the AP, but frame {run.from_} already stands at "
            f"{before_m[-1]:g} m."
        )
    return run.at


def _strake(entry: StrakeEntry) -> Strake:
    for key, (low, high) in (("breadth", entry.breadth), ("height", entry.height)):
        if low >= high:
            raise ShipError(
                f"The {key} of strake {entry.name} is {[low, high]}; give two numbers in m, the lower first."
            )
    return Strake(entry.name, entry.breadth, entry.height)


def _check_area(area: Area, frames: tuple[int, ...], strakes: tuple[Strake, ...]) -> None:
    if area.frames is not None and (area.frames[0] >= area.frames[1] or not set(area.frames) <= set(frames)):
        raise ShipError(
            f'The area "{area.name}" has the frames {list(area.frames)}; give two from {frames[0]} to '
            f"{frames[-1]}, the lower first."
        )
    if not area.sides or not set(area.sides) <= set(SIDES):
        raise ShipError(f'The area "{area.name}" has the sides {list(area.sides)}; give P, S or both.')
    unknown = sorted(set(area.strakes or ()) - {each.name for each in strakes})
    if unknown:
        raise ShipError(f'The area "{area.name}" has the strake {unknown[0]}, which is unknown.')


def _areas_meet(one: Area, other: Area) -> bool:
    frames = one.frames is None or other.frames is None or _meet(one.frames, other.frames)
    pairs = ((one.strakes, other.strakes), (one.parts, other.parts))
    shared = all(a is None or b is None or set(a) & set(b) for a, b in pairs)
    return bool(frames and shared and set(one.sides) & set(other.sides))


def _meet(one: tuple[float, float], other: tuple[float, float]) -> bool:
    return one[0] < other[1] and other[0] < one[1]


def _refuse_same(what: str, names: list[str]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ShipError(f'There are two {what}s of the name "{twice[0]}".')
