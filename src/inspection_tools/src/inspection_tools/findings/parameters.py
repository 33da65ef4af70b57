"""What counts as a candidate, and when two are one finding."""

from __future__ import annotations

from dataclasses import dataclass, replace

from inspection_tools.checks import check_number, check_whole
from inspection_tools.errors import ParameterError
from inspection_tools.survey.surface.mesh_file import Mesh, is_mapped


@dataclass(frozen=True)
class FindingParameters:
    """How findings are made.

    Attributes:
        rust_colour: Least share of red less blue in the light, (R - B) / (R + G + B), of rust.
        rust_red: Least light of red, as a multiple of green's; yellow paint has less.
        rust_texture: What has the colour of rust must have its texture, too; paint and brick have not. It
            serves pictures alone (`for_pictures`). With a mesh one knows what the pictures show.
        rust_size: Least side of a square as large as a rust spot, m.
        crack_contrast: Least share of light that the middle of a crack lacks beside both its sides.
        crack_rough: Look for cracks on rough surfaces (concrete, asphalt, scale), too, where grain is as
            dark as a crack. It is measured on pictures alone; photographs of a mesh do without.
        crack_length: Least length of a crack, m.
        crack_detail: Cracks are looked for where a pixel covers at most so much in the worst direction, mm.
        crack_incidence: And where the surface is seen at most so flat, deg.
        crack_closer: A photograph in which a pixel covers at most so much decides whether a crack is one, mm.
        line_length: Least length of a crack in the picture, px.
        line_width: Greatest width of its dark core, at half its depth, px.
        line_unlike: Greatest difference of the surface beside it, as a multiple of its depth.
        line_filled: Least share of its length that is dark.
        line_rough: Greatest deviation of its pixels from its course, px.
        line_bent: Least deviation from a straight line, root mean square, as a share of the length.
        line_bent_on_maps: The same with the mesh of an explored map, which does not show every edge. Edges
            and the shadows beside them are straight.
        crossing: Lines of sight of several photographs that pass each other by less than this cross, m: a
            spot is where most of them do, if the surface lies elsewhere. 0: the surface is right.
        crossing_on_maps: The same with the mesh of an explored map. In places it lies before the true
            surface, or shows a beam where there is none.
        keep_off: Cracks keep this far from edges of the mesh, px.
        pose_off, pose_turned: A photograph's pose may be wrong by so much, m and deg. Lines that run along an
            edge of the mesh, not farther from it than this, are no cracks.
        incidence: Greatest angle between the surface's normal and the line of sight, deg.
        distance: Greatest distance of the surface, m.
        apart: Candidates of one kind that are nearer to each other are one finding, m.
        coatings: Colours (red, green, blue; sRGB, 0 to 255) of coatings that are as red as rust. What has the
            colour of one is no rust.

    Raises:
        ParameterError: a value out of range.
    """

    rust_colour: float = 0.25
    rust_red: float = 1.7
    rust_texture: bool = False
    rust_size: float = 0.015
    crack_contrast: float = 0.14
    crack_rough: bool = True
    crack_length: float = 0.06
    crack_detail: float = 1.3
    crack_closer: float = 0.5
    crack_incidence: float = 65.0
    line_length: float = 40.0
    line_width: float = 6.0
    line_unlike: float = 0.6
    line_filled: float = 0.7
    line_rough: float = 3.0
    line_bent: float = 0.0
    line_bent_on_maps: float = 0.003
    crossing: float = 0.0
    crossing_on_maps: float = 0.08
    keep_off: int = 14
    pose_off: float = 0.02
    pose_turned: float = 0.8
    incidence: float = 75.0
    distance: float = 8.0
    apart: float = 0.06
    coatings: tuple[tuple[int, int, int], ...] = ()

    def for_pictures(self) -> FindingParameters:
        """Return them for photographs that may show anything, as nobody knows their poses."""
        return replace(self, rust_texture=True)

    def for_mesh(self, mesh: Mesh) -> FindingParameters:
        """Return them for photographs of a mesh."""
        plain = replace(self, crack_rough=False)
        if not any(map(is_mapped, mesh.names)):
            return plain
        bent = max(self.line_bent, self.line_bent_on_maps)
        return replace(plain, line_bent=bent, crossing=max(self.crossing, self.crossing_on_maps))

    def __post_init__(self) -> None:
        check_number("rust_colour", self.rust_colour, 0.01, 1.0)
        check_number("rust_red", self.rust_red, 1.0, 10.0)
        check_number("rust_size", self.rust_size, 0.001, 10.0)
        check_number("crack_contrast", self.crack_contrast, 0.01, 1.0)
        check_number("crack_length", self.crack_length, 0.005, 100.0)
        check_number("crack_detail", self.crack_detail, 0.01, 100.0)
        check_number("crack_closer", self.crack_closer, 0.001, 100.0)
        check_number("crack_incidence", self.crack_incidence, 1.0, 89.0)
        check_number("line_length", self.line_length, 10.0, 10_000.0)
        check_number("line_width", self.line_width, 1.0, 20.0)
        check_number("line_unlike", self.line_unlike, 0.01, 100.0)
        check_number("line_filled", self.line_filled, 0.0, 1.0)
        check_number("line_rough", self.line_rough, 0.1, 20.0)
        check_number("line_bent", self.line_bent, 0.0, 1.0)
        check_number("line_bent_on_maps", self.line_bent_on_maps, 0.0, 1.0)
        check_number("crossing", self.crossing, 0.0, 1.0)
        check_number("crossing_on_maps", self.crossing_on_maps, 0.0, 1.0)
        check_whole("keep_off", self.keep_off, 1, 1000)
        check_number("pose_off", self.pose_off, 0.0, 1.0)
        check_number("pose_turned", self.pose_turned, 0.0, 20.0)
        check_number("incidence", self.incidence, 1.0, 89.0)
        check_number("distance", self.distance, 0.1, 1000.0)
        check_number("apart", self.apart, 0.001, 10.0)
        for colour in self.coatings:
            if len(colour) != 3:
                raise ParameterError(f"The coating {colour!r} needs three numbers: red, green, blue.")
            for value in colour:
                check_whole("A colour of a coating", value, 0, 255)
