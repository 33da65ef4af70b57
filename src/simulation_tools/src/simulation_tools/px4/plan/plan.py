"""The uploaded lists. They outlive a reset, as in PX4, where they are files."""

from __future__ import annotations

import enum
from typing import Sequence

from simulation_tools.px4.plan.items import PlanItem


class PlanKind(enum.IntEnum):
    """MAVLink's MAV_MISSION_TYPE of the lists that are kept here."""

    MISSION = 0
    FENCE = 1


CAPACITY = {PlanKind.MISSION: 65534, PlanKind.FENCE: 63}
"""How many items PX4 SITL keeps."""


class Plan:
    """Both lists. `current` is the mission item that is flown, or will be.

    `mission_changes` rises with each new mission and each item that a client chooses, `fence_changes` with
    each new fence.
    """

    def __init__(self) -> None:
        self._items: dict[PlanKind, tuple[PlanItem, ...]] = dict.fromkeys(PlanKind, ())
        self.mission_changes = self.fence_changes = 0
        self.chosen: int | None = None  # by a client, with the newest change
        self.current = 0

    @property
    def mission(self) -> tuple[PlanItem, ...]:
        """The mission's items."""
        return self._items[PlanKind.MISSION]

    @property
    def fence(self) -> tuple[PlanItem, ...]:
        """The fence's items: vertices of polygons, and circles."""
        return self._items[PlanKind.FENCE]

    def items(self, kind: PlanKind) -> tuple[PlanItem, ...]:
        """Return one of the lists."""
        return self._items[kind]

    def replace(self, kind: PlanKind, items: Sequence[PlanItem], chosen: int | None = None) -> None:
        """Take in a list. chosen: the mission item to begin with; None: the one that was current."""
        self._items[kind] = tuple(items)
        if kind is PlanKind.FENCE:
            self.fence_changes += 1
        else:
            self.chosen = chosen
            self.mission_changes += 1

    def choose(self, seq: int) -> bool:
        """Take a client's choice of the item to fly to; returns False if there is none of this number."""
        if not 0 <= seq < len(self.mission):
            return False
        self.chosen = seq
        self.mission_changes += 1
        return True
