#!/usr/bin/env python3
"""Load RViz files as RViz does, and exit with 1 if a display of theirs is unknown or shows an error.

usage: rviz_displays.py FILE.rviz ...    (needs a ROS master and a display; prints the problems of each file)

The frames of a flight are published, all on one spot, so that what RViz complains of is the file's fault.
"""

from __future__ import annotations

import sys
import time

import rospy
from geometry_msgs.msg import TransformStamped
from python_qt_binding.QtWidgets import QApplication
from rviz import bindings as rviz
from tf2_ros import StaticTransformBroadcaster

from simulation_tools.sdf.urdf import urdf_of
from simulation_tools.transforms.joint_frames import JointFrames
from simulation_tools.vehicle.uav import load_uav

FRAMES = [("map", "odom"), ("odom", "base_frame"), ("base_frame", "world")]
LEAST_S = 1.0  # in which a display finds what it complains of
PATIENCE_S = 60.0  # for the frames and the model to arrive


def publish_frames() -> StaticTransformBroadcaster:
    """Publish every frame of a flight, as identities, and the UAV that they belong to."""
    uav = load_uav("iris", "ust", sensors=("range_finder", "camera", "depth_camera")).model
    rospy.set_param("robot_description", urdf_of(uav))
    broadcaster = StaticTransformBroadcaster()
    transforms = []
    own = [(edge.parent, edge.child) for edge in JointFrames(uav, "base_frame").static_edges()]
    for parent, child in FRAMES + own:
        transform = TransformStamped(child_frame_id=child)
        transform.header.frame_id = parent
        transform.transform.rotation.w = 1.0
        transforms.append(transform)
    broadcaster.sendTransform(transforms)
    return broadcaster


def problems_of(display, path: str) -> list[str]:
    """Return what a display and those inside it complain of, one sentence each."""
    here = f"{path}/{display.getName()}"
    children = [display.childAt(index) for index in range(display.numChildren())]
    status = [child for child in children if "Status:" in child.getName()]
    found = [
        f"{here}: {child.childAt(index).getName()}: {child.childAt(index).getValue()}"
        for child in status
        if "Error" in child.getName()
        for index in range(child.numChildren())
    ]
    if not children:
        found.append(f"{here}: RViz does not know such a display")
    if isinstance(display, rviz.DisplayGroup):
        for index in range(display.numDisplays()):
            found += problems_of(display.getGroupAt(index) or display.getDisplayAt(index), here)
    return found


def problems_in(path: str, frame: rviz.VisualizationFrame, application: QApplication) -> list[str]:
    """Load one file, as File > Open does; return what its displays complain of to the end."""
    config, reader = rviz.Config(), rviz.YamlConfigReader()
    reader.readFile(config, path)
    if reader.error():
        return [reader.errorMessage()]
    frame.load(config)
    began = time.monotonic()
    while True:
        application.processEvents()
        time.sleep(0.02)
        waited_s = time.monotonic() - began
        found = problems_of(frame.getManager().getRootDisplayGroup(), "")
        if waited_s > PATIENCE_S or (waited_s > LEAST_S and not found):
            return found


def main(paths: list[str]) -> int:
    """Return 0 if every display of the files works."""
    rospy.init_node("rviz_displays", disable_signals=True)
    broadcaster = publish_frames()  # held until the end
    application = QApplication(sys.argv[:1])
    frame = rviz.VisualizationFrame()
    frame.setSplashPath("")
    frame.initialize()
    frame.getManager().startUpdate()
    problems = {path: problems_in(path, frame, application) for path in paths}
    for path, found in problems.items():
        print(f"\n{path}: {len(found)} problems", *found, sep="\n  ")
    del broadcaster
    return 1 if any(problems.values()) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
