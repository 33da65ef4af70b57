"""One flight of photographs in the closed loop without ROS and without GNSS. No pixel is rendered."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from gridslam.inputs.attitude import matrix_of_quaternion
from gridslam.odometry import OdometryEstimate
from gridslam.volume import VolumeParameters
from inspection_tools.inspection import Inspection, InspectionParameters, PriorMap, Shot, Todo
from inspection_tools.inspection.leg import Motion
from inspection_tools.planning import PathPlanner, PlannerParameters
from inspection_tools.survey.plan import SurveyPlan
from inspection_tools.survey.poses import Taken
from master_thesis.exploring.flown_clouds import FlownClouds
from master_thesis.exploring.volume_of_flight import VolumeOfFlight
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.course import Phase
from simulation_tools.camera.gimbal import BodyState, CameraState, TiltGimbal, blur_px, marks_px
from simulation_tools.camera.renderer import Renderer
from simulation_tools.geometry import quaternion_from_rpy
from simulation_tools.simulation import StepOutput


@dataclass
class Photographed:
    """Good photographs of a flight: where the camera truly was, and where the odometry says it was.

    shots: of the shutter, bad ones too. began_s, ended_s: from the first way to the way home's end.
    """

    true: list[Taken] = field(default_factory=list)
    told: list[Taken] = field(default_factory=list)
    shots: int = 0
    began_s: float = math.nan
    ended_s: float = math.nan


class InspectingFlight:
    """Leads a closed loop from photograph to photograph, and home. The battery does not count.

    Args:
        loop: a flight without GNSS, with a lidar that has clouds, and without a goal.
        plan: its photographs. renderer: tells light and distance of each. planner, volume, parameters: see
            there. prior: the drawing of the place.

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
    ) -> None:
        self._loop, self._renderer = loop, renderer
        self.volume = VolumeOfFlight(PathPlanner(planner), volume, prior)
        self._clouds = FlownClouds(loop, self.volume, "An inspection")
        todo = Todo(plan.views, (), parameters.tries)
        self.inspection = Inspection(self.volume.planner, todo, parameters)
        self._gimbal = TiltGimbal()
        self._camera: CameraState | None = None
        self._setpoint_m: np.ndarray | None = None
        self._has_begun = False
        self.photographed = Photographed()

    def run(self) -> Photographed:
        """Fly until the UAV has landed, or the run has failed."""
        loop = self._loop
        while not loop.is_over:
            output = loop.step()
            self._clouds.take(output)
            self._hold_camera(output)
            if self._clouds.newest is not None:
                self._lead(self._clouds.newest, loop.monitor.course.phase is Phase.FLYING)
        return self.photographed

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
        if not self._has_begun:
            self._has_begun = True
            self.photographed.began_s = now_s
            lead.begin(now_s, motion.place_m)
        if lead.follow(motion):
            self.volume.tell_planner()
            lead.look(now_s, motion.place_m)
        task = lead.shutter(motion)
        if task is not None:
            shot = self._shoot(estimate)
            if not lead.judge(task, shot) and task.number in lead.todo.done:
                self.photographed.true.append(self._true())
                self.photographed.told.append(self._told(estimate))
        self._send(motion)
        if lead.is_home:
            self.photographed.ended_s = now_s
            self._loop.monitor.on_goal_reached(True)

    def _send(self, motion: Motion) -> None:
        lead, loop = self.inspection, self._loop
        if lead.setpoint_m is not None and lead.setpoint_m is not self._setpoint_m:
            self._setpoint_m = lead.setpoint_m
            loop.position_controller.set_setpoint(lead.setpoint_m.tolist())
        if lead.front_rad is not None:
            turn = lead.front_rad - motion.yaw_rad
            loop.point_front(motion.stamp_s, (math.cos(turn), math.sin(turn)))
        self._gimbal.command(lead.tilt_rad)

    def _shoot(self, estimate: OdometryEstimate) -> Shot:
        assert self._camera is not None
        self.photographed.shots += 1
        lux, iso = self._renderer.meter(self._camera.pose)
        depths_m = self._renderer.depths_m(self._camera.pose, marks_px(self._renderer.optics))
        blur, _ = blur_px(self._camera, self._renderer.optics, depths_m)
        # As in the node: the drift, which only grows, is SLAM's to correct.
        deviation_m = math.sqrt(max(np.linalg.eigvalsh(estimate.matched_covariance[:3, :3]).max(), 0.0))
        return Shot(blur, lux, iso, deviation_m)

    def _true(self) -> Taken:
        assert self._camera is not None
        return Taken(np.array(self._camera.pose.position_m), self._camera.pose.rotation)

    def _told(self, estimate: OdometryEstimate) -> Taken:
        assert self._camera is not None
        turn = matrix_of_quaternion(quaternion_from_rpy(*estimate.roll_pitch_yaw))
        in_body = self._camera.in_body
        place_m = np.array(estimate.position_xyz) + turn @ np.array(in_body.position_m)
        return Taken(place_m, turn @ in_body.rotation)


def _motion_of(estimate: OdometryEstimate, now_s: float) -> Motion:
    speed = float(np.linalg.norm(estimate.velocity_xyz))
    place_m = np.array(estimate.position_xyz)
    return Motion(now_s, place_m, estimate.roll_pitch_yaw[2], speed, estimate.rates_rad_s[2])
