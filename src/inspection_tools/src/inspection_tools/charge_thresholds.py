"""The battery's usual thresholds: low, critical, empty. They count where nobody plans a way home."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from flight_basics.checks import check_parameters, limited
from flight_basics.errors import ParameterError


class ChargeLevel(enum.IntEnum):
    """How much is left; the higher, the less."""

    FINE = 0
    LOW = 1
    CRITICAL = 2
    EMPTY = 3


ADVICE = {
    ChargeLevel.LOW: "come home",
    ChargeLevel.CRITICAL: "land soon",
    ChargeLevel.EMPTY: "the UAV lands here",
}


@dataclass(frozen=True)
class ThresholdParameters:
    """Charges, 0..1, below which a level begins. The defaults are PX4's.

    Raises:
        ParameterError: a value out of range, or thresholds that do not fall.
    """

    low: float = limited(0.15, 0.0, 1.0)
    """Charge that counts as low, 0..1: PX4's BAT_LOW_THR."""
    critical: float = limited(0.07, 0.0, 1.0)
    """Charge that counts as critical, 0..1: PX4's BAT_CRIT_THR."""
    empty: float = limited(0.05, 0.0, 1.0)
    """Charge at which the UAV lands by itself, 0..1: PX4's BAT_EMERGEN_THR."""
    confirmed: int = limited(2, 1, 100)
    """So many readings in a row must agree. A single wrong one lands no UAV."""

    def __post_init__(self) -> None:
        check_parameters(self)
        if not self.low >= self.critical >= self.empty:
            raise ParameterError(
                f"low, critical and empty are {self.low:g}, {self.critical:g} and {self.empty:g}; each must "
                "be no greater than the one before."
            )


class ChargeWatch:
    """Knows the level of one flight. It never rises, except when `begin` is called."""

    def __init__(self, parameters: ThresholdParameters | None = None) -> None:
        self._p = parameters or ThresholdParameters()
        self.begin()

    def begin(self) -> None:
        """Begin a flight, with a battery that may be another one."""
        self.level = ChargeLevel.FINE
        self._last: list[ChargeLevel] = []

    def offer(self, charge: float) -> str:
        """Take in a reading; return one sentence when a new level begins, else nothing."""
        if not 0.0 <= charge <= 1.0:
            return ""
        self._last = [*self._last, self._level_of(charge)][-self._p.confirmed :]
        level = min(self._last)
        if len(self._last) < self._p.confirmed or level <= self.level:
            return ""
        self.level = level
        return f"The battery is at {charge:.0%}: {ADVICE[level]}."

    def _level_of(self, charge: float) -> ChargeLevel:
        p = self._p
        limits = (
            (p.empty, ChargeLevel.EMPTY),
            (p.critical, ChargeLevel.CRITICAL),
            (p.low, ChargeLevel.LOW),
        )
        return next((level for limit, level in limits if charge <= limit), ChargeLevel.FINE)
