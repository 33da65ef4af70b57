"""Parts of ships' structures: plates, stiffened plates, plates with openings."""

from __future__ import annotations

from dataclasses import dataclass

from flights.worlds.writer import Box, Colour, Part

SHELL = Colour(0.62, 0.30, 0.24)
FRAME = Colour(0.52, 0.25, 0.20)
FITTING = Colour(0.80, 0.68, 0.25)

Range = tuple[float, float]


@dataclass(frozen=True)
class Opening:
    """A rectangular opening of a plate: from where to where across it, and in height, in m."""

    across_m: Range
    height_m: Range


def box(name: str, x_m: Range, y_m: Range, z_m: Range, colour: Colour) -> Part:
    """Return the box between two corners."""
    (x0, x1), (y0, y1), (z0, z1) = x_m, y_m, z_m
    centre = (x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2
    return Part(name, Box(x1 - x0, y1 - y0, z1 - z0), colour, centre)


def transverse_plate(
    name: str, x_m: Range, y_m: Range, z_m: Range, openings: tuple[Opening, ...], colour: Colour
) -> tuple[Part, ...]:
    """Return a plate across x with openings, as boxes that touch. No two openings share a y."""
    parts: list[Part] = []
    at_m = y_m[0]
    for number, opening in enumerate(sorted(openings, key=lambda each: each.across_m)):
        parts += [
            box(f"{name}_{number}_beside", x_m, (at_m, opening.across_m[0]), z_m, colour),
            box(f"{name}_{number}_below", x_m, opening.across_m, (z_m[0], opening.height_m[0]), colour),
            box(f"{name}_{number}_above", x_m, opening.across_m, (opening.height_m[1], z_m[1]), colour),
        ]
        at_m = opening.across_m[1]
    return (*parts, box(f"{name}_end", x_m, (at_m, y_m[1]), z_m, colour))


def closed_box(inner_m: tuple[float, float, float], thick_m: float, colour: Colour) -> tuple[Part, ...]:
    """Return the four sides and the top of a space about the origin. Its floor is the ground, z = 0."""
    x_m, y_m, z_m = inner_m
    half_x, half_y = x_m / 2, y_m / 2
    out_x, out_y, top = half_x + thick_m, half_y + thick_m, z_m + thick_m
    return (
        box("shell_port", (-out_x, out_x), (half_y, out_y), (0.0, z_m), colour),
        box("shell_starboard", (-out_x, out_x), (-out_y, -half_y), (0.0, z_m), colour),
        box("bulkhead_fore", (half_x, out_x), (-half_y, half_y), (0.0, z_m), colour),
        box("bulkhead_aft", (-out_x, -half_x), (-half_y, half_y), (0.0, z_m), colour),
        box("deck", (-out_x, out_x), (-out_y, out_y), (z_m, top), colour),
    )


def places(length_m: float, spacing_m: float) -> list[float]:
    """Return the places between -length/2 and length/2, this far apart and symmetric, none on an end."""
    number = int((length_m - 1e-6) / spacing_m)
    return [(k - (number - 1) / 2) * spacing_m for k in range(number)]
