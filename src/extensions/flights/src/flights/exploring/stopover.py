"""A landing at home between two parts of an itinerary: for a full battery, or for what the next one needs."""

from __future__ import annotations


class Stopover:
    """Whether the UAV is on its way to the ground and up again, and what is due.

    Whoever flies calls `begin` and orders the landing. When `on_armed` says so, it swaps the battery, lets
    the UAV take off again, and calls `take_off`. When `on_ready` says so, the flight goes on.
    """

    def __init__(self) -> None:
        self.is_under_way = False
        self._was_armed: bool | None = None
        self._takes_off = False

    def begin(self) -> None:
        """The UAV is told to land."""
        self.is_under_way, self._takes_off = True, False

    def on_armed(self, is_armed: bool | None) -> bool:
        """Note whether the motors may turn; None: not known. Return whether the UAV has just landed."""
        has_landed = self.is_under_way and self._was_armed is True and is_armed is False
        self._was_armed = is_armed
        return has_landed

    def take_off(self) -> None:
        """The UAV is told to take off again."""
        self._takes_off = True

    def on_ready(self, is_ready: bool) -> bool:
        """Note whether the UAV hovers and takes orders. Return whether the flight goes on now."""
        if not (self._takes_off and is_ready and self._was_armed):
            return False
        self.is_under_way = self._takes_off = False
        return True
