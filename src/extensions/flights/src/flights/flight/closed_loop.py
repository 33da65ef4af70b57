"""The whole chain of the thesis's figure 5.2 without ROS, from the classes of the nodes.

The order at every instant t is that of the graph in lockstep. First come odometry, truth and the position
controller. Then come the scan, median filter, padding, CEPA, yaw regulator and publisher. The flight
controller comes last: it gets the setpoint from scan(t) before the next step. So there is no latency, and no
flight depends on the machine.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import Callable, Protocol, Self, Sequence

import numpy as np

from cepa import ALGORITHMS, LaserScan2D
from cepa.algorithm import Algorithm
from flights.errors import FlightError
from flights.flight.conditions import Delivery
from flights.flight.course import Action, Outcome, Phase
from flights.flight.due import Due
from flights.flight.flight_log import FlightLog
from flights.flight.judging.contacts import UavParts
from flights.flight.lidar.nodding import NoddingLidar
from flights.flight.mission_time import TimeIsOver
from flights.flight.monitor import Monitor
from flights.flight.parameters import ClosedLoopParameters
from flights.flight.publisher_link import PublisherLink
from flights.flight.steering_chain import Flown, SteeringChain
from flights.flight.without_gnss import IMU_PERIOD_US, Estimated, Outage, OwnOdometry, felt_by
from inspection_tools import Mission, PositionController, way_home
from inspection_tools.position_controller import STOP, PositionCommand
from simulation_tools.geometry import Pose, Vector3
from simulation_tools.px4.modes import Mode
from simulation_tools.sensors.odometry import OdometrySample
from simulation_tools.simulation import Simulation, StepOutput

Velocity = tuple[float, float, float]


class ScanListener(Protocol):
    """Gets every scan of a flight, but is not part of the control chain: a recorder, SLAM."""

    def on_scan(self, t_s: float, ranges: np.ndarray, odometry: Pose, truth: Pose) -> None:
        """Take the lidar's scan (beams,), and the poses of its instant in `odom` and `world`."""


class ClosedLoop:
    """One flight from take-off to landing. Use it as a context manager, or `close` it.

    own_odometry: without GNSS, the odometry that everything is flown by. correct: takes time in s and the
    pose of `pose_source`, returns the position and the heading that the mission is flown by (SLAM's).
    outage: a part that dies; set it at any time. position_controller: flies unless a pilot does. nodding: the
    lidar, if it nods; then only what lies near the level plane steers, and listeners get whole level scans.
    """

    def __init__(
        self,
        parameters: ClosedLoopParameters,
        steering: Algorithm | None = None,
        pilot: Callable[[float, Pose], Velocity] | None = None,
    ) -> None:
        """Build everything; raises SimulationToolsError if the world or the UAV cannot be loaded.

        steering: replaces `parameters.algorithm`, for example with one that records its input. pilot: takes
        time in s and true pose, returns a velocity (m/s; ahead, left, up). When the UAV is ready, this
        replaces the position controller's velocity.
        """
        self.parameters = parameters
        self.listeners: list[ScanListener] = []
        self.simulation = Simulation(parameters.conditions.applied_to(parameters.simulation))
        self._delivery = Delivery(parameters.conditions, parameters.simulation.seed)
        self.monitor = Monitor(parameters.limits_of_way, UavParts.of(self.simulation.uav.model))
        self.log: FlightLog = self.monitor.log
        """The flight's time series so far."""
        lidar, px4 = self.simulation.lidar, self.simulation.px4
        if lidar is None:
            self.simulation.close()
            raise FlightError("The UAV has no lidar, without which CEPA cannot fly; choose one.")
        assert px4 is not None  # no other mode was requested
        self._faults = parameters.conditions.faults_of(self.simulation.parameters, lidar)
        self.lidar, self._px4 = lidar, px4
        self.nodding = None if parameters.nod is None else NoddingLidar(self.simulation, parameters.nod)
        self._steering = SteeringChain(
            lidar,
            self.simulation.payload,
            steering or ALGORITHMS[parameters.algorithm](parameters.cepa),
            parameters.median_filter,
            parameters.padding,
            parameters.yaw_regulator,
            parameters.range_finders,
            uses_imu=parameters.imu,
        )
        self._imu_due = Due(IMU_PERIOD_US) if parameters.imu else None
        self.position_controller = PositionController(parameters.position_controller)
        self._mission: Mission | None = None
        self._returns = False
        self._pilot = pilot
        self.own_odometry = None if parameters.simulation.gnss else OwnOdometry(self.simulation, px4)
        self.correct: Callable[[float, Pose], tuple[Vector3, float]] = _as_it_is
        publisher = parameters.conditions.hover_of(parameters.publisher)
        if self.own_odometry is not None:
            publisher = replace(publisher, needs_home=False, needs_vision=True)
        self.publisher = PublisherLink(px4, publisher)
        self.outage: Outage | None = None
        self._odometry_us: int | None = None
        """Of the newest odometry that has arrived."""
        self._truth = Pose.identity()
        self._newest_odometry = Estimated(-1, OdometrySample(self._truth, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
        self._untold: deque[tuple[int, np.ndarray, Pose]] = deque()
        """Scans with their truth, of which the listeners do not know yet."""
        self.is_over = False
        """Whether the run has ended."""
        self._begun = self._told_ready = False
        self._is_whole = True
        """Whether every beam of the newest scan lies near the level plane."""

    @property
    def newest_scan(self) -> LaserScan2D | None:
        """CEPA's newest input: filtered and padded; None before the first scan."""
        return self._steering.newest_scan

    @property
    def time_s(self) -> float:
        """Simulation time."""
        return 1e-6 * self.simulation.time_us

    def point_front(self, stamp_s: float, front: tuple[float, float]) -> None:
        """Let the UAV's front point there (x, y), in its levelled frame of an instant."""
        self._steering.on_front(round(1e6 * stamp_s), front)

    @property
    def outcome(self) -> Outcome:
        """The outcome so far."""
        return self.monitor.course.outcome

    def run(self, until: Callable[[ClosedLoop], bool] = lambda loop: False) -> Outcome:
        """Fly until the run is over or `until(loop)` is true. The run's limits guarantee an end."""
        while not (self.is_over or until(self)):
            self.step()
        return self.outcome

    def run_to(self, phase: Phase) -> Outcome:
        """Fly until a phase has begun (or the run is over)."""
        has_begun = self.monitor.course.has_begun
        while not (self.is_over or has_begun(phase)):
            self.step()
        return self.outcome

    def step(self) -> StepOutput:
        """Simulate one time step and pass it on to all parts. The first call gives the instant t = 0."""
        output = self.simulation.step() if self._begun else self.simulation.sense()
        self._begun = True
        if self.outage is not None:
            output = self.outage.applied_to(output)
        if output.ground_truth is not None:
            self._truth = output.ground_truth.pose
        if output.scan is not None:
            output = self._levelled(self._spoiled(output))
        if self._imu_due is not None and self._imu_due(output.time_us):
            self._steering.on_imu(output.time_us, *felt_by(self._px4))
        has_reached_goal = False
        for estimated in self._odometry_known(output):
            has_reached_goal |= self._on_odometry(estimated)
        if output.ground_truth is not None:
            self._on_truth(1e-6 * output.time_us, self._truth)
        if has_reached_goal:
            self.monitor.on_goal_reached(True)
        if output.payload:
            self._fly(self._steering.on_payload(output.time_us, output.payload))
        if output.scan is not None and self._delivery.scan_arrives():
            self._on_scan(output, output.scan)
        self.publisher.on_time(output.time_us)
        self._watch(output)
        return output

    def _spoiled(self, output: StepOutput) -> StepOutput:
        """Return what the lidar gives in such conditions."""
        if not self._faults.are_any or output.ground_truth is None:
            return output
        assert output.scan is not None
        body, rays = output.ground_truth.pose, self.simulation.world.rays
        at_s, own = 1e-6 * output.time_us, self.simulation.uav_name
        return output._replace(scan=self._faults.spoiled(output.scan, at_s, rays, body, own))

    def _levelled(self, output: StepOutput) -> StepOutput:
        """Return what a lidar that nods tells of the level plane."""
        if self.nodding is None:
            return output
        assert output.scan is not None
        level = self.nodding.level(1e-6 * output.time_us, output.scan, self._truth)
        self._is_whole = level.is_whole
        return output._replace(scan=level.ranges)

    def _odometry_known(self, output: StepOutput) -> Sequence[Estimated]:
        """Return the odometry that is known now. Without GNSS it comes with the scans only."""
        if self.own_odometry is None:
            return () if output.odometry is None else (Estimated(output.time_us, output.odometry),)
        told_us = self.own_odometry.told_us
        estimated = self.own_odometry.on_step(output, self.outage)
        if self.own_odometry.told_us != told_us:
            self.publisher.on_vision(output.time_us)
        return estimated

    def _on_odometry(self, estimated: Estimated) -> bool:
        """Fly by a new pose. Return whether the goal is reached."""
        time_us, odometry = estimated
        t_s = 1e-6 * time_us
        age_s, arrived = self._delivery.odometry(t_s, odometry)
        self.log.odometry.add(t_s, *odometry.pose.position_m, *odometry.pose.orientation_xyzw)
        arrived_us = time_us - round(1e6 * age_s)
        if arrived_us != self._odometry_us:
            self._odometry_us = arrived_us
            self._fly(self._steering.on_odometry(arrived_us, arrived))
        by_truth = self.parameters.pose_source == "ground_truth"
        position_m, yaw_rad = self.correct(t_s, self._truth if by_truth else arrived.pose)
        reached = self._follow_mission(t_s, position_m) if self.parameters.mission else None
        command = self._command(t_s, position_m, yaw_rad)
        if self.nodding is not None:
            self.nodding.on_odometry(t_s, odometry.linear_velocity_m_s, command.goal_reached)
        v_ref = command.velocity_m_s
        if self._pilot is not None and self.publisher.ready:
            v_ref = self._pilot(t_s, self._truth)
        self.log.v_ref.add(t_s, *v_ref, 0.0)
        self._fly(self._steering.on_reference(time_us if by_truth else arrived_us, v_ref))
        self._newest_odometry = estimated
        if self._untold:
            self._tell_listeners()
        if reached is not None:
            return reached
        # Without a goal, who sets the setpoints says when the flight is over: a rest at one is no end.
        return command.goal_reached and self.parameters.goal_xyz_m is not None

    def _command(self, t_s: float, position_m: Vector3, yaw_rad: float) -> PositionCommand:
        if self.own_odometry is not None and not self.own_odometry.is_good:
            self.position_controller.reset()
            return STOP
        return self.position_controller.update(t_s, position_m, yaw_rad)

    def _on_truth(self, t_s: float, truth: Pose) -> None:
        actions = self.monitor.on_truth(t_s, truth.position_m, truth.orientation_xyzw)
        if actions:
            self._carry_out(actions)

    def _follow_mission(self, t_s: float, position_m: Vector3) -> bool:
        """Fly to the next waypoint. Return whether the mission is over."""
        if self._mission is None:
            return False
        status = self._mission.update(t_s, position_m)
        if status.target_changed:
            self.position_controller.set_setpoint(status.target.position_m)
        if status.stalled:
            self._carry_out(
                self.monitor.abort(f"Waypoint {status.reached + 1} of {status.of} was not reached.")
            )
        flying_s = t_s - self.outcome.times_s[Phase.FLYING]
        over = self.parameters.mission_time.over(flying_s, self._returns)
        if over is TimeIsOver.FLY_HOME and not status.done:
            self._fly_home(status.reached)
            return False
        return status.done or over is TimeIsOver.END_HERE

    def _fly_home(self, reached: int) -> None:
        self._returns = True
        start_m = self.parameters.simulation.spawn_pose.position_m
        home = way_home(self.parameters.mission, reached, start_m)
        self._mission = Mission(home, self.parameters.patience_s)

    def _on_scan(self, output: StepOutput, ranges: np.ndarray) -> None:
        if self._is_whole:
            self._untold.append((output.time_us, ranges, self._truth))
        self._tell_listeners()
        self.log.add_scan(1e-6 * output.time_us, ranges, self.lidar.angle_min, self.lidar.angle_increment)
        self._fly(self._steering.on_scan(output.time_us, ranges))

    def _tell_listeners(self) -> None:
        """Tell the listeners of each scan once its odometry is known; a scan that gets none is left out."""
        known_us, odometry = self._newest_odometry
        while self._untold and self._untold[0][0] <= known_us:
            time_us, ranges, truth = self._untold.popleft()
            if time_us == known_us:
                for listener in self.listeners:
                    listener.on_scan(1e-6 * time_us, ranges, odometry.pose, truth)

    def _fly(self, commands: Sequence[Flown]) -> None:
        for time_us, velocity_m_s, yaw_rate_rad_s, answer in commands:
            self.publisher.on_velocity(time_us, velocity_m_s, yaw_rate_rad_s)
            t_s = 1e-6 * time_us
            self.log.v_safe.add(t_s, *velocity_m_s, 0.0)
            self.log.v_final.add(t_s, *velocity_m_s, yaw_rate_rad_s)
            if answer is not None:
                decision = answer.decision
                self.log.decisions.add(
                    t_s,
                    answer.cpu_ms,
                    decision.directions_tested,
                    decision.cost,
                    decision.emergency,
                    decision.reason.value,
                )

    def _watch(self, output: StepOutput) -> None:
        for contact in output.contacts:
            shapes = contact.collision_1, contact.collision_2
            self.monitor.on_contact(1e-6 * output.time_us, *shapes, upwards=contact.normal[2])
        if self.publisher.ready is not self._told_ready:
            self._told_ready = self.publisher.ready
            self.monitor.course.on_ready(self._told_ready)
        if self._px4.armed_since_us is None:
            self._carry_out(self.monitor.on_armed(False))

    def _carry_out(self, actions: Sequence[Action]) -> None:
        for action in actions:
            if action is Action.SEND_GOAL:
                if self.parameters.mission:
                    self._mission = Mission(self.parameters.mission, self.parameters.patience_s)
                elif self.parameters.goal_xyz_m is not None:
                    self.position_controller.set_setpoint(self.parameters.goal_xyz_m)
            elif action is Action.LAND:
                self.land()
            else:
                self.is_over = True

    def land(self) -> None:
        """Order the flight controller to land where the UAV is."""
        self._px4.request_mode(Mode.AUTO_LAND)

    def abort(self, why: str) -> None:
        """End the run at once, unless it is over; `why` is a sentence."""
        self._carry_out(self.monitor.abort(why))

    @property
    def is_armed(self) -> bool:
        """Whether the motors may turn."""
        return self._px4.armed_since_us is not None

    @property
    def charge(self) -> float:
        """Charge of the battery, 0..1, as MAVLink tells it: in whole percent."""
        return round(1e2 * self._px4.status.battery.remaining) / 1e2

    def close(self) -> None:
        """Release the physics engine."""
        self.simulation.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def _as_it_is(_t_s: float, pose: Pose) -> tuple[Vector3, float]:
    return pose.position_m, pose.yaw_rad
