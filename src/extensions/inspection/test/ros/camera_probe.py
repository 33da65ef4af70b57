"""A photographer whose camera hangs, or whose pictures come late or never. Prints what inspections heard."""

import json
import threading
import time
from pathlib import Path

import numpy as np
import roslib.message
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion
from inspection_ros import camera_link, photographer
from sensor_msgs.msg import Image

from inspection.flight.photograph_queue import PhotographQueue, Task
from inspection.flight.photograph_records import StampedPose
from inspection.survey.views.candidates import View

SHOOT = roslib.message.get_service_class("simulation_tools/Shoot")
camera_link.ANSWER_S, camera_link.HANGING_S, photographer.LAST_PICTURE_S = 0.4, 0.2, 0.3
TASKS = [Task(number, View((1.0, 1.0, 1.0), 0.0, 0.0)) for number in (1, 2, 3, 4)]


class Inspection:
    """Notes what it is told."""

    def __init__(self, views=()):
        self.lost_ones, self.aborts, self.exposures = [], [], []
        self.queue = PhotographQueue(views)

    def judge_quality(self, task, _quality):
        self.queue.note_done(task)
        return ""

    def metering(self, _task):
        return 0.001, -0.5

    def expose_again(self, task, lost, bias_ev):
        self.exposures.append((task.number, lost, bias_ev))
        return True

    def lost(self, task, why):
        self.lost_ones.append((task.number, why))

    def come_home(self, reason, end):
        self.aborts.append((end.value, reason))


class Folder:
    """Notes what is stored."""

    def __init__(self, name, names):
        self.folder, self._names = Path(name), names

    def save(self, _picture, record):
        self._names.append(record.view)
        return Path(f"{record.view}.jpg")


class Everything:
    """All of a picture of 16 x 16 px is asked for."""

    def of(self, _taken, _detail_m):
        return np.array([(4.0, 4.0), (12.0, 12.0)]), np.ones(2)


def shoot(request):
    asked.append((request.detail, request.bias))
    while camera == "hangs":
        time.sleep(0.05)
    stamp = rospy.Time.from_sec(10.0 + time.monotonic())
    stamps.append(stamp)
    pose = Pose(Point(0.1, 0.0, -0.05), Quaternion(-0.5, 0.5, -0.5, 0.5))
    return SHOOT._response_class(True, "", stamp, pose, 0.002, 400.0, 200.0, 0.1, 1e-4, 0.0)


def wait_for(condition):
    end_s = time.monotonic() + 60.0
    while not condition() and time.monotonic() < end_s:
        time.sleep(0.02)


rospy.init_node("camera_probe", disable_signals=True)
rospy.Service("camera/shoot", SHOOT, shoot)
said, stamps, asked = [], [], []
takes = photographer.Photographer(said.append, lambda: None)
takes.poses.note(StampedPose(10.0, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 1.0)))
threading.Thread(target=takes.work, daemon=True).start()
told = {}
for camera in ("hangs", "blind"):
    inspection = Inspection()
    takes.begin(inspection, photographer.Album(Folder(camera, []), lambda _: None))
    for task in TASKS[:3]:
        takes.take(task, 10.0)
        wait_for(lambda: not takes.is_shooting)
    takes.hurry()
    wait_for(lambda: not takes.waits)
    told[camera] = {"lost": inspection.lost_ones, "aborts": inspection.aborts, "waits": takes.waits}
pictures = rospy.Publisher("camera/image_raw", Image, queue_size=1)
wait_for(lambda: pictures.get_num_connections() > 0)
stored, surveys = {"first": [], "second": []}, {"first": Inspection(), "second": Inspection()}
for name, survey in surveys.items():
    album = photographer.Album(Folder(name, stored[name]), lambda _: None)
    takes.begin(survey, album)
    if name == "first":
        takes.take(TASKS[0], 10.0)
        wait_for(lambda: not takes.is_shooting)
picture = Image(height=1, width=1, encoding="rgb8", step=3, data=bytes(3))
picture.header.stamp = stamps[-1]
pictures.publish(picture)
wait_for(lambda: not takes.waits)
told["late"] = {**stored, "shots": surveys["second"].queue.shots, "waits": takes.waits}
white = Inspection()
takes.begin(white, photographer.Album(Folder("white", []), lambda _: None, Everything()))
takes.take(TASKS[1], 10.0)
wait_for(lambda: not takes.is_shooting)
picture = Image(height=16, width=16, encoding="rgb8", step=48, data=bytes([255]) * 768)
picture.header.stamp = stamps[-1]
pictures.publish(picture)
wait_for(lambda: not takes.waits)
told["white"] = {"exposures": white.exposures, "asked": asked[-1], "waits": takes.waits}
four, infos = Inspection([task.view for task in TASKS]), []
photographer.rospy.loginfo = lambda words, *values: infos.append(words % values)
takes.begin(four, photographer.Album(Folder("four", []), lambda _: None))
for task in TASKS[:2]:  # the second shutter opens before the first picture comes
    takes.take(task, 10.0)
    wait_for(lambda: not takes.is_shooting)
for number, stamp in enumerate(stamps[-2:], start=1):
    picture.header.stamp = stamp
    pictures.publish(picture)
    wait_for(lambda number=number: len(infos) == number)
wait_for(lambda: not takes.waits)
told["four"] = {"said": infos, "waits": takes.waits}
print(json.dumps(told), flush=True)
