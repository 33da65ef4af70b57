"""What follows when a leader of a flight has ended: a battery, the next leader, or the landing."""

from __future__ import annotations

from enum import Enum


class Next(Enum):
    """What the UAV does when a part of its itinerary has ended."""

    AGAIN = "it lands for a full battery, and goes on with the same part"
    WHEN_READY = "it lands, waits until the same part can go on, and goes on with that"
    NEXT_PART = "it lands, the next part is prepared, and it goes on with that"
    OVER = "it lands at home"
    LOST = "it lands where it is"


class Itinerary:
    """Parts of a flight, one after the other, with fresh batteries between.

    Args:
        parts: how many. swaps: of the battery, at most, in all parts together.

    Attributes:
        part: number of the one that is flown, from 0. swapped: batteries that were swapped, for each part.
    """

    def __init__(self, parts: int, swaps: int) -> None:
        self._swaps = swaps
        self.part, self.swapped = 0, [0] * parts

    def after(self, end: str, is_home: bool) -> Next:
        """Return what follows. end: why the part has ended, as its action told."""
        if not is_home:
            return Next.LOST
        if end == "battery":
            return Next.AGAIN if self._has_battery else Next.OVER
        if end == "searching":
            return Next.WHEN_READY
        if end == "aborted" or self.part + 1 == len(self.swapped):
            return Next.OVER
        self.part += 1
        return Next.NEXT_PART

    def take_battery(self) -> bool:
        """Return whether there is a full battery, which the UAV gets now."""
        has_battery = self._has_battery
        self.swapped[self.part] += has_battery
        return has_battery

    @property
    def _has_battery(self) -> bool:
        return sum(self.swapped) < self._swaps
