"""Takes the photographs of an inspection: opens the shutter, judges, and stores each picture that comes."""

from __future__ import annotations

import queue
from functools import partial
from pathlib import Path
from typing import Any, Callable, NamedTuple

import numpy as np
import rospy
from sensor_msgs.msg import Image

from inspection_tools.inspection import End, Inspection
from inspection_tools.inspection.taken import RecentPoses, record_of, shot_of
from inspection_tools.inspection.todo import Task
from inspection_tools.photographs.folder import PhotographError, PhotographFolder, PhotographRecord
from inspection_tools_ros.surveying import messages
from inspection_tools_ros.surveying.camera_link import LAST_PICTURE_S, PICTURE_S, CameraError, CameraLink

CAMERA_TRIES = 3


class Taken(NamedTuple):
    """A photograph whose picture is to come."""

    inspection: Inspection
    task: Task
    record: PhotographRecord
    is_good: bool


class Photographer:
    """One camera and one folder.

    Args:
        say: told what goes wrong. on_shot: called after each shutter, in the thread of `work`.

    Attributes:
        folder: where photographs go; None: no plan has come yet. shots: of the shutter. on_stored: called
        with the path of each photograph that is stored. poses: of the UAV, for the records.
    """

    def __init__(self, say: Callable[[str], None], on_shot: Callable[[], None]) -> None:
        self._say, self._on_shot = say, on_shot
        self.folder: PhotographFolder | None = None
        self.on_stored: Callable[[Path], None] = lambda _: None
        self.shots = self._failures = 0
        self._is_due = self._is_last = False
        self._due: queue.Queue[tuple[Inspection, Task, float]] = queue.Queue()
        self.poses = RecentPoses()
        self._camera = CameraLink(self._store, self._lose)
        self._last = rospy.Publisher("~last_photograph", Image, queue_size=1, latch=True)

    def tilt(self, angle_rad: float) -> None:
        """Tilt the camera; pi / 2 looks straight up."""
        self._camera.tilt(angle_rad)

    def take(self, inspection: Inspection, task: Task, stamp_s: float) -> None:
        """Take a photograph as soon as `work` comes to it, where the UAV is at this time or later."""
        self._is_due, self._is_last = True, False
        self._due.put((inspection, task, stamp_s))

    def hurry(self) -> None:
        """Wait no longer for pictures than a UAV may that hovers at home: no more is to be taken."""
        self._is_last = True

    @property
    def is_shooting(self) -> bool:
        """Whether a shutter is to open."""
        return self._is_due

    @property
    def waits(self) -> bool:
        """Whether a picture is still to come."""
        return self._is_due or self._camera.waits

    def work(self) -> None:
        """Open the shutter when it is due, until ROS ends."""
        while not rospy.is_shutdown():
            try:
                inspection, task, stamp_s = self._due.get(timeout=0.5)
            except queue.Empty:
                self._camera.give_up_late(LAST_PICTURE_S if self._is_last else PICTURE_S)
                continue
            self._shoot(inspection, task, stamp_s)
            self._is_due = False
            self._on_shot()

    def _shoot(self, inspection: Inspection, task: Task, stamp_s: float) -> None:
        try:
            self._camera.shoot(stamp_s, partial(self._taken, inspection, task))
        except CameraError as error:
            self._miss(inspection, task, str(error))

    def _taken(self, inspection: Inspection, task: Task, told: Any) -> Taken:
        """Judge a photograph whose shutter has just opened, before its picture can come or be lost."""
        stamp_s = told.stamp.to_sec()
        body = self.poses.at(stamp_s)
        record = record_of(task, stamp_s, body, messages.camera_in_body(told), told)
        self.shots += 1
        fault = inspection.judge(task, shot_of(record))
        if fault:
            rospy.loginfo("Photograph %d is shot again: %s.", task.number, fault)
        return Taken(inspection, task, record, not fault)

    def _store(self, taken: Taken, picture: np.ndarray) -> None:
        """Store a picture that has come, if it is good."""
        self._failures = 0
        if not taken.is_good or self.folder is None:
            return
        inspection, task = taken.inspection, taken.task
        try:
            path = self.folder.save(picture, taken.record)
        except PhotographError as error:
            rospy.logerr("%s", error)
            inspection.lost(task, str(error))
            inspection.abort(str(error), End.STORAGE)
            return
        name = f"Photograph {task.number}" if task.number > 0 else "A closer photograph"
        rospy.loginfo("%s is stored; %d are open.", name, len(inspection.todo.open))
        self.on_stored(path)
        self._last.publish(messages.small(picture, rospy.Time.from_sec(taken.record.stamp_s)))

    def _lose(self, taken: Taken) -> None:
        self._miss(taken.inspection, taken.task, "The camera's picture did not come, or it was cut.")

    def _miss(self, inspection: Inspection, task: Task, why: str) -> None:
        self._say(why)
        self._failures += 1
        inspection.lost(task, why)
        if self._failures >= CAMERA_TRIES:
            self._failures = 0  # the next flight begins with as many tries
            inspection.abort(f"{why} It was asked {CAMERA_TRIES} times.", End.CAMERA)
