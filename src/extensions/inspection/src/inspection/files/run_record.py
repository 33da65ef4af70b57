"""What the report reads of result.json: the record of a run."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class FlownFlight:
    """A flight on one battery. photographs: their numbers, or how many. Charges: 0..1."""

    photographs: Any = None
    purpose: str = ""
    time_s: float | None = None
    way_m: float | None = None
    battery_start: float | None = None
    battery_end: float | None = None

    @property
    def told(self) -> int | str | None:
        """Number of photographs, or what else it was for; None: it is not known."""
        if isinstance(self.photographs, list):
            return len(self.photographs)
        return self.photographs if isinstance(self.photographs, int) else self.purpose or None


@dataclass(frozen=True)
class UnknownArea:
    """Openings into what stays unknown, and the reason."""

    border_m2: float
    why: str


@dataclass(frozen=True)
class Explored:
    """The flight before the photographs, which mapped the space."""

    known_m3: float | None = None
    home_s: float | None = None
    unknown: tuple[UnknownArea, ...] = ()


@dataclass(frozen=True)
class NotTaken:
    """A photograph of the plan that the flight left out."""

    photograph: int
    why: str = ""


@dataclass(frozen=True)
class Surveyed:
    """The flights with photographs together."""

    taken: int | None = None
    asked: int | None = None
    shots: int | None = None
    swaps: int | None = None
    flight_s: float | None = None
    reason: str = ""
    left_out: tuple[NotTaken, ...] = ()


@dataclass(frozen=True)
class RunRecord:
    """The record of a run. touched: names of parts of the structure. versions: of programs, by name."""

    flights: tuple[FlownFlight, ...] = ()
    exploration: Explored | None = None
    inspection: Surveyed | None = None
    touched: tuple[str, ...] = ()
    failure: str = ""
    date: str = ""
    world: str = ""
    seed: str = ""
    commit: str = ""
    versions: dict[str, str | None] = field(default_factory=dict)
