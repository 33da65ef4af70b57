"""Takes the photographs of an inspection: opens the shutter, judges, and stores each picture that comes."""

from __future__ import annotations

import queue
from functools import partial
from pathlib import Path
from typing import Any, Callable, NamedTuple

import numpy as np
import rospy
from sensor_msgs.msg import Image

from inspection.flight import End, Inspection
from inspection.flight.photograph_queue import Task
from inspection.flight.photograph_records import RecentPoses, StampedPose, quality_of, record_of
from inspection.flight.slam_path import FollowedRecords, LevelPose, SlamPath
from inspection.photographs.folder import PhotographFolder
from inspection.photographs.metering import metering
from inspection.photographs.record import PhotographError, PhotographRecord
from inspection.survey.asked_for import AskedFor
from inspection_ros import messages
from inspection_ros.camera_link import LAST_PICTURE_S, PICTURE_S, CameraError, CameraLink

CAMERA_TRIES = 3


class Album(NamedTuple):
    """Where the photographs of a survey go. on_stored: called with the path of each that is stored.

    asked_for: tells what each is to show; None: nobody knows.
    """

    folder: PhotographFolder
    on_stored: Callable[[Path], None]
    asked_for: AskedFor | None = None


class Asked(NamedTuple):
    """A photograph to take. Survey and album stay with it: its picture may come when another one is flown."""

    inspection: Inspection
    album: Album
    task: Task


class PendingPhotograph(NamedTuple):
    """A photograph whose picture is to come. bias_ev: its exposure compensation.

    odom_in_map: with which its record was made; None: no SLAM.
    """

    asked: Asked
    record: PhotographRecord
    is_good: bool
    odom_in_map: LevelPose | None
    bias_ev: float = 0.0


class Photographer:
    """One camera.

    Args:
        say: told what goes wrong. on_shot: called after each shutter, in the thread of `work`.

    Attributes:
        poses: of the UAV, for the records. records: they follow SLAM's path.
    """

    def __init__(self, say: Callable[[str], None], on_shot: Callable[[], None]) -> None:
        self._say, self._on_shot = say, on_shot
        self._inspection: Inspection | None = None
        self._album: Album | None = None
        self._failures = 0
        self._is_due = self._is_last = False
        self._due: queue.Queue[tuple[Asked, float]] = queue.Queue()
        self.poses, self.records = RecentPoses(), FollowedRecords()
        self._slam_path: SlamPath | None = None
        self._folders: dict[Path, PhotographFolder] = {}
        self._camera = CameraLink(self._store, self._lose)
        self._last = rospy.Publisher("~last_photograph", Image, queue_size=1, latch=True)

    def tilt(self, angle_rad: float) -> None:
        """Tilt the camera; pi / 2 looks straight up."""
        self._camera.tilt(angle_rad)

    def begin(self, inspection: Inspection, album: Album) -> None:
        """Take photographs of a survey from now on. Pictures of the one before still go into its album."""
        self._inspection, self._album, self._failures = inspection, album, 0
        self._folders[album.folder.folder] = album.folder

    def follow(self, slam_path: SlamPath) -> None:
        """Let the records follow SLAM's path as soon as `work` comes to it."""
        self._slam_path = slam_path

    def take(self, task: Task, stamp_s: float) -> None:
        """Take a photograph as soon as `work` comes to it, where the UAV is at this time or later."""
        assert self._inspection is not None
        assert self._album is not None
        self._is_due, self._is_last = True, False
        self._due.put((Asked(self._inspection, self._album, task), stamp_s))

    def hurry(self) -> None:
        """Wait no longer for pictures than a UAV may that hovers at home: no more is to be taken."""
        self._is_last = True

    def note(self, pose: StampedPose, in_odom: LevelPose | None) -> None:
        """Note a pose of the UAV with all of SLAM's correction, and in odom, for the records."""
        self.poses.note(pose)
        if in_odom is not None:
            self.records.note(pose.stamp_s, in_odom)

    @property
    def is_shooting(self) -> bool:
        """Whether a shutter is to open."""
        return self._is_due

    @property
    def waits(self) -> bool:
        """Whether a picture is still to come, or records are to follow SLAM's path."""
        return self._is_due or self._camera.waits or self._slam_path is not None

    def work(self) -> None:
        """Open the shutter when it is due, until ROS ends."""
        while not rospy.is_shutdown():
            try:
                asked, stamp_s = self._due.get(timeout=0.5)
            except queue.Empty:
                self._camera.give_up_late(LAST_PICTURE_S if self._is_last else PICTURE_S)
                self._correct_records()
                continue
            self._shoot(asked, stamp_s)
            self._is_due = False
            self._on_shot()

    def _correct_records(self) -> None:
        """Write the records that SLAM's newest path has moved."""
        slam_path = self._slam_path
        if slam_path is None:
            return
        try:
            moved = self.records.moved(slam_path)
            for path, record in moved:
                self._folders[path.parent].correct(path, record)
            for folder in {path.parent for path, _ in moved}:
                self._folders[folder].correct_lists()
            if moved:
                rospy.loginfo("SLAM's path has moved %d photographs.", len(moved))
        except PhotographError as error:
            self._say(str(error))
        if self._slam_path is slam_path:
            self._slam_path = None

    def _shoot(self, asked: Asked, stamp_s: float) -> None:
        detail_m, bias_ev = asked.inspection.metering(asked.task)
        try:
            self._camera.shoot(stamp_s, partial(self._taken, asked, bias_ev), detail_m, bias_ev)
        except CameraError as error:
            self._miss(asked, str(error))

    def _taken(self, asked: Asked, bias_ev: float, told: Any) -> PendingPhotograph:
        """Judge a photograph whose shutter has just opened, before its picture can come or be lost.

        Raises:
            CameraError: the camera's answer makes no sense; its picture is not taken.
        """
        inspection, _, task = asked
        inspection.queue.note_shot()
        answer = messages.shutter_answer(told)
        body = self.poses.at(answer.stamp_s)
        record = record_of(task, body, answer)
        fault = inspection.judge_quality(task, quality_of(record))
        if fault:
            rospy.loginfo("Photograph %d is shot again: %s.", task.number, fault)
        return PendingPhotograph(asked, record, not fault, body.odom_in_map, bias_ev)

    def _store(self, taken: PendingPhotograph, picture: np.ndarray) -> None:
        """Store a picture that has come, if it is good."""
        inspection, album, task = taken.asked
        if inspection is self._inspection:
            self._failures = 0
        if not taken.is_good:
            return
        try:
            path = album.folder.save(picture, taken.record)
        except PhotographError as error:
            rospy.logerr("%s", error)
            inspection.lost(task, str(error))
            inspection.come_home(str(error), End.STORAGE)
            return
        name = f"Photograph {task.number}" if task.number > 0 else "A closer photograph"
        rospy.loginfo("%s is stored; still open: %d.", name, self._still_open(taken))
        self._meter(taken, picture)
        if taken.odom_in_map is not None:
            self.records.add(path, taken.record, taken.odom_in_map)
        album.on_stored(path)
        self._last.publish(messages.small(picture, rospy.Time.from_sec(taken.record.stamp_s)))

    def _still_open(self, stored: PendingPhotograph) -> int:
        """Return how many photographs of its survey are not stored yet: to be taken, or still to come."""
        inspection = stored.asked.inspection
        others = (each for each in self._camera.awaited if each is not stored and each.is_good)
        coming = {each.asked.task.number for each in others if each.asked.inspection is inspection}
        return len(coming | {task.number for task in inspection.queue.open})

    def _meter(self, taken: PendingPhotograph, picture: np.ndarray) -> None:
        """Let a photograph be taken again if too much of what it is to show is white or black."""
        inspection, album, task = taken.asked
        if album.asked_for is None:
            return
        detail_m, _ = inspection.metering(task)
        told = metering(picture, *album.asked_for.of(taken.record.pose, detail_m))
        if told.change_ev and inspection.expose_again(task, told.lost, taken.bias_ev + told.change_ev):
            rospy.loginfo(
                "Photograph %d is taken again with %+.1f EV: %.0f %% of what it shows is white or black.",
                task.number, told.change_ev, 100.0 * told.lost,
            )  # fmt: skip

    def _lose(self, taken: PendingPhotograph) -> None:
        self._miss(taken.asked, "The camera's picture did not come, or it was cut.")

    def _miss(self, asked: Asked, why: str) -> None:
        self._say(why)
        inspection = asked.inspection
        inspection.lost(asked.task, why)
        if inspection is not self._inspection:
            return
        self._failures += 1
        if self._failures >= CAMERA_TRIES:
            inspection.come_home(f"{why} It was asked {CAMERA_TRIES} times.", End.CAMERA)
