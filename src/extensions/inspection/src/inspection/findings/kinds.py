"""Kinds of findings: how each is measured, joined, coloured, called, and whether it counts for the coating.

A kind of one's own is one object here and one entry of `FINDING_KINDS`: CONTRIBUTING.md, "How to add". A
detector may send other kinds, too. Such a kind is `an_unknown_kind`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Protocol

from inspection.findings.parameters import FindingParameters


class Measured(Protocol):
    """What has a size. area_m2: of the surface. length_m: between its ends."""

    @property
    def area_m2(self) -> float: ...  # noqa: D102
    @property
    def length_m(self) -> float: ...  # noqa: D102


@dataclass(frozen=True)
class FindingKind:
    """A kind of finding.

    Attributes:
        name: In files, messages and RViz's namespaces.
        word: For the surveyor, of one finding.
        plural: The same, of several.
        heading: Of a figure or a column that counts them.
        close_up: Why a confirmatory close-up is asked for.
        page_colour: Of its marks on the report's page, sRGB, 0 to 255.
        rviz_colour: Of its markers in RViz, red, green, blue, 0 to 1.
        is_line: It is thin, so three rules hold. Lines at edges of the mesh are left out. All parts that meet
            are one finding, however long it is. A nearer photograph decides whether it is one.
        is_sized_by_area: Its area is its size. Else its length is.
        counts_for_coating: Its area is rusted: grades of areas and plates count it.
    """

    name: str
    word: str
    plural: str
    heading: str
    close_up: str
    page_colour: tuple[int, int, int]
    rviz_colour: tuple[float, float, float]
    is_line: bool = False
    is_sized_by_area: bool = False
    counts_for_coating: bool = False

    def is_large_enough(self, length_m: float, area_m2: float, parameters: FindingParameters) -> bool:
        """Return whether a candidate of this size counts: a line by its length, a spot by its area."""
        if self.is_line:
            return length_m >= parameters.crack_length
        return area_m2 >= parameters.rust_size**2

    def size_in_words(self, finding: Measured) -> str:
        """Return the size as one says it."""
        if self.is_sized_by_area:
            return f"{1e4 * finding.area_m2:,.0f} cm², {100 * finding.length_m:.0f} cm long"
        return f"{1e3 * finding.length_m:,.0f} mm long"

    @property
    def page_colour_hex(self) -> str:
        """As CSS writes it."""
        return "#{:02x}{:02x}{:02x}".format(*self.page_colour)


RUST = FindingKind(
    "rust", "rust", "rust spots", "Rust", "largest rust", (155, 58, 24), (0.78, 0.29, 0.05),
    is_sized_by_area=True, counts_for_coating=True,
)  # fmt: skip
CRACK = FindingKind(
    "crack", "possible crack", "cracks", "Possible cracks", "possible crack", (28, 52, 120),
    (0.75, 0.0, 0.45), is_line=True,
)  # fmt: skip
FINDING_KINDS = (RUST, CRACK)
"""In the order in which the report counts them."""


def an_unknown_kind(name: str) -> FindingKind:
    """Return what is assumed of a kind that is not in `FINDING_KINDS`: a spot that counts for no grade."""
    return FindingKind(name, name, name, name.capitalize(), name, (90, 30, 110), (0.35, 0.12, 0.43))


def kinds_of(names: Iterable[str]) -> list[FindingKind]:
    """Return `FINDING_KINDS`, and after them the other kinds that are named, by name."""
    others = set(names).difference(kind.name for kind in FINDING_KINDS)
    return [*FINDING_KINDS, *map(an_unknown_kind, sorted(others))]


def kind_of(name: str) -> FindingKind:
    """Return the kind of this name."""
    return next((kind for kind in FINDING_KINDS if kind.name == name), None) or an_unknown_kind(name)
