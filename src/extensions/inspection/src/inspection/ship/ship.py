"""Places as a surveyor names them: frame and distance, strake, port or starboard."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Callable, Mapping, NamedTuple, Sequence

import numpy as np

from inspection.survey.surface.mesh_file import (
    MAPPED_BARS,
    MAPPED_PLATING,
    MAPPED_STRUCTURE,
    NOT_SURVEYED,
)

OF_MAPS = {
    MAPPED_PLATING: "plating",
    MAPPED_STRUCTURE: "structure",
    MAPPED_BARS: "ladders, gratings",
    NOT_SURVEYED: "not surveyed",
}
"""What a surveyor calls the things that the mesh of an explored map has."""
PARTICULARS = {
    "imo": "IMO number",
    "class_number": "Class number",
    "survey": "Type of survey",
    "supplier": "Service supplier",
    "approval": "Approval of the supplier",
    "surveyor": "Surveyor",
    "pilot": "Pilot",
    "uav": "UAV and its serial number",
    "camera": "Camera and its serial number",
}
"""What a surveyor's page tells of ship and survey, by the keys of `particulars` in the ship's file."""
NOT_GIVEN = "not given"
PORT, STARBOARD = "P", "S"
SIDES = (PORT, STARBOARD)
ON_CENTRE_M = 0.05
"""A place so near to the centre line is told as CL."""
OFF_DRAWING_M = (0.05, 0.1, 0.15)
"""So far a surface of a map may lie before or behind its drawing. Beside it, no such thing is allowed for."""


@dataclass(frozen=True)
class Strake:
    """A row of plates. breadth_m: from the centre line; height_m: above the base line; both low, high."""

    name: str
    breadth_m: tuple[float, float] = (0.0, math.inf)
    height_m: tuple[float, float] = (-math.inf, math.inf)


@dataclass(frozen=True)
class Area:
    """An area under consideration. None: any. parts: things of the mesh."""

    name: str
    frames: tuple[int, int] | None = None
    sides: tuple[str, ...] = SIDES
    strakes: tuple[str, ...] | None = None
    parts: tuple[str, ...] | None = None


class Plate(NamedTuple):
    """A plate of a strake, from frame to frame."""

    first: int
    last: int
    strake: str
    side: str

    @property
    def text(self) -> str:
        """As a surveyor writes it."""
        return f"Fr. {self.first} to {self.last}, strake {self.strake}, {self.side}"


@dataclass(frozen=True)
class Ship:
    """The frames of a space and where they are in the map.

    Attributes:
        name, space: of the ship, and of what was surveyed.
        ap_m: aft perpendicular, centre line, base line: the ship's origin in the map.
        heading_deg: direction of the bow in the map, anticlockwise from x.
        frames: numbers, ascending. frames_m: (n,) their distances forward of the AP.
        strakes, areas: of which no two overlap. plate_frames: frames along one plate.
        parts: words of surveyors for the names of the mesh's things.
        particulars: of ship and survey, by the keys of PARTICULARS.
    """

    name: str = ""
    space: str = ""
    ap_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    heading_deg: float = 0.0
    frames: tuple[int, ...] = ()
    frames_m: tuple[float, ...] = ()
    strakes: tuple[Strake, ...] = ()
    areas: tuple[Area, ...] = ()
    plate_frames: int = 1
    parts: Mapping[str, str] = field(default_factory=dict)
    particulars: Mapping[str, str] = field(default_factory=dict)

    def particulars_table(self, known: Mapping[str, str] | None = None) -> list[dict[str, str]]:
        """Return all particulars; those that nobody gave say so. known: from elsewhere, by key."""
        held = {**(known or {}), **self.particulars}
        return [{"name": name, "value": held.get(key, NOT_GIVEN)} for key, name in PARTICULARS.items()]

    def part(self, name: str) -> str:
        """Return the name of a thing of the mesh as words."""
        return self.parts.get(name, OF_MAPS.get(name, name.replace("_", " ")))

    def coordinates_m(self, points_m: np.ndarray) -> np.ndarray:
        """Return places (n, 3) of the map as forward of AP, to port, above base."""
        turn = math.radians(self.heading_deg)
        shifted = np.atleast_2d(points_m) - np.array(self.ap_m)
        ahead = np.array((math.cos(turn), math.sin(turn), 0.0))
        port = np.array((-math.sin(turn), math.cos(turn), 0.0))
        return np.column_stack((shifted @ ahead, shifted @ port, shifted[:, 2]))

    def describe(self, point_m: Sequence[float], normal: Sequence[float] | None = None) -> str:
        """Return a place of the map in the ship's frame: "Fr. 52 + 300, strake C, S".

        normal: of the surface there.
        """
        if not self.frames:
            return "x {:.2f}, y {:.2f}, z {:.2f} m".format(*point_m)
        place = self.coordinates_m(np.array(point_m, float))
        k = max(int(np.searchsorted(self.frames_m, place[0, 0] + 1e-6, side="right")) - 1, 0)
        off_mm = 10 * round(100.0 * (place[0, 0] - self.frames_m[k]))
        sign = "\N{MINUS SIGN}" if off_mm < 0 else "+"
        words = [f"Fr. {self.frames[k]}" + (f" {sign} {abs(off_mm)}" if off_mm else "")]
        normals = None if normal is None else np.array([normal], float)
        number = int(_near(self._strakes_at, np.array([point_m], float), normals)[0])
        words += [f"strake {self.strakes[number].name}"] if number >= 0 else []
        beside = "CL" if abs(place[0, 1]) <= ON_CENTRE_M else PORT if place[0, 1] > 0.0 else STARBOARD
        return ", ".join([*words, beside])

    def _strakes_at(self, points_m: np.ndarray) -> np.ndarray:
        return self.strakes_of(self.coordinates_m(points_m))

    def strakes_of(self, places_m: np.ndarray) -> np.ndarray:
        """Return (n,) the index of the strake of places (n, 3) in the ship's frame; -1: none."""
        found = np.full(len(places_m), -1)
        breadth, height = np.abs(places_m[:, 1]), places_m[:, 2]
        for number, each in enumerate(self.strakes):
            inside = (breadth >= each.breadth_m[0]) & (breadth < each.breadth_m[1])
            inside &= (height >= each.height_m[0]) & (height < each.height_m[1])
            found[inside & (found < 0)] = number
        return found

    def plates(self) -> list[Plate]:
        """Return all plates: forward, then by strake, port first."""
        firsts = self.frames[: -1 : self.plate_frames]
        ends = [self._end_of(k) for k in range(len(firsts))]
        return [
            Plate(first, last, strake.name, side)
            for first, last in zip(firsts, ends)
            for strake in self.strakes
            for side in SIDES
        ]

    def plates_of(self, points_m: np.ndarray, normals: np.ndarray | None = None) -> np.ndarray:
        """Return (n,) the index in plates() of places (n, 3) of the map; -1: on none.

        normals: (n, 3) of the surface there. A surface may lie OFF_DRAWING_M off its drawing, along them.
        """
        return _near(self._plates_at, points_m, normals)

    def _plates_at(self, points_m: np.ndarray) -> np.ndarray:
        places = self.coordinates_m(points_m)
        if len(self.frames) < 2 or not self.strakes:
            return np.full(len(places), -1)
        of = np.searchsorted(self.frames_m, places[:, 0] + 1e-6, side="right") - 1
        last = np.isclose(places[:, 0], self.frames_m[-1], atol=1e-3)
        of = np.where(last, len(self.frames) - 2, of)
        strake = self.strakes_of(places)
        index = (of // self.plate_frames * len(self.strakes) + strake) * 2 + (places[:, 1] < 0.0)
        return np.where((of >= 0) & (of < len(self.frames) - 1) & (strake >= 0), index, -1)

    def _end_of(self, plate: int) -> int:
        return self.frames[min((plate + 1) * self.plate_frames, len(self.frames) - 1)]

    def areas_of(
        self, points_m: np.ndarray, parts: Sequence[str | None], normals: np.ndarray | None = None
    ) -> np.ndarray:
        """Return (n,) the index in areas of places (n, 3) of the map and their things; -1: in none.

        normals: as of `plates_of`.
        """
        things = np.array([each or "" for each in parts], dtype=object)
        return _near(self._areas_at, points_m, normals, things)

    def _areas_at(self, points_m: np.ndarray, things: np.ndarray) -> np.ndarray:
        places = self.coordinates_m(points_m)
        strakes = np.array([each.name for each in self.strakes] + [""])[self.strakes_of(places)]
        of_side = np.where(places[:, 1] < 0.0, STARBOARD, PORT)
        found = np.full(len(places), -1)
        for number, area in enumerate(self.areas):
            inside = np.isin(of_side, area.sides) & (found < 0)
            if area.frames is not None:
                low, high = (self.frames_m[self.frames.index(each)] for each in area.frames)
                high += 1e-3 if area.frames[1] == self.frames[-1] else 0.0
                inside &= (places[:, 0] >= low - 1e-6) & (places[:, 0] < high)
            if area.strakes is not None:
                inside &= np.isin(strakes, area.strakes)
            if area.parts is not None:
                inside &= np.isin(things, area.parts) | (things == "")
            found[inside] = number
        return found


def _near(
    find: Callable[..., np.ndarray], points_m: np.ndarray, normals: np.ndarray | None, *more: np.ndarray
) -> np.ndarray:
    """Return (n,) what is found at points (n, 3), or else nearest before or behind them; -1: nothing.

    find: takes points, and values of `more` for each.
    """
    found = find(points_m, *more)
    if normals is None:
        return found
    for off_m in OFF_DRAWING_M:
        for sign in (1.0, -1.0):
            lost = np.flatnonzero(found < 0)
            moved_m = points_m[lost] + sign * off_m * normals[lost]
            found[lost] = find(moved_m, *(each[lost] for each in more))
    return found
