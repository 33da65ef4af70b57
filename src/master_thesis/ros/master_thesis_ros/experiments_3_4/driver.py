"""The node `experiments_3_4`: starts the mission, watches SLAM, and writes the map's error."""

from __future__ import annotations

import uuid
from enum import Enum
from typing import Iterable, Sequence

import numpy as np
import rospy
from actionlib_msgs.msg import GoalID, GoalStatus
from geometry_msgs.msg import Point, Pose
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool

from flights.flight.course import Phase
from flights.flight.flight_log import POSE_COLUMNS
from flights.flight.judging.contacts import UavParts
from flights.flight.mission_time import TimeIsOver
from flights.flight.monitor import Monitor
from flights.launch_arguments.cepa_parameters import cepa_keeps_m
from flights.results.run_files import FlownRun, complete_run, write_numbers
from flights_ros.drivers.flight_node import FlightNode
from flights_ros.drivers.messages import stamp_s
from flights_ros.drivers.parameters import all_parameters
from flights_ros.drivers.progress import FlightProgress, ProgressLog
from flights_ros.drivers.run import Run
from flights_ros.drivers.volume_files import has_volume, save_volume
from gridslam import SlamError
from inspection_tools import Waypoint, way_home
from inspection_tools.msg import MissionActionFeedback, MissionActionGoal, MissionActionResult
from master_thesis.experiments_3_4.request import MissionFlight, read
from master_thesis_ros.experiments_3_4.lidar_watch import LidarWatch
from master_thesis_ros.experiments_3_4.slam_watch import SlamWatch
from node_tools.ending import Ending
from node_tools.node import RunNode

SCAN_PERIOD_S = 1.0
"""Simulated time between two scans that are kept for the pictures of a flight of four minutes."""


class Experiments34Node(FlightNode):
    """Lets the node `mission` fly its mission to the end, or until the time is over.

    When the time is over, the flight ends there, or the node `mission` gets a second goal: the way home.

    Subscribes, besides the topics of `FlightNode` and `SlamWatch`: mission_result
        (inspection_tools/MissionActionResult), mission_feedback (inspection_tools/MissionActionFeedback).
    Publishes: mission_goal (inspection_tools/MissionActionGoal, latched), mission_cancel
        (actionlib_msgs/GoalID).
    Parameters: see doc/reference.md.
    """

    scan_topic = "mapped_scan"
    """Not scan: rospy would remap lidar_scan, which is /scan, once more."""

    def __init__(self, monitor: Monitor, slam: SlamWatch, flight: MissionFlight, lockstep: bool) -> None:
        self._slam = slam
        self._flight = flight
        self._reached, self._progress = 0, FlightProgress()
        self._flies_home = False
        self._uav_is_ready = False
        self._goal = rospy.Publisher("mission_goal", MissionActionGoal, queue_size=1, latch=True)
        self._cancel = rospy.Publisher("mission_cancel", GoalID, queue_size=1)
        super().__init__(monitor, lockstep)
        self.subscribe("mission_result", MissionActionResult, self._on_result)
        self.subscribe("mission_feedback", MissionActionFeedback, self._on_feedback)

    def send_goal(self) -> None:
        """Start the mission of the node's own file."""
        self._slam.begin()
        self._send()
        rospy.loginfo("The UAV hovers over the start and begins its mission.")

    def _send(self, waypoints: Sequence[Waypoint] = ()) -> None:
        goal = MissionActionGoal()
        goal.goal_id.id = f"the experiment's mission {uuid.uuid4()}"  # of no earlier run on this master
        goal.goal.waypoints = [Pose(position=Point(*waypoint.position_m)) for waypoint in waypoints]
        self._goal.publish(goal)

    def _carry_out(self, action: Enum) -> None:
        if action is not TimeIsOver.FLY_HOME:
            return super()._carry_out(action)
        start_m = self._flight.description.scenario.start_xyz_yaw[:2]
        self._send(way_home(self._flight.mission, self._reached, start_m))
        rospy.loginfo("The mission's time is over. The UAV flies back to its start.")

    def _on_feedback(self, message: MissionActionFeedback) -> None:
        told = message.feedback
        if not self._flies_home:
            self._reached = told.reached
        phase = "Flying home" if self._flies_home else "Flying the mission"
        ends = self._flight.time.left_in_words(self._flying_s, self._flies_home)
        self._progress.tell(
            phase, f"{told.reached} of {told.of} waypoints, {told.distance:.0f} m to the next one{ends}"
        )

    def _on_result(self, message: MissionActionResult) -> Iterable[Enum]:
        if message.status.status == GoalStatus.SUCCEEDED:
            self._monitor.on_goal_reached(True)
        elif message.status.status in (GoalStatus.ABORTED, GoalStatus.REJECTED):
            return self._monitor.abort(f"The mission ended early: {message.status.text}")
        return ()

    def _on_ready(self, message: Bool) -> None:
        self._uav_is_ready = message.data

    def _on_ground_truth(self, message: Odometry) -> Iterable[Enum]:
        if not self._lockstep:
            self._await_slam()
            return [*self._end_in_time(), *super()._on_ground_truth(message)]
        return super()._on_ground_truth(message)

    def _decisions(self) -> Sequence[Enum]:
        self._await_slam()
        return [*self._end_in_time(), *super()._decisions()]

    def _await_slam(self) -> None:
        """Let the flight begin after SLAM's start, because SLAM must see all of it."""
        if self._uav_is_ready and not self._slam.has_begun:
            rospy.loginfo_throttle(10.0, "The UAV hovers over the start; SLAM has not begun yet.")
        awaited = "SLAM, whose node says above why it has not begun" if self._uav_is_ready else "the hover"
        self._monitor.course.on_ready(self._uav_is_ready and self._slam.has_begun, awaited)

    @property
    def _flying_s(self) -> float:
        """Since the mission began; 0 before."""
        began_s = self._monitor.course.outcome.times_s.get(Phase.FLYING)
        return 0.0 if began_s is None else self._monitor.now_s - began_s

    def _end_in_time(self) -> list[TimeIsOver]:
        if self._monitor.course.phase is not Phase.FLYING:
            return []
        over = self._flight.time.over(self._flying_s, self._flies_home)
        if over is TimeIsOver.FLY_HOME:
            self._flies_home = True
            return [over]
        if over is TimeIsOver.END_HERE:
            rospy.loginfo("The mission's time is over.")
            self._cancel.publish(GoalID())
            self._monitor.on_goal_reached(True)
        return []

    def _on_scan(self, message: LaserScan) -> None:
        super()._on_scan(message)
        self._slam.on_scan(stamp_s(message))


def make() -> RunNode:
    """Read and check the request. Return the function that flies it and writes the results."""
    asked = rospy.get_param("~", {})
    flight = read(asked, cepa_keeps_m(all_parameters().get("cepa", {})))
    lockstep, slam_node = asked.get("lockstep", False) is True, str(asked.get("slam_node", "/gridslam"))
    return lambda ending: _fly(flight, lockstep, slam_node, ending)


def _fly(flight: MissionFlight, lockstep: bool, slam_node: str, ending: Ending) -> int:
    """Return the exit code."""
    run = Run(flight.description.experiment, ending)
    monitor = Monitor(flight.limits, UavParts.load(flight.description.model))
    monitor.log.scan_period_s = SCAN_PERIOD_S
    slam, lidar = SlamWatch(slam_node), LidarWatch() if has_volume() else None
    run.lead(monitor, lambda: Experiments34Node(monitor, slam, flight, lockstep))
    if not run.interrupted:
        lidar = lidar if save_volume(run.folder) else None
        slam.close(ending)
    description, wall = run.close(flight.description, monitor)
    flown = run.folder, description, monitor.log, monitor.course.outcome
    numbers = write_numbers(*flown, wall)
    from master_thesis.experiments_3_4.slam_summary import headline  # numba takes half a second

    return run.finish(
        numbers,
        headline,
        lambda content: complete_run(*flown, _with_surveys(flown, content, slam, lidar), ProgressLog()),
        "maps, clearance or pictures",
    )


def _with_surveys(flown: FlownRun, content: dict, slam: SlamWatch, lidar: LidarWatch | None) -> dict:
    """Compute the metrics of the maps and add them."""
    content = _with_survey(flown, content, slam)
    return content if lidar is None else _with_volume(flown, content, lidar.close())


def _with_volume(flown: FlownRun, content: dict, lidar_on_uav: np.ndarray) -> dict:
    """Judge the map of voxels and add its figures. lidar_on_uav: (k, 8), see `LidarWatch.close`."""
    from master_thesis.experiments_3_4.volume.survey import survey_volume  # trimesh takes half a second

    folder, description, log, _ = flown
    rospy.loginfo("The map of voxels is compared with the world.")
    scenario, truth = description.scenario, log.truth.array(*POSE_COLUMNS)
    try:
        figures = survey_volume(folder.path, scenario.world_path, description.lidar, truth, lidar_on_uav)
    except (SlamError, OSError) as error:
        told = f"result.json has no section volume: {error}"
        rospy.logwarn(told)
        folder.lacks(told)
        return content
    content = {**content, "volume": figures}
    folder.write_result(content)
    return content


def _with_survey(flown: FlownRun, content: dict, slam: SlamWatch) -> dict:
    """Compute the map's metrics and add them. Without a map the run has failed."""
    from master_thesis.experiments_3_4.survey import survey  # matplotlib and evo take a second to import

    folder, description, log, outcome = flown
    try:
        metrics = survey(folder, description, log, outcome, slam.run)
    except SlamError as error:
        content = {**content, "success": False, "failure": content["failure"] or str(error)}
    else:
        content = {**content, "slam": {**metrics, **slam.costs()}}
    folder.write_result(content)
    return content
