"""PX4's low-battery failsafe.

The levels are those of BAT_LOW_THR, BAT_CRIT_THR and BAT_EMERGEN_THR. In flight a level never rises again.
What the return home would take counts as used already: its time as a share of RTL_FLT_TIME.
"""

from __future__ import annotations

import enum
import math
from typing import Mapping

import numpy as np

from simulation_tools.px4.commander import Commander
from simulation_tools.px4.failsafe import Say
from simulation_tools.px4.modes import Mode, Severity
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.safety.battery_monitor import BatteryMonitor
from simulation_tools.vehicle.energy.battery import BatteryReading

_S_PER_MIN = 60.0
_GOING_DOWN = (Mode.AUTO_RTL, Mode.AUTO_LAND)


class ChargeLevel(enum.IntEnum):
    """PX4's battery warnings, in their order."""

    NONE = 0
    LOW = 1
    CRITICAL = 2
    EMERGENCY = 3


class LowBatteryAction(enum.IntEnum):
    """The values of COM_LOW_BAT_ACT."""

    WARN = 0
    RETURN = 1
    LAND = 2
    RETURN_THEN_LAND = 3  # return at the critical level, land at the emergency level


_ACTIONS: Mapping[tuple[ChargeLevel, LowBatteryAction], Mode] = {
    (ChargeLevel.CRITICAL, LowBatteryAction.RETURN): Mode.AUTO_RTL,
    (ChargeLevel.CRITICAL, LowBatteryAction.LAND): Mode.AUTO_LAND,
    (ChargeLevel.CRITICAL, LowBatteryAction.RETURN_THEN_LAND): Mode.AUTO_RTL,
    (ChargeLevel.EMERGENCY, LowBatteryAction.RETURN): Mode.AUTO_RTL,
    (ChargeLevel.EMERGENCY, LowBatteryAction.LAND): Mode.AUTO_LAND,
    (ChargeLevel.EMERGENCY, LowBatteryAction.RETURN_THEN_LAND): Mode.AUTO_LAND,
}
_TEXTS = {ChargeLevel.CRITICAL: "Critical battery level!", ChargeLevel.EMERGENCY: "Dangerous battery level!"}


class Battery:
    """Switches the mode when the charge passes a threshold. `reading`: the battery's state."""

    def __init__(self, parameters: Px4Parameters, commander: Commander, say: Say) -> None:
        self._parameters = parameters
        self._commander = commander
        self._say = say
        self._monitor = BatteryMonitor(parameters)
        self.reset()

    def reset(self) -> None:
        """Be full."""
        self._monitor.reset()
        self.level = ChargeLevel.NONE

    def swap(self) -> None:
        """Let the simulated battery be full again."""
        self._monitor.swap()

    @property
    def reading(self) -> BatteryReading:
        """The battery's state."""
        return self._monitor.reading

    @property
    def is_failing(self) -> bool:
        """Whether the charge is critical or worse. Then the fence does nothing, as in PX4."""
        return self.level > ChargeLevel.LOW

    def update(
        self, measured: BatteryReading | None, position: np.ndarray, dt_s: float, has_place: bool
    ) -> None:
        """Act on a new level.

        measured: by the vehicle's battery monitor; None: it has none. position: NED, (3,). dt_s: since the
        last update. has_place: there is a place on earth.
        """
        commander = self._commander
        self._monitor.update(measured, commander.armed, dt_s)
        charge, at_home = self._monitor.remaining, self._charge_at_home(position)
        level = ChargeLevel.NONE
        if min(charge, at_home) < self._highest_threshold:
            level = max(self._level(charge), min(self._level(at_home), ChargeLevel.CRITICAL))
        if not commander.armed:
            self.level = level
        elif level > self.level:
            self.level = level
            self._act(has_place)

    def _level(self, charge: float) -> ChargeLevel:
        p = self._parameters
        if charge < p["BAT_EMERGEN_THR"]:
            return ChargeLevel.EMERGENCY
        if charge < p["BAT_CRIT_THR"]:
            return ChargeLevel.CRITICAL
        return ChargeLevel.LOW if charge < p["BAT_LOW_THR"] else ChargeLevel.NONE

    @property
    def _highest_threshold(self) -> float:
        """The charge below which there is a level at all."""
        p = self._parameters
        return max(p["BAT_LOW_THR"], p["BAT_CRIT_THR"], p["BAT_EMERGEN_THR"])

    def _charge_at_home(self, position: np.ndarray) -> float:
        """Return the charge, 0..1, less what the way home would take; inf without a way home."""
        p, home = self._parameters, self._commander.home
        if home is None or self._commander.mode is Mode.AUTO_RTL:
            return math.inf
        (north, east, down), (x, y, z) = home.tolist(), position.tolist()
        way_m = math.hypot(north - x, east - y)
        time_s = way_m / p["MPC_XY_CRUISE"] + abs(down - z) / p["MPC_Z_VEL_MAX_DN"]
        return self._monitor.remaining - time_s / (_S_PER_MIN * p["RTL_FLT_TIME"])

    def _act(self, has_place: bool) -> None:
        if self.level is ChargeLevel.LOW:
            self._say(Severity.CRITICAL, "Low battery level! Return advised")
            return
        text = _TEXTS[self.level]
        action = LowBatteryAction(int(self._parameters["COM_LOW_BAT_ACT"]))
        mode = _ACTIONS.get((self.level, action))
        if mode is None:
            emergency = self.level is ChargeLevel.EMERGENCY
            advice = "please land!" if emergency else "landing advised"
            self._say(Severity.EMERGENCY if emergency else Severity.CRITICAL, f"{text}, {advice}")
        elif mode is Mode.AUTO_RTL and has_place and self._commander.home is not None:
            self._take_over(mode, _GOING_DOWN, Severity.CRITICAL, f"{text}, executing RTL")
        else:
            why = "can't execute RTL, landing instead" if mode is Mode.AUTO_RTL else "landing"
            self._take_over(Mode.AUTO_LAND, (Mode.AUTO_LAND,), Severity.EMERGENCY, f"{text}, {why}")

    def _take_over(self, mode: Mode, unless: tuple[Mode, ...], severity: Severity, text: str) -> None:
        if self._commander.wanted_mode not in unless:
            self._commander.take_over(mode)
            self._say(severity, text)
