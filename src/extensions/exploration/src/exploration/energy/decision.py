"""Go on, return or land: what the charge that is left allows."""

from __future__ import annotations

import enum
from dataclasses import MISSING, dataclass

from exploration.energy.charge import Charge
from exploration.energy.parameters import EnergyParameters
from flight_basics.checks import check_number, check_parameters, limited

LONGEST_WAY_S = 86_400.0


class Verdict(enum.IntEnum):
    """What to do; the higher, the more cautious."""

    GO_ON = 0
    RETURN = 1
    LAND = 2


@dataclass(frozen=True)
class WayHome:
    """The way home from here.

    time_s: of its flight. length_m: of its path, for the words. up_m, down_m: of this, the steep parts.
    """

    time_s: float = limited(MISSING, 0.0, LONGEST_WAY_S)
    length_m: float = limited(MISSING, 0.0, 1e6)
    up_m: float = 0.0
    down_m: float = 0.0

    def __post_init__(self) -> None:
        check_parameters(self)


@dataclass(frozen=True)
class Decision:
    """A verdict and one sentence that says why.

    charge, needed: now and for the way home, 0..1; None: unknown.
    """

    verdict: Verdict
    reason: str
    charge: float | None = None
    needed: float | None = None


class EnergyWatch:
    """Watches the battery of one flight. A return for want of energy is final until `take_off`.

    Times are of a clock that nobody sets (see `SteadyTime`).
    """

    def __init__(self, parameters: EnergyParameters | None = None) -> None:
        self._parameters = parameters or EnergyParameters()
        self._charge = Charge(self._parameters)
        self._returns = False

    @property
    def rate_per_s(self) -> float:
        """Share of the full charge that a second takes."""
        return self._charge.rate_per_s

    def hold_at(self, charge: float) -> None:
        """Note at which charge, 0..1, a simulated battery stays; 0: at none."""
        check_number("held_at", charge, 0.0, 1.0)
        self._charge.held_at = charge

    def take_off(self) -> None:
        """Begin a flight, with a battery that may have been swapped."""
        self._charge.reset()
        self._returns = False

    def offer(self, stamp_s: float, charge: float) -> str:
        """Take in a reading, 0..1; return one sentence if it is not believed, else nothing."""
        return self._charge.offer(stamp_s, charge)

    def decide(self, now_s: float, way: WayHome | None) -> Decision:
        """Return what to do now. way: the way home from here; None: none is known."""
        p, charge = self._parameters, self._charge.at(now_s)
        heard_s = self._charge.heard_s
        if charge is None or heard_s is None:
            return Decision(Verdict.RETURN, "The battery has told nothing yet: stay or come home.")
        if charge <= p.land_at:
            return Decision(Verdict.LAND, f"The battery is at {charge:.0%}: land here.", charge)
        if way is None:
            return Decision(Verdict.RETURN, "No way home is known: go back the way you came.", charge)
        rate = self._charge.rate_per_s
        least, needed = rate * way.time_s, rate * (p.margin * way.time_s + p.settling_time + p.landing_time)
        words = f"The way home of {way.length_m:.0f} m takes {needed:.0%}, {charge:.0%} are left"
        if least > charge:
            return Decision(Verdict.LAND, f"{words}: land here.", charge, needed)
        self._returns = self._returns or charge - needed <= p.reserve
        if self._returns:
            return Decision(
                Verdict.RETURN, f"{words}, and {p.reserve:.0%} are the reserve: return.", charge, needed
            )
        silent_s = now_s - heard_s
        if silent_s > p.timeout:
            sentence = f"The battery has told nothing to believe for {silent_s:.0f} s: return."
            return Decision(Verdict.RETURN, sentence, charge, needed)
        return Decision(Verdict.GO_ON, f"{words}: go on.", charge, needed)
