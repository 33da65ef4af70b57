"""How long each phase of a run may last, as asked for."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, Mapping, TypeVar

Limits = TypeVar("Limits", bound=Any)


def limits_of(asked: Mapping[str, Any], kind: type[Limits]) -> Limits:
    """Return the limits, a dataclass, of those values that name its fields; raises FlightError."""
    names = [field.name for field in fields(kind)]
    return kind(**{name: asked[name] for name in names if name in asked})
