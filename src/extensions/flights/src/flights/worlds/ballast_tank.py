"""A ballast tank: compartments in a row, with stiffeners, joined by manholes. A small airframe passes them.

Aft is -x, port is +y. The bottom plating is the ground, z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

from flight_basics.checks import check_limits, limited
from flights.errors import ScenarioError
from flights.worlds.steel import FRAME, SHELL, Opening, box, closed_box, places, transverse_plate
from flights.worlds.writer import Colour, Part, Prop, Surroundings, write_world

THICK_M, PLATE_M = 0.2, 0.03
"""Of the shell, and of inner plates and stiffeners."""
_FLOOR = Surroundings(Colour(0.66, 0.62, 0.58), camera=(-9.0, 0.0, 3.0, 0.0, 0.2, 0.0))


@dataclass(frozen=True)
class BallastTankParameters:
    """Sizes in m. Each inner bulkhead has one manhole, to port and to starboard by turns.

    Raises:
        ScenarioError: a size is not positive, or the manholes do not fit.
    """

    compartments: int = limited(5, above=0.0)
    compartment_m: float = limited(4.0, above=0.0)
    """Length of one, from plate to plate."""
    breadth_m: float = limited(3.0, above=0.0)
    height_m: float = limited(5.0, above=0.0)
    manhole_breadth_m: float = limited(0.6, above=0.0)
    manhole_height_m: float = limited(0.8, above=0.0)
    sill_m: float = limited(0.8, above=0.0)
    """Height of a manhole's lower edge."""
    off_centre_m: float = limited(0.7, above=0.0)
    """Distance of a manhole's middle from the tank's."""
    stiffener_m: float = limited(0.15, above=0.0)
    stiffener_spacing_m: float = limited(0.75, above=0.0)

    def __post_init__(self) -> None:
        check_limits(self, ScenarioError, "ballast_tank: {}")
        beyond = self.off_centre_m + self.manhole_breadth_m / 2 + self.stiffener_m
        if beyond > self.breadth_m / 2 or self.sill_m + self.manhole_height_m > self.height_m:
            raise ScenarioError("ballast_tank: the manholes do not fit the bulkheads. Make them smaller.")

    @property
    def length_m(self) -> float:
        """Inner length of the tank."""
        return self.compartments * self.compartment_m

    @property
    def bulkheads_x_m(self) -> list[float]:
        """Where the inner bulkheads stand, from aft."""
        return [number * self.compartment_m - self.length_m / 2 for number in range(1, self.compartments)]

    def manhole(self, bulkhead: int) -> Opening:
        """Return the manhole of an inner bulkhead, counted from aft."""
        middle = self.off_centre_m if bulkhead % 2 == 0 else -self.off_centre_m
        half = self.manhole_breadth_m / 2
        height = (self.sill_m, self.sill_m + self.manhole_height_m)
        return Opening((middle - half, middle + half), height)


def ballast_tank(parameters: BallastTankParameters | None = None) -> str:
    """Return the tank as the text of a world file."""
    p = parameters or BallastTankParameters()
    comment = (
        f"A ballast tank of {p.compartments} compartments, {p.compartment_m:g} x {p.breadth_m:g} x "
        f"{p.height_m:g} m, with manholes of {p.manhole_breadth_m:g} x {p.manhole_height_m:g} m."
    )
    props = (
        Prop("shell", 0.0, 0.0, closed_box((p.length_m, p.breadth_m, p.height_m), THICK_M, SHELL)),
        Prop("bulkheads", 0.0, 0.0, tuple(_bulkheads(p))),
        Prop("stiffeners", 0.0, 0.0, (*_side_stiffeners(p), *_bottom_and_deck_stiffeners(p))),
    )
    return write_world("ballast_tank", comment, _FLOOR, props)


def _bulkheads(p: BallastTankParameters) -> list[Part]:
    y, z = (-p.breadth_m / 2, p.breadth_m / 2), (0.0, p.height_m)
    parts: list[Part] = []
    for number, x in enumerate(p.bulkheads_x_m):
        plate = (x - PLATE_M / 2, x + PLATE_M / 2)
        parts += transverse_plate(f"plate_{number}", plate, y, z, (p.manhole(number),), FRAME)
    return parts


def _side_stiffeners(p: BallastTankParameters) -> list[Part]:
    """Longitudinals on both sides, one above the other, through the whole tank."""
    x, half_y = (-p.length_m / 2, p.length_m / 2), p.breadth_m / 2
    inner = half_y - p.stiffener_m
    return [
        box(f"side_{name}_{number}", x, y, (z - PLATE_M / 2, z + PLATE_M / 2), FRAME)
        for number, z in enumerate(_heights(p))
        for name, y in (("port", (inner, half_y)), ("starboard", (-half_y, -inner)))
    ]


def _bottom_and_deck_stiffeners(p: BallastTankParameters) -> list[Part]:
    x = (-p.length_m / 2, p.length_m / 2)
    return [
        box(f"{name}_{number}", x, (y - PLATE_M / 2, y + PLATE_M / 2), z, FRAME)
        for number, y in enumerate(places(p.breadth_m, p.stiffener_spacing_m))
        for name, z in (("bottom", (0.0, p.stiffener_m)), ("deck", (p.height_m - p.stiffener_m, p.height_m)))
    ]


def _heights(p: BallastTankParameters) -> list[float]:
    return [p.height_m / 2 + z for z in places(p.height_m, p.stiffener_spacing_m)]
