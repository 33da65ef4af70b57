"""What coverage.json tells, and in which words: a share is one of a surface that is named."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

MAP, DRAWING = "map", "drawing"
"""What the surface is of which a share is told: what a flight mapped, or a drawing."""
LEAST_M2 = 0.05
MOST_PARTS = 8


@dataclass(frozen=True)
class DrawnPart:
    """A thing of a drawing. share: shown of what is within reach, 0..1. not_mapped_m2: of that."""

    reachable_m2: float = 0.0
    share: float | None = None
    not_mapped_m2: float = 0.0


@dataclass(frozen=True)
class DrawnRecord:
    """What the same photographs show of a drawing, where the coverage is that of a map.

    not_mapped_m2: of what is within reach, the area that is not on the map. classes: by thing.
    """

    surface: str = ""
    surface_m2: float = 0.0
    reachable_m2: float = 0.0
    shown_m2: float = 0.0
    share_of_reachable: float | None = None
    not_mapped_m2: float = 0.0
    classes: dict[str, DrawnPart] = field(default_factory=dict)

    @property
    def in_words(self) -> str:
        """Sentences."""
        share = "none" if self.share_of_reachable is None else f"{100.0 * self.share_of_reachable:.1f} %"
        told = (
            f"Of the drawing ({Path(self.surface).name}), {self.reachable_m2:,.0f} m² are within reach, and "
            f"the photographs show {share} of that."
        )
        if self.not_mapped_m2 < LEAST_M2:
            return told
        parts = sorted(self.classes.items(), key=lambda each: -each[1].not_mapped_m2)
        lacking = [f"{name} {part.not_mapped_m2:,.1f} m²" for name, part in parts if part.not_mapped_m2]
        more = f", and {len(lacking) - MOST_PARTS} more things" if lacking[MOST_PARTS:] else ""
        return (
            f"{told} {self.not_mapped_m2:,.1f} m² of it are not on the map, so no photograph was planned for "
            f"them: {', '.join(lacking[:MOST_PARTS])}{more}."
        )


@dataclass(frozen=True)
class CoverageRecord:
    """What is read of coverage.json; see `survey.coverage.write_coverage`. None: it does not tell.

    of: `MAP` or `DRAWING`, which `surface` is; empty: not told. drawing: known besides a map.
    """

    surface: str = ""
    of: str = ""
    counted: tuple[str, ...] = ()
    resolution_mm_per_px: float | None = None
    incidence_deg: float | None = None
    mesh_m2: float | None = None
    reachable_m2: float | None = None
    share_of_reachable: float | None = None
    record: str | None = None
    drawing: DrawnRecord | None = None
    rests_on: dict[str, str] = field(default_factory=dict)

    @property
    def reference(self) -> str:
        """The surface, in words."""
        name = Path(self.surface).name
        if self.of == MAP:
            return f"the map of the flight ({name})"
        return f"the drawing ({name})" if name else "the surface"

    @property
    def in_words(self) -> list[str]:
        """Sentences that tell which share of which surface the photographs show; none: it is not known."""
        if self.share_of_reachable is None:
            return []
        area = "" if self.reachable_m2 is None else f"the {self.reachable_m2:,.0f} m² "
        within = (
            f"{area}within reach on {self.reference}"
            if self.of == MAP
            else (f"{area or 'what is '}within reach of {self.reference}")
        )
        told = [f"The photographs show {100.0 * self.share_of_reachable:.1f} % of {within}."]
        if self.drawing is not None:
            told.append(self.drawing.in_words)
        elif self.of == MAP:
            told.append("What the map lacks does not count: no drawing was given to compare it with.")
        return told
