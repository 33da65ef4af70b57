"""PX4's parameters: typed, range-checked, changeable in flight."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Mapping

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


class Px4Parameters(dict[str, float]):
    """The values of all parameters by name, sorted. Only `set` changes one.

    It is a dictionary because the controllers look up dozens of values in every step. `revision` rises with
    every change, so that users can reload.
    """

    def __init__(self, overrides: Mapping[str, float] | None = None) -> None:
        """overrides: values that differ from PX4's defaults; raises Px4Error when one is not allowed."""
        self._specs = {row[0]: ParameterSpec(*row) for row in PARAMETER_TABLE}
        self._names = sorted(self._specs)
        super().__init__((name, self._specs[name].default) for name in self._names)
        self.revision = 0
        for name, value in (overrides or {}).items():
            self.set(name, value)

    def __missing__(self, name: str) -> float:
        raise Px4Error(f"PX4 has no parameter {name!r} here")

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
        if typed != self[name]:
            self[name] = typed
            self.revision += 1
