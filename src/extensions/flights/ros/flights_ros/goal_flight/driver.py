"""The node `experiment_1`: sends the goal, watches the flight, lands and writes the results."""

from __future__ import annotations

from enum import Enum
from typing import Iterable, Sequence

import numpy as np
import rospy
from flight_basics_ros.setpoints import SetpointSender
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool, Header

from flights.flight.course import Phase
from flights.flight.judging.contacts import UavParts
from flights.flight.monitor import Monitor
from flights.goal_flight.progress import ProgressWatch
from flights.goal_flight.request import GoalFlight, read
from flights.launch_arguments.cepa_parameters import cepa_body_m, cepa_keeps_m
from flights.results.metrics import flight_interval_s
from flights.results.run_files import FlownRun, complete_run, write_numbers
from flights.results.run_summary import headline
from flights.worlds import scenario
from flights_ros.drivers.flight_node import FlightNode
from flights_ros.drivers.messages import pose_values, stamp_s
from flights_ros.drivers.parameters import all_parameters
from flights_ros.drivers.progress import ProgressLog
from flights_ros.drivers.run import Run
from flights_ros.launch.request import check_avoidance
from node_tools.ending import Ending
from node_tools.node import RunNode

NEAR_GOAL_M = 1.0
"""path_planner leads over places on the way. The one within so far of the goal is the goal."""
KeptM = tuple[float, float]
"""What CEPA keeps, m: r_lb and body_radius."""


class Experiment1Node(FlightNode):
    """Flies to one goal.

    Subscribes, besides every `FlightNode`'s topics: goal_reached (std_msgs/Bool).
    Publishes: pos_setpoint (geometry_msgs/Pose): see `SetpointSender`. If path_planner leads, plan_goal
        (geometry_msgs/PoseStamped, latched) in its place.
    Parameters: see doc/reference.md.
    """

    def __init__(
        self,
        monitor: Monitor,
        goal_xyz_m: tuple[float, float, float],
        lockstep: bool,
        cepa: bool,
        is_planned: bool,
    ) -> None:
        self._goal_xyz_m = goal_xyz_m
        self._setpoint = None if is_planned else SetpointSender()
        self._plan_goals = rospy.Publisher("plan_goal", PoseStamped, queue_size=1, latch=True)
        self._progress = ProgressWatch(goal_xyz_m, is_planned)
        self._distance_m = 0.0
        super().__init__(monitor, lockstep, cepa)
        self.subscribe("goal_reached", Bool, self._on_goal_reached)

    def send_goal(self) -> None:
        """Send the goal to the position controller, or to path_planner."""
        goal = Pose(Point(*self._goal_xyz_m), Quaternion(0.0, 0.0, 0.0, 1.0))
        if self._setpoint is None:
            self._plan_goals.publish(PoseStamped(Header(stamp=rospy.Time.now(), frame_id="map"), goal))
        else:
            self._setpoint.send(goal)
        rospy.loginfo("The UAV hovers over the start and is sent to the goal.")

    def _on_goal_reached(self, message: Bool) -> None:
        is_goal = self._setpoint is not None or self._distance_m <= NEAR_GOAL_M
        self._monitor.on_goal_reached(message.data and is_goal)

    def _unstamped_matter(self) -> bool:
        """Only `ready` decides. `goal_reached` begins the hover, whose time decides seconds later."""
        return not self._monitor.has_begun

    def _on_ground_truth(self, message: Odometry) -> Iterable[Enum]:
        actions = super()._on_ground_truth(message)
        course = self._monitor.course
        if course.phase is Phase.FLYING:
            distance_m, said = self._progress.update(stamp_s(message), pose_values(message.pose.pose)[:3])
            self._distance_m = distance_m
            course.on_distance(distance_m)
            if said:
                decisions = self._monitor.log.decisions.rows
                rospy.logwarn(f"{said} CEPA's last answer: {decisions[-1][-1]}." if decisions else said)
        return actions


def make() -> RunNode:
    """Read and check the request. Return the function that flies it and writes the results."""
    asked = rospy.get_param("~", {})
    avoidance = str(asked.get("avoidance", scenario.CEPA))
    check_avoidance(avoidance)
    cepa = all_parameters().get("cepa", {})
    flight = read(asked, cepa_keeps_m(cepa))
    lockstep = asked.get("lockstep", False) is True
    kept_m = (cepa_keeps_m(cepa), cepa_body_m(cepa)) if avoidance == scenario.CEPA else None
    return lambda ending: _fly(flight, lockstep, kept_m, ending)


def _fly(flight: GoalFlight, lockstep: bool, kept_m: KeptM | None, ending: Ending) -> int:
    """Return the exit code. kept_m: what CEPA keeps; None: another node avoids."""
    run = Run(flight.description.experiment, ending)
    monitor = Monitor(flight.limits, UavParts.load(flight.description.model))
    goal_xyz_m = flight.description.scenario.goal_xyz_m
    run.lead(
        monitor, lambda: Experiment1Node(monitor, goal_xyz_m, lockstep, kept_m is not None, flight.is_planned)
    )
    description, wall = run.close(flight.description, monitor)
    flown = run.folder, description, monitor.log, monitor.course.outcome
    numbers = write_numbers(*flown, wall)
    return run.finish(
        numbers,
        headline,
        lambda content: complete_run(*flown, _explained(flown, kept_m, content), ProgressLog()),
        "clearance or pictures",
    )


def _explained(flown: FlownRun, kept_m: KeptM | None, content: dict) -> dict:
    """Return the results; a flight that stayed before an opening says so. kept_m: as of `_fly`."""
    folder, description, log, outcome = flown
    is_late = not outcome.reached_goal and not outcome.collision and Phase.LANDING in outcome.times_s
    if kept_m is None or not is_late or not content["failure"]:
        return content
    from flights.results.narrow_way import Cushions, why_it_stayed
    from gridslam.errors import SlamError  # this and scipy take half a second, and only few flights need it
    from gridslam.evaluation.volume.surface import read_surface

    goal_m, path_m = description.scenario.goal_xyz_m, log.between(*flight_interval_s(log, outcome))
    try:
        surface = read_surface(description.scenario.world_path)
    except SlamError as error:
        rospy.logwarn(f"Whether an opening was too narrow is not told: {error}")
        return content
    if not len(path_m):
        return content
    rng = np.random.default_rng(description.seed)
    why = why_it_stayed(surface, _nearest_m(path_m, goal_m), np.array(goal_m), Cushions(*kept_m), rng)
    content = {**content, "failure": content["failure"] + why}
    folder.write_result(content)
    return content


def _nearest_m(path: np.ndarray, goal_m: Sequence[float]) -> np.ndarray:
    """Return the place (x, y, z) of a flight that is nearest to the goal. path: rows (n, k) of the truth."""
    places_m = path[:, 1:4]
    nearest: np.ndarray = places_m[np.linalg.norm(places_m - goal_m, axis=1).argmin()]
    return nearest
