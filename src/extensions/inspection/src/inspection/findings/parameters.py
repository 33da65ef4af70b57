"""What counts as a candidate, and when two are one finding."""

from __future__ import annotations

from dataclasses import dataclass, replace

from flight_basics.checks import check_parameters, check_whole, limited
from flight_basics.errors import ParameterError
from inspection.survey.surface.mesh_file import Mesh, is_mapped


@dataclass(frozen=True)
class FindingParameters:
    """How findings are made.

    Raises:
        ParameterError: a value out of range.
    """

    rust_colour: float = limited(0.25, 0.01, 1.0)
    """Least share of red less blue in the light, (R - B) / (R + G + B), of rust."""
    rust_red: float = limited(1.7, 1.0, 10.0)
    """Least light of red, as a multiple of green's; yellow paint has less."""
    rust_texture: bool = False
    """What has the colour of rust must have its texture, too; paint and brick have not. It serves pictures
    alone (`for_pictures`). With a mesh one knows what the pictures show.
    """
    rust_size: float = limited(0.015, 0.001, 10.0)
    """Least side of a square as large as a rust spot, m."""
    crack_contrast: float = limited(0.14, 0.01, 1.0)
    """Least share of light that the middle of a crack lacks beside both its sides."""
    crack_rough: bool = True
    """Look for cracks on rough surfaces (concrete, asphalt, scale), too, where grain is as dark as a crack.
    It is measured on pictures alone; photographs of a mesh do without.
    """
    crack_surface: bool = False
    """A crack must lie in one surface, too: joints, edges, stalks and hair do not. It serves pictures alone
    (`for_pictures`). With a mesh one knows the surface.
    """
    crack_wide: bool = False
    """Wide cracks are looked for in a smaller copy of a large picture, too. It serves pictures alone
    (`for_pictures`). With a mesh one knows what a pixel covers, and so how wide a crack is.
    """
    crack_length: float = limited(0.06, 0.005, 100.0)
    """Least length of a crack, m."""
    crack_detail: float = limited(1.3, 0.01, 100.0)
    """Cracks are looked for where a pixel covers at most so much in the worst direction, mm."""
    crack_closer: float = limited(0.5, 0.001, 100.0)
    """A photograph in which a pixel covers at most so much decides whether a crack is one, mm."""
    crack_incidence: float = limited(65.0, 1.0, 89.0)
    """Cracks are looked for where the surface is seen at most so flat, deg."""
    line_length: float = limited(40.0, 10.0, 10_000.0)
    """Least length of a crack in the picture, px."""
    line_width: float = limited(6.0, 1.0, 20.0)
    """Greatest width of a crack's dark core, at half its depth, px."""
    line_unlike: float = limited(0.6, 0.01, 100.0)
    """Greatest difference of the surfaces on both sides of a crack, as a multiple of its depth."""
    line_filled: float = limited(0.7, 0.0, 1.0)
    """Least share of a crack's length that is dark."""
    line_rough: float = limited(3.0, 0.1, 20.0)
    """Greatest deviation of a crack's pixels from its course, px."""
    line_bent: float = limited(0.0, 0.0, 1.0)
    """Least deviation of a crack from a straight line, root mean square, as a share of the length."""
    line_bent_on_maps: float = limited(0.003, 0.0, 1.0)
    """`line_bent` with the mesh of an explored map, which does not show every edge. Edges and the shadows
    beside them are straight.
    """
    crossing: float = limited(0.0, 0.0, 1.0)
    """Lines of sight of several photographs that pass each other by less than this cross, m: a spot is where
    most of them do, if the surface lies elsewhere. 0: the surface is right.
    """
    crossing_on_maps: float = limited(0.08, 0.0, 1.0)
    """`crossing` with the mesh of an explored map. In places it lies before the true surface, or shows a beam
    where there is none, m.
    """
    keep_off: int = limited(14, 1, 1000)
    """Cracks keep this far from edges of the mesh, px."""
    pose_off: float = limited(0.02, 0.0, 1.0)
    """A photograph's place may be wrong by so much, m. Lines that run along an edge of the mesh, not farther
    from it than this, are no cracks.
    """
    pose_turned: float = limited(0.8, 0.0, 20.0)
    """A photograph may be turned by so much, deg. Lines that run along an edge of the mesh, not farther from
    it than this, are no cracks.
    """
    incidence: float = limited(75.0, 1.0, 89.0)
    """Greatest angle between the surface's normal and the line of sight, deg."""
    distance: float = limited(8.0, 0.1, 1000.0)
    """Greatest distance of the surface, m."""
    apart: float = limited(0.06, 0.001, 10.0)
    """Candidates of one kind that are nearer to each other are one finding, m."""
    coatings: tuple[tuple[int, int, int], ...] = ()
    """Colours (red, green, blue; sRGB, 0 to 255) of coatings that are as red as rust. What has the colour of
    one is no rust.
    """

    def for_pictures(self) -> FindingParameters:
        """Return them for photographs that may show anything, as nobody knows their poses."""
        return replace(self, rust_texture=True, crack_surface=True, crack_wide=True)

    def for_mesh(self, mesh: Mesh) -> FindingParameters:
        """Return them for photographs of a mesh."""
        plain = replace(self, crack_rough=False)
        if not any(map(is_mapped, mesh.names)):
            return plain
        bent = max(self.line_bent, self.line_bent_on_maps)
        return replace(plain, line_bent=bent, crossing=max(self.crossing, self.crossing_on_maps))

    def __post_init__(self) -> None:
        check_parameters(self)
        for colour in self.coatings:
            if len(colour) != 3:
                raise ParameterError(f"The coating {colour!r} needs three numbers: red, green, blue.")
            for value in colour:
                check_whole("A colour of a coating", value, 0, 255)
