"""PX4's smooth take-off: spool-up after arming, then a ramp of the upward speed limit from zero thrust."""

from __future__ import annotations

import enum

from simulation_tools.px4.parameters import Px4Parameters

_GRAVITY = 9.80665


class TakeoffState(enum.IntEnum):
    """The stages of a take-off, in their order."""

    DISARMED = 1
    SPOOLUP = 2
    READY = 3
    RAMPUP = 4
    FLIGHT = 5


class Takeoff:
    """Follows arming and take-off; `speed_limit` is the upward speed that the controller may use."""

    def __init__(self, parameters: Px4Parameters) -> None:
        self._parameters = parameters
        self.reset()

    def reset(self) -> None:
        """Go back to disarmed."""
        self.state = TakeoffState.DISARMED
        self._armed_for_s = 0.0
        self._progress = 0.0

    def update(self, armed: bool, landed: bool, wanted: bool, skip: bool, dt_s: float) -> None:
        """wanted: the setpoint asks to leave the ground. skip: a mode that does not control the climb."""
        if self.state is TakeoffState.FLIGHT and armed and not landed:
            return
        self._armed_for_s = self._armed_for_s + dt_s if armed else 0.0
        if self.state is TakeoffState.DISARMED and armed:
            self.state = TakeoffState.SPOOLUP
        if self.state is TakeoffState.SPOOLUP and self._armed_for_s >= self._parameters["MPC_SPOOLUP_TIME"]:
            self.state = TakeoffState.READY
        if self.state is TakeoffState.READY and wanted:
            self.state = TakeoffState.RAMPUP
            self._progress = 0.0
        if self.state is TakeoffState.RAMPUP and self._progress >= 1.0:
            self.state = TakeoffState.FLIGHT
        if self.state is TakeoffState.FLIGHT and landed:
            self.state = TakeoffState.READY
        if armed and skip:
            self.state = TakeoffState.FLIGHT
        if not armed:
            self.state = TakeoffState.DISARMED

    def speed_limit(self, wanted_m_s: float, dt_s: float) -> float:
        """Return the upward speed limit, m/s: first negative, then rising to wanted_m_s.

        At the ramp's start the velocity controller's proportional part just cancels one gravity.
        """
        if self.state is TakeoffState.FLIGHT:
            return wanted_m_s
        start = -_GRAVITY / max(self._parameters["MPC_Z_VEL_P_ACC"], 0.01)
        if self.state < TakeoffState.RAMPUP:
            return start
        if self.state is TakeoffState.RAMPUP:
            ramp_s = self._parameters["MPC_TKO_RAMP_T"]
            self._progress = self._progress + dt_s / ramp_s if ramp_s > dt_s else 1.0
            if self._progress < 1.0:
                return start + self._progress * (wanted_m_s - start)
        return wanted_m_s
