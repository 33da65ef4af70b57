"""MAVROS's topic `battery` out of SYS_STATUS and BATTERY_STATUS; part of its plugin `sys_status`."""

from __future__ import annotations

import math

from pymavlink.dialects.v20 import common
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Header

_NO_CELL = 65535
_TECHNOLOGIES = {
    common.MAV_BATTERY_TYPE_LIPO: BatteryState.POWER_SUPPLY_TECHNOLOGY_LIPO,
    common.MAV_BATTERY_TYPE_LIFE: BatteryState.POWER_SUPPLY_TECHNOLOGY_LIFE,
    common.MAV_BATTERY_TYPE_LION: BatteryState.POWER_SUPPLY_TECHNOLOGY_LION,
    common.MAV_BATTERY_TYPE_NIMH: BatteryState.POWER_SUPPLY_TECHNOLOGY_NIMH,
}


def system_battery_message(status: common.MAVLink_message, header: Header) -> BatteryState:
    """SYS_STATUS to BatteryState, as MAVROS publishes it until the first BATTERY_STATUS."""
    message = _discharging(header)
    message.voltage = 1e-3 * status.voltage_battery
    message.current = -1e-2 * status.current_battery
    message.percentage = 1e-2 * status.battery_remaining
    message.power_supply_technology = BatteryState.POWER_SUPPLY_TECHNOLOGY_UNKNOWN
    return message


def battery_message(battery: common.MAVLink_message, header: Header) -> BatteryState:
    """BATTERY_STATUS to BatteryState; the voltage is the sum of the cells."""
    message = _discharging(header)
    message.current = math.nan if battery.current_battery == -1 else -1e-2 * battery.current_battery
    message.percentage = 1e-2 * battery.battery_remaining
    message.power_supply_technology = _TECHNOLOGIES.get(
        battery.type, BatteryState.POWER_SUPPLY_TECHNOLOGY_UNKNOWN
    )
    cells = list(battery.voltages)
    if _NO_CELL in cells:
        cells = cells[: cells.index(_NO_CELL)]
    message.cell_voltage = [1e-3 * cell for cell in cells]
    message.voltage = sum(message.cell_voltage)
    message.location = f"id{battery.id}"
    return message


def _discharging(header: Header) -> BatteryState:
    return BatteryState(
        header=header,
        charge=math.nan,
        capacity=math.nan,
        design_capacity=math.nan,
        power_supply_status=BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
        power_supply_health=BatteryState.POWER_SUPPLY_HEALTH_UNKNOWN,
        present=True,
    )
