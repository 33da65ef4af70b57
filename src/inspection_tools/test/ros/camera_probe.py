"""A photographer whose camera hangs, or whose pictures never come. Prints what it told the inspection."""

import json
import threading
import time

import roslib.message
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion
from inspection_tools_ros.surveying import camera_link, photographer

from inspection_tools.inspection.taken import StampedPose
from inspection_tools.inspection.todo import Task, Todo
from inspection_tools.survey.views.candidates import View

SHOOT = roslib.message.get_service_class("simulation_tools/Shoot")
camera_link.ANSWER_S, camera_link.HANGING_S, photographer.LAST_PICTURE_S = 0.4, 0.2, 0.3
TASKS = [Task(number, View((1.0, 1.0, 1.0), 0.0, 0.0)) for number in (1, 2, 3, 4)]


class Inspection:
    """Notes what it is told."""

    def __init__(self):
        self.lost_ones, self.aborts, self.todo = [], [], Todo([])

    def judge(self, _task, _shot):
        return ""

    def lost(self, task, why):
        self.lost_ones.append((task.number, why))

    def come_home(self, reason, end):
        self.aborts.append((end.value, reason))


def shoot(_):
    while camera == "hangs":
        time.sleep(0.05)
    stamp = rospy.Time.from_sec(10.0 + time.monotonic())
    pose = Pose(Point(0.1, 0.0, -0.05), Quaternion(-0.5, 0.5, -0.5, 0.5))
    return SHOOT._response_class(True, "", stamp, pose, 0.002, 400.0, 200.0, 0.1, 1e-4, 0.0)


def wait_for(condition):
    end_s = time.monotonic() + 20.0
    while not condition() and time.monotonic() < end_s:
        time.sleep(0.02)


rospy.init_node("camera_probe", disable_signals=True)
rospy.Service("camera/shoot", SHOOT, shoot)
said = []
takes = photographer.Photographer(said.append, lambda: None)
takes.poses.note(StampedPose(10.0, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 1.0)))
threading.Thread(target=takes.work, daemon=True).start()
told = {}
for camera in ("hangs", "blind"):
    inspection = Inspection()
    takes.begin(inspection, photographer.Album(None, lambda _: None))
    for task in TASKS[:3]:
        takes.take(task, 10.0)
        wait_for(lambda: not takes.is_shooting)
    takes.hurry()
    wait_for(lambda: not takes.waits)
    told[camera] = {"lost": inspection.lost_ones, "aborts": inspection.aborts, "waits": takes.waits}
print(json.dumps(told), flush=True)
