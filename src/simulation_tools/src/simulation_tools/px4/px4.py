"""The PX4 stand-in: estimator, commander, navigator, controllers and mixer in lockstep with the physics.

A step runs the parts in the order of PX4's work queues: rates and mixer on the newest gyro sample first, then
the attitude controller, then, at about 125 Hz, everything that waits for a position estimate. So a position
setpoint reaches the rotors two steps later, as in PX4. Attitude, velocity and position reach the controllers
one sample later than the gyro's rates, because EKF2 integrates first. The measured peak tilts show this
delay.
"""

from __future__ import annotations

from typing import Any, Callable, Sequence

import numpy as np

from simulation_tools.autopilot import Px4Error, VehicleState
from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.px4.commander import Commander
from simulation_tools.px4.commands import Commands
from simulation_tools.px4.control.flight_control import FlightControl
from simulation_tools.px4.control.mixer import QUAD_WIDE
from simulation_tools.px4.control.records import SETPOINT_DTYPE, fill
from simulation_tools.px4.control.takeoff import TakeoffState
from simulation_tools.px4.estimation.choice import STEADY, make_estimator
from simulation_tools.px4.estimation.interface import EstimatorStatus
from simulation_tools.px4.estimation.samples import ExternalVision, RangeSample
from simulation_tools.px4.estimation.steady_estimator import EstimatorNoise
from simulation_tools.px4.modes import LandedState, Mode, Result, Severity
from simulation_tools.px4.navigator import Navigator
from simulation_tools.px4.parameters import Px4Parameters
from simulation_tools.px4.plan.feasibility import FeasibilityCheck
from simulation_tools.px4.plan.mission import Mission
from simulation_tools.px4.plan.plan import Plan
from simulation_tools.px4.plan.waypoints import Vehicle
from simulation_tools.px4.safety.battery import Battery
from simulation_tools.px4.safety.geofence import Geofence
from simulation_tools.px4.setpoint import NAN, AttitudeSetpoint, Setpoint
from simulation_tools.px4.status import Px4Status
from simulation_tools.vehicle.airframe import Airframe
from simulation_tools.vehicle.energy.battery import BatteryReading

POSITION_PERIOD_US = 8_000


class Px4:
    """One flight controller; an `Autopilot`.

    `on_statustext` (severity, text) is called with PX4's messages for a ground station. `newest_range`: the
    last distance to the ground that was offered.
    """

    def __init__(
        self,
        airframe: Airframe,
        parameters: Px4Parameters | None = None,
        rng: np.random.Generator | None = None,
        noise: EstimatorNoise | None = None,
        origin: GeodeticOrigin | None = None,
        estimator: str = STEADY,
    ) -> None:
        """estimator: `steady`, the truth with small errors, or `ekf2`, a filter on simulated sensors.

        noise: of the steady estimate, PX4-like by default. rng: source of all noise; fixed seed 0 when none
        is given.

        origin: where the world's origin lies on earth; Zurich, as PX4 SITL's, by default. From the first step
        on `origin` is where the local frame begins: where the vehicle then was.
        """
        if len(airframe.rotors) != len(QUAD_WIDE):
            raise Px4Error(f"PX4's wide quadrotor needs 4 rotors, the model has {len(airframe.rotors)}")
        self.parameters = parameters or Px4Parameters()
        self.on_statustext: Callable[[Severity, str], None] = lambda severity, text: None
        p = self.parameters
        self._estimator = make_estimator(estimator, noise, rng or np.random.default_rng(0), p)
        self._world_origin = origin or GeodeticOrigin()
        self._commander = Commander(p, self._say)
        self.plan = Plan()
        self._battery = Battery(p, self._commander, self._say)
        self._fence = Geofence(p, self.plan, self._commander, lambda: self.origin, self._say)
        check = FeasibilityCheck(p, self._fence.allows, self._say)
        self.mission = Mission(p, self.plan, lambda: self.origin, self.command, check, self._say)
        self._navigator = Navigator(p, self.mission, lambda: self.origin, self._say)
        self._control = FlightControl(p)
        self._commands = Commands(
            self._commander,
            lambda: self.origin,
            self._say,
            self._navigator.set_cruise_speed,
            self.plan,
            self._fence,
        )
        self._setpoint = np.zeros(1, SETPOINT_DTYPE)
        self._setpoint_of: Setpoint | None = None  # whose numbers it holds
        self._known = self._estimator.estimate.copy()
        self._take_views()
        self.reset()

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Become a copy, with views of its own records."""
        vars(self).update(state)
        self._take_views()

    def _take_views(self) -> None:
        """Look up the records' fields once: in a step that would take longer than to use their numbers."""
        newest, known = self._estimator.estimate, self._known
        self._newest_numbers, self._known_numbers = newest.view(float), known.view(float)
        self._newest_rates, self._newest_attitude = newest["rates"][0], newest["attitude"][0]
        self._newest_yaw = newest["yaw"]
        self._known_attitude, self._known_position = known["attitude"][0], known["position"][0]
        self._known_yaw = known["yaw"]

    def reset(self) -> None:
        """Go back to power-on, parameters kept."""
        for part in (
            self._estimator,
            self._commander,
            self._battery,
            self._fence,
            self.mission,
            self._navigator,
            self._control,
        ):
            part.reset()
        self._remember_estimate()
        self.origin = self._world_origin
        self._revision = self.parameters.revision
        self._time_us = 0
        self._position_us = 0
        self._mode_entries = -1
        self._offboard: Setpoint | AttitudeSetpoint | None = None
        self._measured_battery: BatteryReading | None = None
        self.newest_range: RangeSample | None = None

    def close(self) -> None:
        """Nothing to release."""

    def _say(self, severity: Severity, text: str) -> None:
        self.on_statustext(severity, text)

    # Input

    def offer_setpoint(self, setpoint: Setpoint | AttitudeSetpoint) -> bool:
        """Take in an offboard setpoint. Return False if it asks for nothing; then it does not count.

        Without a local position only attitudes and rates keep OFFBOARD alive.
        """
        if not setpoint.asks_something:
            return False
        if self.estimate_valid or isinstance(setpoint, AttitudeSetpoint):
            self._commander.setpoint_received(self._time_us)
        if isinstance(setpoint, Setpoint) and setpoint.body:
            setpoint = setpoint.in_local_frame(self._newest_yaw.item(), self._newest_attitude.tolist())
        self._offboard = setpoint
        return True

    def offer_external_vision(self, sample: ExternalVision) -> None:
        """Take in a sample of an external vision."""
        self._estimator.offer_external_vision(sample)

    def offer_range(self, sample: RangeSample) -> None:
        """Take in a distance to the ground."""
        self.newest_range = sample
        self._estimator.offer_range(sample)

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
        return self._commands.handle(command, params)

    # Output

    @property
    def estimate(self) -> np.ndarray:
        """The newest estimate, one record of ESTIMATE_DTYPE (NED), shape (1,)."""
        return self._estimator.estimate

    @property
    def estimate_valid(self) -> bool:
        """Whether there is a local position."""
        return self._estimator.horizontal_valid

    @property
    def has_gnss(self) -> bool:
        """Whether there is a GNSS receiver. Without one PX4 tells no place on earth, and no home."""
        return self._estimator.uses_gnss

    @property
    def estimator_status(self) -> EstimatorStatus:
        """How good the estimate is."""
        return self._estimator.status

    @property
    def home(self) -> np.ndarray | None:
        """Home position, NED, (3,); None before there is one."""
        return self._commander.home

    @property
    def armed_since_us(self) -> int | None:
        """Time since which the rotors may turn; None: they may not."""
        return self._commander.armed_us if self._commander.armed else None

    @property
    def attitude_setpoint(self) -> np.ndarray:
        """The newest output of the position controller, one record, shape (1,)."""
        return self._control.position.output

    @property
    def active_setpoint(self) -> np.ndarray:
        """The setpoint that the position controller follows, one record of SETPOINT_DTYPE, shape (1,)."""
        return self._setpoint

    @property
    def follows_position(self) -> bool:
        """Whether the position controller flies, instead of a client's attitude or rates."""
        is_offboard = self._commander.mode is Mode.OFFBOARD
        return not (is_offboard and isinstance(self._offboard, AttitudeSetpoint))

    @property
    def rates_setpoint(self) -> np.ndarray:
        """The newest rates setpoint, rad/s FRD, (3,)."""
        return self._control.attitude.rates_setpoint

    @property
    def commands(self) -> np.ndarray:
        """The newest rotor commands, (4,)."""
        return self._control.mixer.outputs

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
            controls_attitude=not (commander.mode is Mode.OFFBOARD and self._offboard_is_rates),
            landed_state=self._landed_state(),
            position_valid=self.estimate_valid,
            hover_thrust=self._control.position.hover_thrust,
            battery=self._battery.reading,
            battery_level=self._battery.level,
            terminated=commander.is_terminated,
        )

    def swap_battery(self) -> None:
        """Let the battery be full again that it simulates itself, because no monitor tells one."""
        self._battery.swap()

    # The step

    def is_ready(self) -> bool:
        """Return True: it waits for no other program."""
        return True

    def begin(self, state: VehicleState) -> None:
        """Do nothing: `step` does all the work."""

    def step(self, state: VehicleState) -> np.ndarray:
        """Return the rotor commands (4,) from this instant on; the same array each time."""
        is_first = self._estimator.origin_m is None
        if is_first or state.time_us < self._time_us:
            self._time_us = self._position_us = state.time_us
            dt_s = 0.004
        else:
            dt_s = max(1e-6 * (state.time_us - self._time_us), 1e-4)
        self._time_us = state.time_us
        self._measured_battery = state.battery
        if self._revision != self.parameters.revision:
            self._revision = self.parameters.revision
            self._control.load_parameters()

        self._remember_estimate()
        self._estimator.update(state, dt_s, not self._control.land_detector.landed)
        if is_first and self._estimator.origin_m is not None:
            self.origin = self._world_origin.moved(self._estimator.origin_m)
        armed = self._commander.armed and not self._commander.is_terminated
        commands = self._control.update_inner_loop(armed, self._newest_rates, self._known_attitude, dt_s)
        since_us = state.time_us - self._position_us
        if since_us >= POSITION_PERIOD_US - 0.5e6 * dt_s:
            self._position_us = state.time_us
            self._navigate(min(max(1e-6 * since_us, 0.002), 0.04))
        return commands

    def _remember_estimate(self) -> None:
        # As plain numbers: numpy would copy the record field by field, which takes three times as long.
        self._known_numbers[:] = self._newest_numbers

    def _navigate(self, dt_s: float) -> None:
        """Run everything that needs a position estimate, down to the attitude and thrust setpoint."""
        commander, estimate = self._commander, self._known
        detector, is_valid = self._control.land_detector, self.estimate_valid
        landed = detector.landed
        commander.update(
            self._time_us,
            self._known_position,
            self._known_yaw.item(),
            is_valid,
            self._estimator.vertical_valid,
            landed,
            detector.maybe_landed,
        )
        self._watch(dt_s, is_valid and self.has_gnss, landed)
        if commander.mode_entries != self._mode_entries:
            self._mode_entries = commander.mode_entries
            if commander.armed and commander.mode.is_auto:
                self._navigator.enter(commander, estimate, landed, self._vehicle())
        self._control.update(self._active_setpoint(dt_s, is_valid), estimate, commander, dt_s)

    def _watch(self, dt_s: float, has_place: bool, landed: bool) -> None:
        """Let the plan, the battery and the fence change the mode. has_place: on earth."""
        commander = self._commander
        self.mission.watch(commander.home if has_place else None, landed)
        commander.mission_is_valid = self.mission.is_valid and has_place
        self._battery.update(self._measured_battery, self._known_position, dt_s, has_place)
        if has_place:
            self._fence.update(self._time_us, self._known, self._battery.is_failing)
        if not (commander.armed and commander.mode is Mode.AUTO_MISSION):
            self.mission.rest(commander.mode, commander.armed, landed)

    def _vehicle(self) -> Vehicle:
        detector, home = self._control.land_detector, self._commander.home
        return Vehicle(
            1e-6 * self._time_us,
            self._known_position,
            float(self._known["yaw"][0]),
            np.zeros(3) if home is None else home,
            detector.landed,
            detector.maybe_landed,
        )

    def _active_setpoint(self, dt_s: float, is_valid: bool) -> np.ndarray | AttitudeSetpoint | None:
        """Return the mode's setpoint: a setpoint record, an attitude, or None."""
        commander = self._commander
        if commander.mode is Mode.OFFBOARD and self._offboard is not None:
            if isinstance(self._offboard, AttitudeSetpoint):
                return self._offboard
            if not is_valid:
                return self._blind_landing()
            return self._filled_with(self._offboard)
        if not (commander.armed and commander.mode.is_auto):
            return None
        if not is_valid:
            return self._blind_landing()
        if commander.home is None:
            return None
        landed = self._control.land_detector.landed
        if self._navigator.is_taking_off and self._control.takeoff.state < TakeoffState.RAMPUP:
            self._navigator.stand(self._known_position)
        asked = self._navigator.update(self._known, commander.home, landed, dt_s, self._vehicle())
        if asked is None:
            return None
        self._setpoint[:] = asked
        self._setpoint_of = None
        if self._navigator.finished:
            commander.takeoff_finished()
        return self._setpoint

    def _blind_landing(self) -> np.ndarray:
        """Return the setpoint without a position: level, sinking, and drifting wherever it drifts."""
        sinking = Setpoint(
            velocity=(NAN, NAN, self.parameters["MPC_LAND_SPEED"]), acceleration=(0.0, 0.0, NAN)
        )
        return self._filled_with(sinking)

    def _filled_with(self, setpoint: Setpoint) -> np.ndarray:
        if setpoint is not self._setpoint_of:
            self._setpoint_of = setpoint
            fill(self._setpoint, setpoint)
        return self._setpoint

    @property
    def _offboard_is_rates(self) -> bool:
        return isinstance(self._offboard, AttitudeSetpoint) and self._offboard.attitude is None

    def _landed_state(self) -> LandedState:
        if self._control.land_detector.landed:
            return LandedState.ON_GROUND
        mode = self._commander.mode
        if mode.is_auto and self._navigator.is_taking_off:
            return LandedState.TAKEOFF
        landing = mode.is_auto and self._navigator.is_landing
        return LandedState.LANDING if landing else LandedState.IN_AIR
