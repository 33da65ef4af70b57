"""What counts as a candidate, and when two are one finding."""

from __future__ import annotations

from dataclasses import dataclass

from inspection_tools.checks import check_number, check_whole


@dataclass(frozen=True)
class FindingParameters:
    """How findings are made.

    Attributes:
        rust_colour: Least share of red less blue in the light, (R - B) / (R + G + B), of rust.
        rust_red: Least light of red, as a multiple of green's; yellow paint has less.
        rust_size: Least side of a square as large as a rust spot, m.
        crack_contrast: Least share of light that the middle of a crack lacks beside both its sides.
        crack_length: Least length of a crack, m.
        keep_off: Cracks keep this far from edges of the mesh, px.
        incidence: Greatest angle between the surface's normal and the line of sight, deg.
        distance: Greatest distance of the surface, m.
        apart: Candidates of one kind that are nearer to each other are one finding, m.

    Raises:
        ParameterError: a value out of range.
    """

    rust_colour: float = 0.25
    rust_red: float = 1.7
    rust_size: float = 0.015
    crack_contrast: float = 0.14
    crack_length: float = 0.06
    keep_off: int = 14
    incidence: float = 75.0
    distance: float = 8.0
    apart: float = 0.06

    def __post_init__(self) -> None:
        check_number("rust_colour", self.rust_colour, 0.01, 1.0)
        check_number("rust_red", self.rust_red, 1.0, 10.0)
        check_number("rust_size", self.rust_size, 0.001, 10.0)
        check_number("crack_contrast", self.crack_contrast, 0.01, 1.0)
        check_number("crack_length", self.crack_length, 0.005, 100.0)
        check_whole("keep_off", self.keep_off, 1, 1000)
        check_number("incidence", self.incidence, 1.0, 89.0)
        check_number("distance", self.distance, 0.1, 1000.0)
        check_number("apart", self.apart, 0.001, 10.0)
