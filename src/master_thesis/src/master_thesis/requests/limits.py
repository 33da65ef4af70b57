"""How long each phase of a run may last, as asked for."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, Callable, Mapping, TypeVar

Limits = TypeVar("Limits")


def limits_of(asked: Mapping[str, Any], kind: Callable[..., Limits]) -> Limits:
    """Return the limits, a dataclass, of those values that name its fields; raises FlightError."""
    names = [field.name for field in fields(kind)]
    return kind(**{name: asked[name] for name in names if name in asked})
