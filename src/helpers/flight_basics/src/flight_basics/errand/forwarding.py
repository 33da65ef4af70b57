"""What leaders share that hand orders on to one object that flies, as an exploration or an inspection."""

from __future__ import annotations

from typing import Any, Generic, Mapping, Protocol, Sequence, TypeVar

import numpy as np

from flight_basics.errand.leader import Here
from flight_basics.pose.trust import Trust


class Energy(Protocol):
    """As `exploration.energy.EnergyWatch`."""

    def offer(self, stamp_s: float, charge: float) -> str:
        """Take in a reading, 0..1; return what is wrong with it, in a sentence."""


class Led(Protocol):
    """What flies one goal. Places are (x, y, z), m."""

    @property
    def home_m(self) -> np.ndarray | None:
        """Where it comes home to; None: it has not begun."""

    def begin(
        self,
        stamp_s: float,
        here_m: np.ndarray,
        home_m: np.ndarray | None = None,
        time_max_s: float | None = None,
    ) -> None:
        """Begin at a place. home_m: if it is not that one. time_max_s: None: the parameter's."""

    def look(self, stamp_s: float, here_m: np.ndarray) -> None:
        """Decide at a place."""

    def mind(self, stamp_s: float, here_m: np.ndarray) -> None:
        """End if time or energy says so; here_m: the last place that is known."""

    @property
    def is_paused(self) -> bool:
        """Whether it hovers by `pause`."""

    def trust(self, trust: Trust, why: str, here_m: np.ndarray) -> None:
        """Take what the pose is good for. why: it is not sure."""

    def pause(self, here_m: np.ndarray) -> None:
        """Hover at a place until `resume` or `abort`."""

    def resume(self) -> None:
        """Go on after a pause."""

    def abort(self, reason: str) -> None:
        """Come home."""

    def strand(self, why: str) -> None:
        """Land here, because it cannot come home."""


LedT = TypeVar("LedT", bound=Led)


class ForwardingLeader(Generic[LedT]):
    """The part of a `Leader` that hands orders on.

    energy: watches the battery; None: the battery does not count.

    Attributes:
        led: what flies the goal; None: no goal has come. kept: as that of a `Leader`.
    """

    def __init__(self, energy: Energy | None) -> None:
        self._watch = energy
        self.led: LedT | None = None
        self.kept: Mapping[str, Any] = {}

    def _begin(self, led: LedT, time_max_s: float | None, here: Here, kept: Mapping[str, Any] | None) -> None:
        """Begin here, or go on with the home and the time that are kept. Raises ParameterError."""
        known = kept or {}
        home_m = np.array(known["home"]) if known else None
        began_s = known.get("began", here.stamp_s)
        led.begin(here.time_s + began_s - here.stamp_s, here.place_m, home_m, time_max_s)
        assert led.home_m is not None
        self.kept = {"home": led.home_m.tolist(), "began": began_s}
        self.led = led

    def look(self, here: Here, readings: Sequence[tuple[float, float]]) -> list[str]:
        """Decide. Without a pose, only time and energy count."""
        told = [] if self._watch is None else [self._watch.offer(*reading) for reading in readings]
        (self._it.mind if here.silent_s else self._it.look)(here.time_s, here.place_m)
        return [sentence for sentence in told if sentence]

    @property
    def _it(self) -> LedT:
        assert self.led is not None, "begin first"
        return self.led

    @property
    def is_paused(self) -> bool:
        """Whether it hovers by `pause`."""
        return self._it.is_paused

    def trust(self, trust: Trust, why: str, here: Here) -> None:
        """Take what the pose is good for."""
        self._it.trust(trust, why, here.place_m)

    def pause(self, here: Here) -> None:
        """Hover here."""
        self._it.pause(here.place_m)

    def resume(self) -> None:
        """Go on."""
        self._it.resume()

    def abort(self, reason: str) -> None:
        """Come home."""
        self._it.abort(reason)

    def strand(self, why: str, here: Here | None) -> None:
        """End here."""
        self._it.strand(why)

    def give_way(self) -> None:
        """Come home until the other goal begins."""
        self._it.abort("Another goal came.")
