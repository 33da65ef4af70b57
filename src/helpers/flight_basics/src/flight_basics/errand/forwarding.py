"""What leaders share that hand orders on to one object that flies, as an exploration or an inspection."""

from __future__ import annotations

from typing import Generic, Protocol, TypeVar

import numpy as np

from flight_basics.errand.leader import Here
from flight_basics.pose.trust import Trust


class Led(Protocol):
    """What flies one goal. Places are (x, y, z), m."""

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


LedT = TypeVar("LedT", bound=Led)


class ForwardingLeader(Generic[LedT]):
    """The part of a `Leader` that hands orders on.

    Attributes:
        led: what flies the goal; None: no goal has come.
    """

    def __init__(self) -> None:
        self.led: LedT | None = None

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

    def give_way(self) -> None:
        """Come home until the other goal begins."""
        self._it.abort("Another goal came.")
