"""From a mode's setpoint to rotor commands: PX4's controllers, take-off and land detection.

`Px4` calls them in this order: the inner loop (rates and mixer, then attitude) at every gyro sample, then, at
half that rate, everything that needs a position.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kernel_cache.compiler import njit
from simulation_tools.px4.commander import Commander
from simulation_tools.px4.control.attitude_control import (
    AttitudeControl,
    RateControl,
    fill_rates_setpoint,
    fill_torques,
)
from simulation_tools.px4.control.hover_thrust import HoverThrustEstimator
from simulation_tools.px4.control.mixer import Mixer, mix
from simulation_tools.px4.control.position_control import PositionControl
from simulation_tools.px4.control.records import SETPOINT_DTYPE, fill
from simulation_tools.px4.control.takeoff import Takeoff, TakeoffState
from simulation_tools.px4.land_detector import LandDetector
from simulation_tools.px4.modes import Mode
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.setpoint import AttitudeSetpoint, Setpoint

_PRESS_DOWN_M_S2 = 100.0  # acceleration setpoint for no thrust
_HOVER_ESTIMATE_ABOVE_M = 1.0  # over home; lower, the ground effect would disturb the estimate


class FlightControl:
    """The controllers of one vehicle. Estimates and setpoints are record arrays of shape (1,), NED."""

    def __init__(self, parameters: Px4Parameters) -> None:
        self._parameters = parameters
        self.takeoff = Takeoff(parameters)
        self.land_detector = LandDetector(parameters)
        self.position = PositionControl(parameters)
        self.attitude = AttitudeControl(parameters)
        self.mixer = Mixer()
        self._rate = RateControl(parameters)
        self._hover = HoverThrustEstimator(parameters)
        self._press_down = np.zeros(1, SETPOINT_DTYPE)
        fill(self._press_down, Setpoint(acceleration=(0.0, 0.0, _PRESS_DOWN_M_S2)))
        # After the spool-up of an automatic take-off, PX4's ramp begins with one cycle without a setpoint.
        # This cycle asks for hover thrust. It is too short to move the UAV, but the land detector reports a
        # take-off.
        self._nothing = np.zeros(1, SETPOINT_DTYPE)
        fill(self._nothing, Setpoint())
        self._ramped = np.zeros(1, SETPOINT_DTYPE)
        self._take_views()
        self.reset()

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Become a copy, with views of its own records."""
        vars(self).update(state)
        self._take_views()

    def _take_views(self) -> None:
        """Look up the fields of the position controller's output once, not in every step."""
        output = self.position.output
        self._wanted_attitude, self._wanted_yaw_rate = output["attitude"][0], output["yaw_rate"]
        self._wanted_thrust, self._thrust_vector = output["thrust"], output["thrust_vector"][0]

    def reset(self) -> None:
        """Go back to power-on."""
        for part in (self.takeoff, self.land_detector, self._hover, self.position, self.attitude, self._rate):
            part.reset()
        self.mixer.stop()
        self._body_rates: np.ndarray | None = None
        self._thrust = 0.0
        self._high_enough = False
        self._limits: tuple[float, ...] | None = None  # of the position controller

    def load_parameters(self) -> None:
        """Take changed parameters into the controllers."""
        for controller in (self.position, self.attitude, self._rate):
            controller.load_parameters()

    def update_inner_loop(
        self, armed: bool, rates: np.ndarray, attitude: np.ndarray, dt_s: float
    ) -> np.ndarray:
        """Return the rotor commands (4,), 0..1, for the newest gyro sample (3,), rad/s FRD.

        attitude: (4,) FRD in NED, w x y z; it sets the rates for the next gyro sample.
        """
        if not armed:
            self._rate.reset_integral()
            return self.mixer.stop()
        rate, outer, mixer = self._rate, self.attitude, self.mixer
        rate.adapt_to(dt_s)
        _inner_loop(
            rates,
            outer.rates_setpoint if self._body_rates is None else self._body_rates,
            not self.land_detector.maybe_landed,
            dt_s,
            rate.gains,
            rate.state,
            rate.torques,
            self._thrust,
            self._parameters["THR_MDL_FAC"],
            mixer.columns,
            mixer.outputs,
            mixer.saturation,
            attitude,
            self._wanted_attitude,
            self._wanted_yaw_rate,
            outer.gains,
            outer.rates_setpoint,
        )
        return mixer.outputs

    def update(
        self,
        setpoint: np.ndarray | AttitudeSetpoint | None,
        estimate: np.ndarray,
        commander: Commander,
        dt_s: float,
    ) -> None:
        """Set attitude and thrust for the mode's setpoint; None: stay on the ground."""
        self._body_rates = None
        sinking_m_s: float | None = math.nan
        if isinstance(setpoint, AttitudeSetpoint):
            sinking_m_s = None
            self.takeoff.update(commander.armed, self.land_detector.landed, False, True, dt_s)
            self._follow_attitude(setpoint)
        else:
            if setpoint is not None:
                sinking_m_s = float(setpoint["velocity"][0, 2])
            self._control_position(setpoint, estimate, commander, dt_s)
        self._estimate_hover_thrust(estimate, commander, dt_s)
        self.land_detector.update(
            commander.armed,
            estimate,
            sinking_m_s,
            self._thrust,
            self.position.hover_thrust,
            self._hover.valid,
            dt_s,
        )

    def _control_position(
        self, setpoint: np.ndarray | None, estimate: np.ndarray, commander: Commander, dt_s: float
    ) -> None:
        """Run take-off, position and velocity control."""
        control, p = self.position, self._parameters
        landed = self.land_detector.landed
        wanted = setpoint is not None and landed and _asks_to_climb(setpoint, estimate, commander.mode)
        before = self.takeoff.state
        self.takeoff.update(commander.armed, landed, wanted, False, dt_s)
        flying = self.takeoff.state >= TakeoffState.FLIGHT
        if not flying:
            control.set_hover_thrust(p["MPC_THR_HOVER"])
        on_ground = self.takeoff.state < TakeoffState.RAMPUP or (flying and self.land_detector.ground_contact)
        if setpoint is None or on_ground:
            setpoint = self._press_down
            control.reset_integral()
        elif not flying:
            setpoint = self._without_feed_forward(setpoint)
            if before is TakeoffState.SPOOLUP and commander.mode.is_auto:
                setpoint = self._nothing
        up = p["MPC_Z_VEL_MAX_UP"]
        limits = (
            min(self.takeoff.speed_limit(up, dt_s), up),
            p["MPC_Z_VEL_MAX_DN"],
            math.radians(p["MPC_TILTMAX_AIR" if flying else "MPC_TILTMAX_LND"]),
            p["MPC_THR_MIN"] if flying else 0.0,
        )
        if limits != self._limits:
            self._limits = control.limits[0] = limits
        control.update(setpoint, estimate, dt_s)
        self._thrust = float(self._wanted_thrust[0])

    def _without_feed_forward(self, setpoint: np.ndarray) -> np.ndarray:
        """Return the setpoint without vertical acceleration, which would bypass the take-off's ramp."""
        self._ramped[:] = setpoint
        self._ramped["acceleration"][0, 2] = math.nan
        return self._ramped

    def _follow_attitude(self, setpoint: AttitudeSetpoint) -> None:
        """Pass an attitude or body rates setpoint on to the inner controllers."""
        output = self.position.output[0]
        self._thrust = min(max(setpoint.thrust, 0.0), 1.0)
        output["thrust"] = self._thrust
        output["thrust_vector"] = (0.0, 0.0, -self._thrust)
        self.position.reset_integral()
        if setpoint.attitude is None:
            self._body_rates = np.array(setpoint.rates)
        else:
            output["attitude"] = setpoint.attitude
            output["yaw_rate"] = 0.0 if math.isnan(setpoint.rates[2]) else setpoint.rates[2]

    def _estimate_hover_thrust(self, estimate: np.ndarray, commander: Commander, dt_s: float) -> None:
        """Update the hover thrust estimator, from the first climb through 1 m over home until landing."""
        hover, home = self._hover, commander.home
        if self.land_detector.landed:
            self._high_enough = False
        elif not self._high_enough and home is not None:
            self._high_enough = home[2] - estimate["position"][0, 2] > _HOVER_ESTIMATE_ABOVE_M
        if not (commander.armed and self._high_enough):
            hover.invalidate()
            if not commander.armed:
                hover.reset()
            return
        thrust = -float(self._thrust_vector[2])
        hover.update(-float(estimate["acceleration"][0, 2]), thrust, dt_s)
        if hover.valid and self._parameters["MPC_USE_HTE"] == 1:
            self.position.update_hover_thrust(hover.hover_thrust)


@njit(cache=True)
def _inner_loop(
    rates: np.ndarray,
    wanted_rates: np.ndarray,
    integrate: bool,
    dt: float,
    rate_gains: np.ndarray,
    rate_state: np.ndarray,
    torques: np.ndarray,
    thrust: float,
    thrust_factor: float,
    columns: np.ndarray,
    outputs: np.ndarray,
    saturation: np.ndarray,
    attitude: np.ndarray,
    wanted_attitude: np.ndarray,
    wanted_yaw_rate: np.ndarray,
    attitude_gains: np.ndarray,
    rates_setpoint: np.ndarray,
) -> None:
    """Do in one call what `RateControl`, `Mixer` and `AttitudeControl` do one after the other."""
    fill_torques(rates, wanted_rates, saturation, integrate, dt, rate_gains, rate_state, torques)
    mix(columns, torques, thrust, thrust_factor, outputs, saturation)
    fill_rates_setpoint(attitude, wanted_attitude, wanted_yaw_rate[0], attitude_gains, rates_setpoint)


def _asks_to_climb(setpoint: np.ndarray, estimate: np.ndarray, mode: Mode) -> bool:
    """Whether a setpoint record asks to leave the ground."""
    if mode in (Mode.AUTO_LOITER, Mode.AUTO_LAND):
        return False
    if mode in (Mode.AUTO_TAKEOFF, Mode.AUTO_MISSION):
        return True
    asked = setpoint[0]
    return bool(
        asked["position"][2] < estimate["position"][0, 2]
        or asked["velocity"][2] < 0.0
        or asked["acceleration"][2] < 0.0
    )
