"""Cargo that was left in the hold: containers, a pile of crates, steel coils."""

from __future__ import annotations

from flights.worlds.steel import box
from flights.worlds.writer import Colour, Part, Prop
from simulation_tools.sdf.elements import Cylinder

NAMES = ("containers", "stray_container", "crates", "coils")
"""Models of cargo. They are no part of the ship."""
CONTAINER_M = (6.058, 2.438, 2.591)
"""Of 20 feet, ISO 668 1CC."""
CRATE_M, COIL_M = (1.2, 1.0, 0.9), (0.9, 1.25)
"""Length, breadth, height of a crate; radius and height of a coil, its axis upright."""
BLUE, GREEN, WOOD, STEEL = (
    Colour(0.16, 0.30, 0.48), Colour(0.22, 0.42, 0.34), Colour(0.64, 0.56, 0.42), Colour(0.50, 0.52, 0.55)
)  # fmt: skip


def cargo() -> tuple[Prop, ...]:
    """Return the cargo in `hold_3d`.

    It hides a part of the port side, of the fore bulkhead and of the tank top. The UAV, 0.4 m in radius,
    gets around all of it: it keeps 0.9 m from frames, stanchions and the default start.
    """
    return (
        Prop("containers", 5.0, 7.25, (_container("lower", 0, BLUE), _container("upper", 1, GREEN))),
        Prop("stray_container", -2.5, -2.0, (_container("stray", 0, BLUE),), yaw_rad=0.35),
        Prop("crates", -7.0, -7.2, _crates(), yaw_rad=-0.1),
        Prop("coils", 12.4, 1.2, tuple(_coil(k, 2.1 * k - 2.1) for k in range(3))),
    )


def _container(name: str, level: int, colour: Colour) -> Part:
    length, breadth, height = CONTAINER_M
    x, y = (-length / 2, length / 2), (-breadth / 2, breadth / 2)
    return box(name, x, y, (level * height, (level + 1) * height), colour)


def _crates() -> tuple[Part, ...]:
    """Three crates in a row, and two on top of them."""
    length, breadth, height = CRATE_M
    places = [(k, 0) for k in (-1.0, 0.0, 1.0)] + [(k, 1) for k in (-0.5, 0.5)]
    return tuple(
        box(
            f"crate_{number}",
            (1.02 * k * length - length / 2, 1.02 * k * length + length / 2),
            (-breadth / 2, breadth / 2),
            (level * height, (level + 1) * height),
            WOOD,
        )
        for number, (k, level) in enumerate(places)
    )


def _coil(number: int, y: float) -> Part:
    radius, height = COIL_M
    return Part(f"coil_{number}", Cylinder(radius, height), STEEL, (0.0, y, height / 2))
