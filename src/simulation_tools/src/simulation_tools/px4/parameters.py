"""PX4's parameters: typed, range-checked, changeable in flight."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterator, Mapping

from simulation_tools.autopilot import Px4Error
from simulation_tools.px4.parameter_table import PARAMETER_TABLE


@dataclass(frozen=True)
class ParameterSpec:
    """The description of one parameter. Its type is the type of the default."""

    name: str
    default: float
    minimum: float
    maximum: float
    description: str

    @property
    def is_integer(self) -> bool:
        """Whether MAVLink carries it as INT32 (else as REAL32)."""
        return isinstance(self.default, int)


class Px4Parameters:
    """The values of all parameters. `revision` rises with every change, so that users can reload."""

    def __init__(self, overrides: Mapping[str, float] | None = None) -> None:
        """overrides: values that differ from PX4's defaults; raises Px4Error when one is not allowed."""
        self._specs = {row[0]: ParameterSpec(*row) for row in PARAMETER_TABLE}
        self._names = sorted(self._specs)
        self._values = {name: spec.default for name, spec in self._specs.items()}
        self.revision = 0
        for name, value in (overrides or {}).items():
            self.set(name, value)

    def __len__(self) -> int:
        return len(self._names)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __contains__(self, name: str) -> bool:
        return name in self._specs

    def __getitem__(self, name: str) -> float:
        try:
            return self._values[name]
        except KeyError:
            raise Px4Error(f"PX4 has no parameter {name!r} here") from None

    def spec(self, name: str) -> ParameterSpec:
        """Return a parameter's description; raises Px4Error."""
        self[name]
        return self._specs[name]

    def name_at(self, index: int) -> str | None:
        """Return the name at an index of the sorted list, or None."""
        return self._names[index] if 0 <= index < len(self._names) else None

    def index_of(self, name: str) -> int:
        """Return the place of a name in the sorted list."""
        self[name]
        return self._names.index(name)

    def set(self, name: str, value: float) -> None:
        """Change a value; raises Px4Error when it is unknown, out of range or of the wrong type."""
        spec = self.spec(name)
        if not math.isfinite(value) or not spec.minimum <= value <= spec.maximum:
            raise Px4Error(
                f"{name} must lie between {spec.minimum:g} and {spec.maximum:g}, got {value:g}; "
                "it is left as it was"
            )
        if spec.is_integer and value != int(value):
            raise Px4Error(f"{name} must be an integer, got {value:g}; it is left as it was")
        typed = int(value) if spec.is_integer else float(value)
        if typed != self._values[name]:
            self._values[name] = typed
            self.revision += 1
