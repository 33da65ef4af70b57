"""The PX4 stand-in: estimator, commander, navigator, controllers and mixer in lockstep with the physics.

A step runs the parts in the order of PX4's work queues: rates and mixer on the newest gyro sample first, then
the attitude controller, then, at about 125 Hz, everything that waits for a position estimate. So a position
setpoint reaches the rotors two steps later, as in PX4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Callable, Sequence

import numpy as np

from simulation_tools.geometry import rotate
from simulation_tools.px4.attitude_control import AttitudeControl, RateControl
from simulation_tools.px4.autopilot import Px4Error, VehicleState
from simulation_tools.px4.commander import FORCE_MAGIC, Commander
from simulation_tools.px4.estimator import Estimator, EstimatorNoise
from simulation_tools.px4.hover_thrust import HoverThrustEstimator
from simulation_tools.px4.land_detector import LandDetector
from simulation_tools.px4.mixer import QUAD_WIDE, Mixer
from simulation_tools.px4.modes import LandedState, Mode, Result, Severity
from simulation_tools.px4.navigator import Navigator
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.position_control import SETPOINT_DTYPE, PositionControl
from simulation_tools.px4.setpoint import UNSET, AttitudeSetpoint, Setpoint
from simulation_tools.px4.takeoff import Takeoff, TakeoffState
from simulation_tools.vehicle.airframe import Airframe

POSITION_PERIOD_US = 8_000
_PRESS_DOWN_M_S2 = 100.0  # an acceleration setpoint that means: no thrust


@dataclass(frozen=True)
class Px4Status:
    """What the flight controller says about itself."""

    time_us: int
    mode: Mode
    wanted_mode: Mode
    armed: bool
    failsafe: bool
    landed_state: LandedState
    position_valid: bool
    takeoff_state: TakeoffState
    hover_thrust: float
    battery_remaining: float

    @property
    def system_status(self) -> int:
        """MAVLink's MAV_STATE: standby 3, active 4, critical 5."""
        if self.failsafe:
            return 5
        return 4 if self.armed else 3


class Px4:
    """One flight controller; an `Autopilot`.

    `on_statustext` (severity, text) is called for what PX4 would say to a ground station.
    """

    def __init__(
        self,
        airframe: Airframe,
        parameters: Px4Parameters | None = None,
        rng: np.random.Generator | None = None,
        noise: EstimatorNoise | None = None,
    ) -> None:
        """noise: of the estimate, PX4-like by default. rng: its source; fixed seed 0 when none is given."""
        if len(airframe.rotors) != len(QUAD_WIDE):
            raise Px4Error(f"PX4's wide quadrotor needs 4 rotors, the model has {len(airframe.rotors)}")
        self.parameters = parameters or Px4Parameters()
        self.on_statustext: Callable[[Severity, str], None] = lambda severity, text: None
        p = self.parameters
        self._estimator = Estimator(noise or EstimatorNoise(), rng or np.random.default_rng(0))
        self._commander = Commander(p, lambda severity, text: self.on_statustext(severity, text))
        self._navigator = Navigator(p)
        self._land_detector = LandDetector(p)
        self._takeoff = Takeoff(p)
        self._hover = HoverThrustEstimator(p)
        self._position = PositionControl(p)
        self._attitude = AttitudeControl(p)
        self._rate = RateControl(p)
        self._mixer = Mixer()
        self._setpoint = np.zeros(1, SETPOINT_DTYPE)
        self._press_down = np.zeros(1, SETPOINT_DTYPE)
        self._fill(self._press_down, Setpoint(acceleration=(0.0, 0.0, _PRESS_DOWN_M_S2)))
        self.reset()

    def reset(self) -> None:
        """Go back to power-on, parameters kept."""
        self._estimator.reset()
        self._commander.reset()
        self._land_detector.reset()
        self._takeoff.reset()
        self._hover.reset()
        for controller in (self._position, self._attitude, self._rate):
            controller.reset()
        self._mixer.stop()
        self._revision = self.parameters.revision
        self._started_us: int | None = None
        self._time_us = 0
        self._position_us = 0
        self._mode_entries = -1
        self._offboard: Setpoint | AttitudeSetpoint | None = None
        self._body_rates: np.ndarray | None = None
        self._thrust = 0.0
        self._in_air = False
        self._battery = 1.0
        self._asked_to_sink_m_s = math.nan

    def close(self) -> None:
        """Nothing to release."""

    # Input

    def offer_setpoint(self, setpoint: Setpoint | AttitudeSetpoint) -> bool:
        """Take in an offboard setpoint; returns False for one that asks for nothing and so counts as none."""
        if not setpoint.asks_something:
            return False
        self._commander.setpoint_received(self._time_us)
        if isinstance(setpoint, Setpoint) and setpoint.body:
            setpoint = self._levelled(setpoint)
        self._offboard = setpoint
        return True

    def ground_station_heard(self) -> None:
        """Note a ground station's heartbeat."""
        self._commander.ground_station_heard(self._time_us)

    def request_mode(self, mode: Mode) -> Result:
        """Ask for a mode, as DO_SET_MODE does."""
        return self._commander.request_mode(*mode.value)

    def request_arm(self, armed: bool = True, force: bool = False) -> Result:
        """Ask for arming or disarming."""
        commander = self._commander
        return commander.request_arm(force) if armed else commander.request_disarm(force)

    def command(self, command: int, params: Sequence[float]) -> Result:
        """Answer a MAV_CMD with its seven parameters; those about messages are the link's."""
        commander = self._commander
        if command == 400:  # COMPONENT_ARM_DISARM
            action = params[0]
            if action not in (0.0, 1.0):
                self.on_statustext(Severity.CRITICAL, f"Unsupported ARM_DISARM param: {action:.3f}")
                return Result.UNSUPPORTED
            return self.request_arm(action == 1.0, params[1] == FORCE_MAGIC)
        if command == 176:  # DO_SET_MODE
            if not (math.isfinite(params[1]) and math.isfinite(params[2])):
                return Result.DENIED
            return commander.request_mode(int(params[1]), int(params[2]))
        if command == 22:  # NAV_TAKEOFF, altitude above mean sea level
            height = params[6] - self.origin_altitude_m
            if commander.home is not None:
                height += float(commander.home[2])
            return commander.request_takeoff(height)
        modes = {17: Mode.AUTO_LOITER, 20: Mode.AUTO_RTL, 21: Mode.AUTO_LAND}
        return self.request_mode(modes[command]) if command in modes else Result.UNSUPPORTED

    origin_altitude_m = 488.0  # above mean sea level, of the world's origin: PX4 SITL's home in Zurich

    # Output

    @property
    def estimate(self) -> np.ndarray:
        """The newest estimate, one record of ESTIMATE_DTYPE (NED), shape (1,)."""
        return self._estimator.estimate

    @property
    def estimate_valid(self) -> bool:
        """Whether there is a local position."""
        if self._started_us is None:
            return False
        return self._time_us - self._started_us >= 1e6 * self.parameters["EKF2_REQ_GPS_H"]

    @property
    def home(self) -> np.ndarray | None:
        """Home position, NED, (3,); None before there is one."""
        return self._commander.home

    @property
    def attitude_setpoint(self) -> np.ndarray:
        """The newest output of the position controller, one record, shape (1,)."""
        return self._position.output

    @property
    def active_setpoint(self) -> np.ndarray:
        """The setpoint that the position controller follows, one record of SETPOINT_DTYPE, shape (1,)."""
        return self._setpoint

    @property
    def rates_setpoint(self) -> np.ndarray:
        """The newest rates setpoint, rad/s FRD, (3,)."""
        return self._attitude.rates_setpoint

    @property
    def commands(self) -> np.ndarray:
        """The newest rotor commands, (4,)."""
        return self._mixer.outputs

    @property
    def status(self) -> Px4Status:
        """A snapshot of the state."""
        commander = self._commander
        return Px4Status(
            time_us=self._time_us,
            mode=commander.mode,
            wanted_mode=commander.wanted_mode,
            armed=commander.armed,
            failsafe=commander.failsafe,
            landed_state=self._landed_state(),
            position_valid=self.estimate_valid,
            takeoff_state=self._takeoff.state,
            hover_thrust=self._position.hover_thrust,
            battery_remaining=self._battery,
        )

    # The step

    def step(self, state: VehicleState) -> np.ndarray:
        """Return the rotor commands (4,) from this instant on; the same array each time."""
        if self._started_us is None or state.time_us < self._time_us:
            self._started_us = self._time_us = self._position_us = state.time_us
            dt_s = 0.004
        else:
            dt_s = max(1e-6 * (state.time_us - self._time_us), 1e-4)
        self._time_us = state.time_us
        if self._revision != self.parameters.revision:
            self._reload()

        self._estimator.update(state, dt_s)
        if self._commander.armed:
            wanted = self._attitude.rates_setpoint if self._body_rates is None else self._body_rates
            integrate = not self._land_detector.maybe_landed
            estimate = self.estimate[0]
            torques = self._rate.update(estimate["rates"], wanted, self._mixer.saturation, integrate, dt_s)
            commands = self._mixer.mix(torques, self._thrust, self.parameters["THR_MDL_FAC"])
            setpoint = self._position.output[0]
            self._attitude.update(estimate["attitude"], setpoint["attitude"], setpoint["yaw_rate"])
        else:
            self._rate.reset_integral()
            commands = self._mixer.stop()
        since_us = state.time_us - self._position_us
        if since_us >= POSITION_PERIOD_US - 0.5e6 * dt_s:
            self._position_us = state.time_us
            self._navigate(min(max(1e-6 * since_us, 0.002), 0.04))
        return commands

    def _navigate(self, dt_s: float) -> None:
        """Run everything that waits for a position estimate, down to the attitude and thrust setpoint."""
        commander, estimate = self._commander, self.estimate
        commander.update(
            self._time_us, estimate["position"][0], self.estimate_valid, self._land_detector.landed
        )
        if commander.mode_entries != self._mode_entries:
            self._mode_entries = commander.mode_entries
            if commander.mode.is_auto and commander.home is not None:
                self._navigator.enter(commander.mode, estimate, commander.home, commander.takeoff_height_m)

        setpoint = self._active_setpoint(dt_s)
        is_local = isinstance(setpoint, np.ndarray)
        self._asked_to_sink_m_s = float(setpoint["velocity"][0, 2]) if is_local else math.nan
        self._body_rates = None
        if isinstance(setpoint, AttitudeSetpoint):
            self._takeoff.update(commander.armed, self._land_detector.landed, False, True, dt_s)
            self._follow_attitude(setpoint)
        else:
            self._control_position(setpoint, dt_s)
        self._estimate_hover_thrust(dt_s)
        self._land_detector.update(
            commander.armed,
            estimate,
            self._asked_to_sink_m_s,
            self._thrust,
            self._position.hover_thrust,
            self._hover.valid,
            dt_s,
        )
        drained = dt_s / self.parameters["SIM_BAT_DRAIN"] if commander.armed else 0.0
        self._battery = max(self._battery - drained, 0.01 * self.parameters["SIM_BAT_MIN_PCT"])

    def _active_setpoint(self, dt_s: float) -> np.ndarray | AttitudeSetpoint | None:
        """Return what the flying mode asks for: a setpoint record, an attitude, or None for nothing."""
        commander = self._commander
        if commander.mode is Mode.OFFBOARD and self._offboard is not None:
            if isinstance(self._offboard, AttitudeSetpoint):
                return self._offboard
            self._fill(self._setpoint, self._offboard)
            return self._setpoint
        if commander.mode.is_auto and commander.home is not None:
            self._setpoint[:] = self._navigator.update(self.estimate, commander.home, dt_s)
            if self._navigator.finished:
                commander.takeoff_finished()
            return self._setpoint
        return None

    def _control_position(self, setpoint: np.ndarray | None, dt_s: float) -> None:
        """Run take-off, position and velocity control; None: stay on the ground."""
        commander, control, p = self._commander, self._position, self.parameters
        landed = self._land_detector.landed
        wanted = setpoint is not None and landed and self._asks_to_climb(setpoint)
        self._takeoff.update(commander.armed, landed, wanted, False, dt_s)
        flying = self._takeoff.state >= TakeoffState.FLIGHT
        if not flying:
            control.set_hover_thrust(p["MPC_THR_HOVER"])
        on_ground = self._takeoff.state < TakeoffState.RAMPUP or (
            flying and self._land_detector.ground_contact
        )
        if setpoint is None or on_ground:
            setpoint = self._press_down
            control.reset_integral()
        up = p["MPC_TKO_SPEED"] if commander.mode is Mode.AUTO_TAKEOFF else p["MPC_Z_VEL_MAX_UP"]
        limits = control.limits[0]
        limits["tilt"] = math.radians(p["MPC_TILTMAX_AIR" if flying else "MPC_TILTMAX_LND"])
        limits["speed_up"] = min(self._takeoff.speed_limit(up, dt_s), p["MPC_Z_VEL_MAX_UP"])
        limits["speed_down"] = p["MPC_Z_VEL_MAX_DN"]
        limits["thrust_min"] = p["MPC_THR_MIN"] if flying else 0.0
        control.update(setpoint, self.estimate, dt_s)
        self._thrust = float(control.output["thrust"][0])

    def _follow_attitude(self, setpoint: AttitudeSetpoint) -> None:
        """Hand an attitude or body rates setpoint on to the inner controllers."""
        output = self._position.output[0]
        self._thrust = min(max(setpoint.thrust, 0.0), 1.0)
        output["thrust"] = self._thrust
        output["thrust_vector"] = (0.0, 0.0, -self._thrust)
        self._position.reset_integral()
        if setpoint.attitude is None:
            self._body_rates = np.array(setpoint.rates)
        else:
            output["attitude"] = setpoint.attitude
            output["yaw_rate"] = 0.0 if math.isnan(setpoint.rates[2]) else setpoint.rates[2]

    def _estimate_hover_thrust(self, dt_s: float) -> None:
        """Feed the hover thrust estimator while the vehicle is more than a metre above home."""
        hover, commander = self._hover, self._commander
        if self._land_detector.landed:
            self._in_air = False
        elif commander.home is not None and commander.home[2] - self.estimate["position"][0, 2] > 1.0:
            self._in_air = True
        if not (commander.armed and self._in_air):
            hover.invalidate()
            if not commander.armed:
                hover.reset()
            return
        thrust = -float(self._position.output["thrust_vector"][0, 2])
        hover.update(-float(self.estimate["acceleration"][0, 2]), thrust, dt_s)
        if hover.valid and self.parameters["MPC_USE_HTE"] == 1:
            self._position.update_hover_thrust(hover.hover_thrust)

    def _asks_to_climb(self, setpoint: np.ndarray) -> bool:
        """Whether a setpoint record asks to leave the ground."""
        asked = setpoint[0]
        if self._commander.mode in (Mode.AUTO_LOITER, Mode.AUTO_LAND):
            return False
        return bool(
            asked["position"][2] < self.estimate["position"][0, 2]
            or asked["velocity"][2] < 0.0
            or asked["acceleration"][2] < 0.0
        )

    def _landed_state(self) -> LandedState:
        if self._land_detector.landed:
            return LandedState.ON_GROUND
        return {Mode.AUTO_TAKEOFF: LandedState.TAKEOFF, Mode.AUTO_LAND: LandedState.LANDING}.get(
            self._commander.mode, LandedState.IN_AIR
        )

    def _levelled(self, setpoint: Setpoint) -> Setpoint:
        """Turn a body setpoint to NED: velocity by yaw, acceleration by the whole attitude, as PX4 does."""
        estimate = self.estimate[0]
        yaw = float(estimate["yaw"])
        vx, vy, vz = setpoint.velocity
        velocity = (
            math.cos(yaw) * vx - math.sin(yaw) * vy,
            math.sin(yaw) * vx + math.cos(yaw) * vy,
            vz,
        )
        w, x, y, z = estimate["attitude"].tolist()
        acceleration = rotate((x, y, z, w), setpoint.acceleration)
        return replace(setpoint, velocity=velocity, acceleration=acceleration, position=UNSET, body=False)

    def _reload(self) -> None:
        """Take changed parameters into the controllers."""
        self._revision = self.parameters.revision
        for controller in (self._position, self._attitude, self._rate):
            controller.load_parameters()

    @staticmethod
    def _fill(record: np.ndarray, setpoint: Setpoint) -> None:
        """Copy a setpoint into a record of SETPOINT_DTYPE."""
        row = record[0]
        row["position"] = setpoint.position
        row["velocity"] = setpoint.velocity
        row["acceleration"] = setpoint.acceleration
        row["yaw"] = setpoint.yaw
        row["yaw_rate"] = setpoint.yaw_rate
