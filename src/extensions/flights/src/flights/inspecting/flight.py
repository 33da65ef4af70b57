"""An inspection in the closed loop without ROS and without GNSS, on as many batteries as it needs.

No pixel is rendered.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable

import numpy as np

from exploration.energy import EnergyWatch
from exploration.planning import PathPlanner, PlannerParameters
from flight_basics.geometry import heading_rate
from flights.errors import FlightError
from flights.exploring.battery_swap import BatterySwap
from flights.exploring.flight import BATTERY_US
from flights.exploring.flown_clouds import FlownClouds
from flights.exploring.itinerary import Itinerary, Next
from flights.exploring.volume_of_flight import VolumeOfFlight
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.due import Due
from gridslam.inputs.attitude import matrix_of_quaternion
from gridslam.odometry import OdometryEstimate
from gridslam.volume import VolumeParameters
from input_schemas import read_file
from inspection.camera.photograph_pose import PhotographPose
from inspection.flight import (
    Inspection,
    InspectionParameters,
    PhotographQuality,
    PhotographQueue,
    PriorMap,
    Task,
)
from inspection.flight.motion import Motion
from inspection.survey.plan import SurveyPlan
from inspection.survey.supplement import ROUNDS, Supplement
from inspection_tools import PositionControllerParameters, YawRegulatorParameters
from simulation_tools.camera.gimbal import BodyState, CameraState, TiltGimbal, blur_px, marks_px, motion_of
from simulation_tools.camera.renderer import Renderer
from simulation_tools.geometry import quaternion_from_rpy
from simulation_tools.simulation import StepOutput

CONTROLLER_YAML = Path(__file__).resolve().parents[3] / "config" / "inspecting_controller.yaml"


def controller_of(max_speed: float, lookahead: float = 0.5) -> PositionControllerParameters:
    """Return the position controller of an Iris that takes photographs, as inspection.launch has it."""
    return PositionControllerParameters(
        max_speed=max_speed, lookahead=lookahead, **_configured("position_controller")
    )


def regulator() -> YawRegulatorParameters:
    """Return its yaw regulator."""
    return YawRegulatorParameters(**_configured("yaw_regulator"))


def _configured(name: str) -> dict[str, float]:
    held = read_file(CONTROLLER_YAML, "The controller", dict[str, dict[str, float]], FlightError)
    return held[name]


@dataclass(frozen=True)
class FlightOnBattery:
    """From the hover above home to the next one there. charge: of the battery at its end, 0..1."""

    began_s: float
    ended_s: float
    photographs: int
    charge: float


@dataclass
class Photographed:
    """Good photographs of an inspection: `true` where the camera was, `estimated` where odometry says it was.

    shots: of the shutter, bad ones too. flights: on one battery each.
    """

    true: list[PhotographPose] = field(default_factory=list)
    estimated: list[PhotographPose] = field(default_factory=list)
    shots: int = 0
    flights: list[FlightOnBattery] = field(default_factory=list)

    @property
    def flight_s(self) -> float:
        """Of all flights, without the landings between."""
        return sum(each.ended_s - each.began_s for each in self.flights)


class InspectingFlight:
    """Leads a closed loop from photograph to photograph, and home.

    Args:
        loop: a flight without GNSS, with a lidar that has clouds, and without a goal.
        plan: its photographs. renderer: tells light and distance of each. planner, volume, parameters: see
            there. prior: the drawing of the place. energy: watches the battery; None: it does not count.
            swaps: of the battery, at most. supplement: plans photographs of what the plan's did not show;
            None: no such photographs.

    Attributes:
        photographed: so far. on_photograph: called after each good one. landed_at: charge of the battery at
            each landing, 0..1.

    Raises:
        FlightError: the UAV has no clouds or flies by GNSS.
    """

    def __init__(
        self,
        loop: ClosedLoop,
        plan: SurveyPlan,
        renderer: Renderer,
        planner: PlannerParameters,
        volume: VolumeParameters,
        parameters: InspectionParameters,
        prior: PriorMap | None = None,
        energy: EnergyWatch | None = None,
        swaps: int = 0,
        supplement: Supplement | None = None,
    ) -> None:
        self._loop, self._renderer = loop, renderer
        self.volume = VolumeOfFlight(PathPlanner(planner), volume, prior)
        self._clouds = FlownClouds(loop, self.volume, "An inspection")
        queue = PhotographQueue(plan.views, (), parameters.tries)
        self.inspection = Inspection(self.volume.planner, queue, parameters.for_plan(plan), energy)
        self._supplement, self._rounds = supplement, ROUNDS
        self.inspection.awaits = supplement is not None
        self._itinerary = Itinerary(1, swaps)
        self._swap = BatterySwap(loop, self._take_battery, self.volume)
        self._energy, self._battery_is_due = energy, Due(BATTERY_US)
        self._gimbal, self._supplemented = TiltGimbal(), 0
        self._camera: CameraState | None = None
        self._setpoint_m: np.ndarray | None = None
        self._began_s: float | None = None
        self.photographed = Photographed()
        self.landed_at: list[float] = []
        self.on_photograph: Callable[[], None] = lambda: None

    def run(self) -> Photographed:
        """Fly until the UAV has landed, or the run has failed."""
        loop = self._loop
        while not loop.is_over:
            output = loop.step()
            self._clouds.take(output)
            self._hold_camera(output)
            if self._clouds.newest is not None:
                self._lead(self._clouds.newest, loop.monitor.course.phase is Phase.FLYING)
        if loop.outcome.landed:
            self.landed_at.append(self._charge)
        return self.photographed

    @property
    def _charge(self) -> float:
        power = self._loop.simulation.power
        return 1.0 if power is None else power.battery.remaining

    def _take_battery(self) -> bool:
        self.landed_at.append(self._charge)
        return self._itinerary.take_battery()

    def _hold_camera(self, output: StepOutput) -> None:
        truth = output.ground_truth
        if truth is not None:
            body = BodyState(
                1e-6 * output.time_us, truth.pose, truth.linear_velocity_m_s, truth.angular_velocity_rad_s
            )
            self._camera = self._gimbal.follow(body)

    def _lead(self, estimate: OdometryEstimate, is_flying: bool) -> None:
        lead, now_s = self.inspection, self._loop.time_s
        motion = _motion_of(estimate, now_s)
        if not is_flying:
            return
        if self._swap.follow(motion.place_m):
            self._began_s = None
        if self._swap.is_under_way:
            return
        if self._began_s is None:
            self._began_s = now_s
            lead.begin(now_s, motion.place_m)
        if self._energy is not None and self._battery_is_due(round(1e6 * now_s)):
            self._energy.offer(now_s, self._loop.charge)
        if lead.is_waiting:
            self._take_more()
        if lead.follow(motion):
            self.volume.tell_planner()
            lead.look(now_s, motion.place_m)
        task = lead.shutter(motion)
        if task is not None:
            self._photograph(task, estimate)
        self._send(motion)
        if lead.is_home or lead.must_land:
            self._end_flight(now_s)

    def _take_more(self) -> None:
        """Photograph what is still open, if the UAV can. It does not wait for this plan."""
        assert self._supplement is not None
        lead, more = self.inspection, None
        if self._rounds:
            self._rounds -= 1
            for taken in self.photographed.estimated[self._supplemented :]:
                self._supplement.add(taken)
            self._supplemented = len(self.photographed.estimated)
            left_out_m = [view.place_m for view in lead.queue.views_left_out]
            more = self._supplement.plan_more(left_out_m, np.random.default_rng(self._rounds))
        if more is None:
            lead.look_again(())
        else:
            lead.take_more(more.views)

    def _photograph(self, task: Task, estimate: OdometryEstimate) -> None:
        lead, shot = self.inspection, self._shoot(task, estimate)
        if not lead.judge_quality(task, shot) and task.number in lead.queue.done:
            self.photographed.true.append(self._true().moved(shot.shift_m, shot.turn_rad))
            self.photographed.estimated.append(self._estimated(estimate).moved(shot.shift_m, shot.turn_rad))
            self.on_photograph()

    def _end_flight(self, now_s: float) -> None:
        """Land for a battery, or for good."""
        assert self.inspection.end is not None
        assert self._began_s is not None
        told = self.photographed
        before = sum(each.photographs for each in told.flights)
        told.flights.append(FlightOnBattery(self._began_s, now_s, len(told.true) - before, self._charge))
        follows = self._itinerary.after(self.inspection.end.value, self.inspection.is_home)
        if follows is Next.AGAIN:
            self._swap.begin()
        elif follows is Next.LOST:
            self._loop.monitor.land_here(f"The UAV did not come home: {self.inspection.reason}")
        else:
            self._loop.monitor.on_goal_reached(True)

    def _send(self, motion: Motion) -> None:
        lead, loop = self.inspection, self._loop
        if lead.setpoint_m is not None and lead.setpoint_m is not self._setpoint_m:
            self._setpoint_m = lead.setpoint_m
            loop.position_controller.set_setpoint(lead.setpoint_m.tolist())
        if lead.front_rad is not None:
            turn = lead.front_rad - motion.yaw_rad
            loop.point_front(motion.time_s, (math.cos(turn), math.sin(turn)))
        self._gimbal.command(lead.tilt_rad)

    def _shoot(self, task: Task, estimate: OdometryEstimate) -> PhotographQuality:
        assert self._camera is not None
        self.photographed.shots += 1
        light = self._renderer.meter(self._camera.pose, *self.inspection.metering(task))
        depths_m = self._renderer.depths_m(self._camera.pose, marks_px(self._renderer.optics))
        blur, _ = blur_px(self._camera, self._renderer.optics, depths_m)
        # As in the node: the drift, which only grows, is SLAM's to correct.
        deviation_m = math.sqrt(max(np.linalg.eigvalsh(estimate.matched_covariance[:3, :3]).max(), 0.0))
        motion = motion_of(self._camera, self._renderer.optics.exposure_s)
        return PhotographQuality(blur, light.lux, light.metered.iso, deviation_m, *motion)

    def _true(self) -> PhotographPose:
        assert self._camera is not None
        return PhotographPose(np.array(self._camera.pose.position_m), self._camera.pose.rotation)

    def _estimated(self, estimate: OdometryEstimate) -> PhotographPose:
        assert self._camera is not None
        turn = matrix_of_quaternion(quaternion_from_rpy(*estimate.roll_pitch_yaw))
        in_body = self._camera.in_body
        place_m = np.array(estimate.position_xyz) + turn @ np.array(in_body.position_m)
        return PhotographPose(place_m, turn @ in_body.rotation)


def _motion_of(estimate: OdometryEstimate, now_s: float) -> Motion:
    speed = float(np.linalg.norm(estimate.velocity_xyz))
    place_m = np.array(estimate.position_xyz)
    turn = heading_rate(quaternion_from_rpy(*estimate.roll_pitch_yaw), estimate.rates_rad_s)
    return Motion(now_s, place_m, estimate.roll_pitch_yaw[2], speed, turn)
