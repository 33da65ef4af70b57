"""What people tell `inspect` while it flies: pause, resume, abort, look closer."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass, field
from typing import Any, Callable

import numpy as np
import rospy
from exploration_ros.room_above import serve_room_above
from geometry_msgs.msg import PointStamped
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from exploration.planning import PathPlanner
from inspection.flight import Inspection
from inspection.flight.motion import Motion
from inspection.srv import LookCloser, LookCloserRequest, LookCloserResponse
from inspection_ros.goals import SurveyGoals


@dataclass
class Flown:
    """What is flown. Read and change it under the lock; the planner has its own.

    lock: over the action server's own. inspection, motion: None: nothing has come yet. stamp_s: of the
    motion's pose, by its message; the motion has a time that nobody sets. is_active: a goal is being flown.
    """

    lock: threading.Condition
    planner_lock: threading.Lock = field(default_factory=threading.Lock)
    inspection: Inspection | None = None
    motion: Motion | None = None
    stamp_s: float = -math.inf
    is_active: bool = False


class SurveyCommands:
    """Serves ~pause, ~resume, ~abort (std_srvs/Trigger), ~look_closer, ~room_above; takes /clicked_point.

    Args:
        flown: see there. planner: knows the map. goals: knows the plan. goal_frame: of points. send:
            publishes what has changed. say: told what goes wrong. resolution_mm: of a closer look, per pixel.
    """

    def __init__(
        self,
        flown: Flown,
        planner: PathPlanner,
        goals: SurveyGoals,
        goal_frame: str,
        send: Callable[[], None],
        say: Callable[[str], None],
        resolution_mm: float,
    ) -> None:
        self._flown, self._goals, self._goal_frame = flown, goals, goal_frame
        self._send, self._say, self._resolution_mm = send, say, resolution_mm
        rospy.Service("~pause", Trigger, self._pause)
        rospy.Service("~resume", Trigger, self._resume)
        rospy.Service("~abort", Trigger, self._abort)
        rospy.Service("~look_closer", LookCloser, self._look_closer)
        serve_room_above(planner, flown.planner_lock, self._here)
        self._clicks = rospy.Subscriber("/clicked_point", PointStamped, self._on_click, queue_size=1)

    def _pause(self, _: TriggerRequest) -> TriggerResponse:
        return self._act(lambda inspection, here_m: inspection.pause(here_m), "The UAV hovers.")

    def _resume(self, _: TriggerRequest) -> TriggerResponse:
        return self._act(lambda inspection, _: inspection.resume(), "The survey goes on.")

    def _abort(self, _: TriggerRequest) -> TriggerResponse:
        """Let the UAV come home, or stay on the ground: it waits for no more photographs to take."""
        answer, was_searching = self.abort(), self._goals.abort()
        if answer.success or not was_searching:
            return answer
        words = "The photographs are not searched any more, and the UAV stays on the ground."
        rospy.loginfo(words)
        return TriggerResponse(True, words)

    def abort(self) -> TriggerResponse:
        """Let the UAV come home."""
        return self._act(lambda inspection, _: inspection.abort("It was aborted."), "The UAV comes home.")

    def _act(self, act: Any, words: str) -> TriggerResponse:
        flown = self._flown
        with flown.lock:
            if not flown.is_active or flown.inspection is None or flown.motion is None:
                return TriggerResponse(False, "No survey is being flown.")
            act(flown.inspection, flown.motion.place_m)
            self._send()
        rospy.loginfo(words)
        return TriggerResponse(True, words)

    def _here(self) -> np.ndarray | None:
        return None if self._flown.motion is None else self._flown.motion.place_m

    def _on_click(self, clicked: PointStamped) -> None:
        frame = clicked.header.frame_id.lstrip("/")
        if frame != self._goal_frame:
            self._say(f'The point is in frame "{frame}", not in "{self._goal_frame}".')
            return
        self._look_closer(LookCloserRequest(clicked.point))

    def _look_closer(self, request: LookCloserRequest) -> LookCloserResponse:
        point_m = np.array((request.point.x, request.point.y, request.point.z))
        flown = self._flown
        with flown.lock:
            inspection, motion, plan = flown.inspection, flown.motion, self._goals.plan
            if not flown.is_active or inspection is None or inspection.end is not None:
                return LookCloserResponse(False, "No survey is being flown.")
            assert motion is not None
            assert plan is not None
        if not np.isfinite(point_m).all():
            return LookCloserResponse(False, "The point is not three finite numbers.")
        distance_m = plan.camera.distance_m(self._resolution_mm)
        with flown.planner_lock:
            task = inspection.look_closer(point_m, motion.place_m, distance_m)
        words = "The UAV looks closer." if task else "No place near that point can be flown to."
        rospy.loginfo(words)
        return LookCloserResponse(task is not None, words)
