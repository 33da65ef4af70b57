"""Items of plans, placed in metres about a flight's origin."""

from __future__ import annotations

import math

from simulation_tools.px4.plan.items import Command, PlanItem

RELATIVE, WITHOUT_PLACE = 6, 2


class Places:
    """Makes items for a flight: north and east in m from its origin, height in m over home."""

    def __init__(self, flight):
        self._origin = flight.px4.origin

    def item(self, command, north, east, up=0.0, params=(0.0, 0.0, 0.0, math.nan), autocontinue=True):
        place = (*self._origin.to_global(north, east), up)
        return PlanItem.accepted(command, RELATIVE, params, place, autocontinue, is_int=True)

    def polygon(self, *corners, inclusion=True):
        names = Command.FENCE_POLYGON_INCLUSION, Command.FENCE_POLYGON_EXCLUSION
        command = names[0 if inclusion else 1]
        return [self.item(command, *corner, params=(len(corners), 0.0, 0.0, 0.0)) for corner in corners]

    def circle(self, north, east, radius, inclusion=True):
        names = Command.FENCE_CIRCLE_INCLUSION, Command.FENCE_CIRCLE_EXCLUSION
        return [self.item(names[0 if inclusion else 1], north, east, params=(radius, 0.0, 0.0, 0.0))]


def order(command, *params):
    """Return an item without a place."""
    padded = (*params, *(0.0,) * (4 - len(params)))
    return PlanItem.accepted(command, WITHOUT_PLACE, padded, (0.0, 0.0, 0.0), True, is_int=True)
