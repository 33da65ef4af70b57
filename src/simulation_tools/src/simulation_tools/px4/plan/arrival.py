"""When an item of a mission counts as done: place, then heading, then time."""

from __future__ import annotations

import math

from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.plan.items import PAYLOAD_COMMANDS, Command
from simulation_tools.px4.plan.waypoints import ActiveItem, Vehicle

_AT_ONCE = PAYLOAD_COMMANDS | {
    Command.LAND_START,
    Command.CHANGE_SPEED,
    Command.SET_HOME,
    Command.NAV_ROI,
    Command.SET_ROI,
    Command.SET_ROI_LOCATION,
    Command.SET_ROI_NONE,
}
_NEVER = (Command.LOITER_UNLIMITED, Command.RETURN_TO_LAUNCH)


class Arrival:
    """Watches one item after the other."""

    def __init__(self, parameters: Px4Parameters) -> None:
        self._parameters = parameters
        self.reset()

    def reset(self) -> None:
        """Begin with another item."""
        self._at_place = self._has_yaw = False
        self._arrived_s = 0.0

    def is_reached(self, item: ActiveItem, vehicle: Vehicle) -> bool:
        """Whether an item is done."""
        if item.command == Command.LAND:
            return vehicle.landed
        if item.command in _AT_ONCE:
            return True
        if item.command in _NEVER or item.then_z is not None:
            return False
        if not (vehicle.landed or self._at_place) and self.is_near(item, vehicle):
            self._at_place, self._arrived_s = True, vehicle.time_s
        if self._at_place and not self._has_yaw:
            self._has_yaw = self._looks(item, vehicle)
        return self._has_yaw and vehicle.time_s - self._arrived_s >= item.stay_s

    def is_near(self, item: ActiveItem, vehicle: Vehicle) -> bool:
        """Whether the vehicle is at an item's place. A take-off asks for the height alone."""
        if item.command == Command.DELAY:
            return True
        p = self._parameters
        north, east, down = (item.place - vehicle.position).tolist()
        height_m = p["NAV_MC_ALT_RAD"]
        if item.command == Command.TAKEOFF:
            rise_m = float(vehicle.home[2] - item.place[2])
            return down > -(0.5 * rise_m if 0.0 < rise_m < height_m else height_m)
        radius_m = item.radius_m if item.radius_m > 0.0 else p["NAV_ACC_RAD"]
        return math.hypot(north, east) <= radius_m and abs(down) <= height_m

    def _looks(self, item: ActiveItem, vehicle: Vehicle) -> bool:
        p = self._parameters
        gap = math.remainder(item.yaw_rad - vehicle.yaw_rad, 2.0 * math.pi)
        return math.isnan(gap) or abs(gap) < math.radians(p["MIS_YAW_ERR"]) or p["MIS_YAW_TMT"] > 0.0
