"""The status of the PX4 stand-in."""

from __future__ import annotations

from dataclasses import dataclass

from simulation_tools.px4.modes import ARMED_FLAG, STABILISED_FLAG, LandedState, Mode
from simulation_tools.px4.safety.battery import ChargeLevel
from simulation_tools.vehicle.energy.battery import BatteryReading


@dataclass(frozen=True)
class Px4Status:
    """A snapshot of the flight controller's state."""

    time_us: int
    mode: Mode
    wanted_mode: Mode
    armed: bool
    failsafe: bool
    controls_attitude: bool
    landed_state: LandedState
    position_valid: bool
    hover_thrust: float
    battery: BatteryReading
    battery_level: ChargeLevel
    terminated: bool = False

    @property
    def base_mode(self) -> int:
        """MAVLink's MAV_MODE_FLAG bits; an OFFBOARD that sets body rates is not stabilised."""
        flags = self.mode.base_mode | (ARMED_FLAG if self.armed else 0)
        return flags if self.controls_attitude else flags & ~STABILISED_FLAG

    @property
    def system_status(self) -> int:
        """MAVLink's MAV_STATE: standby 3, active 4, critical 5, terminated 8."""
        if self.terminated:
            return 8
        if not self.armed:
            return 3
        return 5 if self.failsafe else 4

    @property
    def heartbeat_content(self) -> tuple:
        """Return the part of a heartbeat that may change."""
        return (self.mode, self.base_mode, self.system_status)
