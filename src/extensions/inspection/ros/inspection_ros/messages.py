"""What a survey tells: feedback, result, markers for RViz; and what it takes from messages."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from flight_basics_ros import pose_messages
from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import BatteryState, Image
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from flight_basics.errors import FlightBasicsError
from flight_basics.geometry import Vector3, heading_rate, multiply, yaw_of
from inspection.flight import Inspection, Task
from inspection.flight.leader import SurveyPose
from inspection.flight.motion import Motion
from inspection.flight.photograph_records import ShutterAnswer, StampedPose
from inspection.flight.slam_path import LevelPose, SlamPath
from inspection.msg import SurveyFeedback, SurveyResult
from inspection_ros.camera_link import CameraError
from node_tools.conversions import xyz
from node_tools.conversions import yaw_of as yaw_of_message

OPEN, DONE = ColorRGBA(0.1, 0.4, 1.0, 0.9), ColorRGBA(0.1, 0.7, 0.2, 0.9)
LEFT, NEXT = ColorRGBA(0.9, 0.1, 0.1, 0.9), ColorRGBA(1.0, 0.6, 0.0, 1.0)
ARROW_M = 0.6
SMALL_PX = 648


def motion_of(odometry: Odometry, time_s: float, place_m: Vector3 | np.ndarray, yaw_rad: float) -> Motion:
    """Return the motion of an odometry whose steady time, place and yaw in the map are these.

    A speed or a turn that is no number counts as infinite: a UAV whose motion nobody knows is not at rest.
    """
    speed = math.hypot(*xyz(odometry.twist.twist.linear))
    _, orientation = pose_messages.pose_of(odometry.pose.pose)
    turn = heading_rate(orientation, xyz(odometry.twist.twist.angular))
    unknown = (math.inf if math.isnan(value) else value for value in (speed, turn))
    return Motion(time_s, np.array(place_m), yaw_rad, *unknown)


def survey_pose(
    odometry: Odometry,
    place_m: np.ndarray,
    yaw_rad: float,
    whole: tuple[Vector3, float],
    odom_in_map: tuple[Vector3, float] | None,
) -> SurveyPose:
    """Return what a survey wants to know of an odometry at a place with a yaw.

    whole: the pose with all of SLAM's correction; the other one, by which the UAV flies, lags behind.
    odom_in_map: that correction; None: no SLAM.
    """
    motion = motion_of(odometry, math.nan, place_m, yaw_rad)
    correction = None if odom_in_map is None else LevelPose(*odom_in_map)
    pose = stamped_pose(odometry, *whole, odom_in_map=correction)
    if correction is None:
        return SurveyPose(motion, pose, None)
    position, orientation = odometry.pose.pose.position, odometry.pose.pose.orientation
    return SurveyPose(motion, pose, LevelPose(xyz(position), yaw_of_message(orientation)))


def stamped_pose(
    odometry: Odometry,
    place_m: Vector3,
    yaw_rad: float,
    deviation_m: float = 0.0,
    odom_in_map: LevelPose | None = None,
) -> StampedPose:
    """Return the pose in the map: the odometry's, turned to this yaw. For the others see `StampedPose`."""
    _, orientation = pose_messages.pose_of(odometry.pose.pose)
    half = 0.5 * (yaw_rad - yaw_of(orientation))
    turned = multiply((0.0, 0.0, math.sin(half), math.cos(half)), orientation)
    covariance = tuple(map(float, odometry.pose.covariance))
    stamp_s = odometry.header.stamp.to_sec()
    return StampedPose(stamp_s, place_m, turned, covariance, deviation_m, odom_in_map)


def slam_path_of(path: Path) -> SlamPath:
    """Return a nav_msgs/Path of SLAM. Raises PoseError if one of its poses is none."""
    known = (pose_messages.pose_of(each.pose) for each in path.poses)
    poses = [(*place_m, yaw_of(orientation)) for place_m, orientation in known]
    stamps_s = np.array([each.header.stamp.to_sec() for each in path.poses])
    return SlamPath(stamps_s, np.array(poses, float).reshape(-1, 4))


def shutter_answer(told: Any) -> ShutterAnswer:
    """Return what the camera answered to Shoot.srv.

    Raises:
        CameraError: it makes no sense: a pose that is none, or a value that is negative or no number.
    """
    try:
        place_m, orientation = pose_messages.pose_of(told.pose)
        values = (told.exposure, told.iso, told.lux, told.blur, told.shift, told.turn)
        return ShutterAnswer(told.stamp.to_sec(), place_m, orientation, *values)
    except FlightBasicsError as error:
        raise CameraError(f"The camera's answer makes no sense: {error}") from None


def small(picture: np.ndarray, stamp: Any) -> Image:
    """Return a picture (height, width, 3), uint8, as a small sensor_msgs/Image."""
    step = max(1, picture.shape[1] // SMALL_PX)
    shown = np.ascontiguousarray(picture[::step, ::step])
    height, width = shown.shape[:2]
    header = Header(stamp=stamp, frame_id="inspection_camera_optical")
    return Image(header, height, width, "rgb8", 0, 3 * width, shown.tobytes())


def feedback_of(inspection: Inspection, battery: BatteryState | None, has_map: bool) -> SurveyFeedback:
    """Return the feedback."""
    phase = "photographing"
    if not has_map:
        phase = "waiting for the map"
    elif inspection.end is not None:
        phase = "coming home"
    elif inspection.is_paused:
        phase = "paused"
    elif inspection.is_in_doubt:
        phase = "waiting for SLAM"
    elif inspection.is_waiting:
        phase = "searching the photographs"
    way, task, queue = inspection.way_home, inspection.task, inspection.queue
    return SurveyFeedback(
        phase=phase,
        taken=sum(number > 0 for number in queue.done),
        of=len(queue.tasks),
        next=0 if task is None else task.number,
        home_way=math.nan if way is None else way.length_m,
        home_time=math.nan if way is None else way.time_s,
        charge=math.nan if battery is None else battery.percentage,
    )


def result_of(inspection: Inspection) -> SurveyResult:
    """Return the result."""
    queue = inspection.queue
    return SurveyResult(
        end="" if inspection.end is None else inspection.end.value,
        reason=inspection.reason,
        is_home=inspection.is_home,
        taken=sum(number > 0 for number in queue.done),
        open=sum(task.number > 0 for task in queue.open),
        closer=sum(number < 0 for number in queue.done),
        left_out=list(queue.left_out),
        left_out_reasons=list(queue.left_out.values()),
        shots=inspection.queue.shots,
    )


def markers_of(inspection: Inspection, here_m: np.ndarray, header: Header) -> MarkerArray:
    """Return the views: done (green), open (blue), left out (red), next (orange); and the way (blue)."""
    queue, task = inspection.queue, inspection.task
    views = _marker(header, "views", Marker.LINE_LIST, OPEN, 0.05)
    for each in queue.tasks:
        colour = DONE if each.number in queue.done else LEFT if each.number in queue.left_out else OPEN
        if task is not None and task.number == each.number:
            colour = NEXT
        views.points += _ends(each)
        views.colors += [colour, colour]
    way = _marker(header, "way", Marker.LINE_STRIP, NEXT, 0.06)
    way.points = [Point(*place_m) for place_m in (here_m, *inspection.rest_m)]
    words = _marker(header, "words", Marker.TEXT_VIEW_FACING, ColorRGBA(0.0, 0.0, 0.0, 1.0), 0.35)
    words.pose.position = Point(here_m[0], here_m[1], here_m[2] + 0.8)
    words.text = f"{sum(number > 0 for number in queue.done)} of {len(queue.tasks)} photographs"
    for lines in (views, way):
        if len(lines.points) < 2:  # RViz calls such a line an error, and shows the display's name in red
            lines.action = Marker.DELETE
    return MarkerArray([views, way, words])


def _ends(task: Task) -> list[Point]:
    view = task.view
    level = math.cos(view.tilt_rad)
    ahead = (level * math.cos(view.yaw_rad), level * math.sin(view.yaw_rad), math.sin(view.tilt_rad))
    return [Point(*view.place_m), Point(*(at + ARROW_M * step for at, step in zip(view.place_m, ahead)))]


def _marker(header: Header, name: str, kind: int, colour: ColorRGBA, size_m: float) -> Marker:
    marker = Marker(header=header, ns=name, type=kind, action=Marker.ADD, color=colour)
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = marker.scale.z = size_m
    return marker
