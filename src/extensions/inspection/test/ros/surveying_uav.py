"""A UAV with a camera for the node `inspect`, at the times of its own stamps."""

from __future__ import annotations

import math

import numpy as np
import roslib.message
import rospy
from drawn_voxels import block, tiles_of
from exploration_ros.planner_messages import tiles_class
from flight_basics_ros.testing import Newest, odometry_of
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3Stamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, Image
from std_msgs.msg import Float64

from node_tools.testing import Input, wait_until

RESOLUTION_M, SIDE, STEP_S = 0.2, 16, 0.3
START = (2.0, 5.0, 2.0)
SHOOT = roslib.message.get_service_class("simulation_tools/Shoot")


class Uav:
    """It is where it is sent, at once. Its camera takes grey pictures."""

    step_s, pause_s = STEP_S, 0.05
    """Of the stamps; and the longest wall time between two of them."""

    def __init__(self, poses="/ground_truth"):
        self.picture = np.zeros((48, 64, 3), np.uint8)
        self.camera, self.cut, self.unturned = "good", 0, 0
        self.stamp_s, self.charge, self.tilts = 100.0, 0.9, Newest("/camera/tilt", Float64)
        self.place, self._yaws, self._yaw_rad = START, {}, 0.0
        self._pictures = rospy.Publisher("/camera/image_raw", Image, queue_size=10)
        rospy.Service("/camera/shoot", SHOOT, self._shoot)
        rospy.Subscriber("/pos_setpoint", Pose, self._fly)
        rospy.Subscriber("/front", Vector3Stamped, self._turn)
        self._poses, self._maps = Input(poses, Odometry), Input("/updates", tiles_class())
        self._batteries = Input("/battery", BatteryState)

    def _fly(self, setpoint):
        self.place = (setpoint.position.x, setpoint.position.y, setpoint.position.z)

    def _turn(self, front):
        asked_at = self._yaws.get(front.header.stamp.to_nsec())
        if asked_at is not None:
            self._yaw_rad = asked_at + math.atan2(front.vector.y, front.vector.x)

    def _shoot(self, _):
        stamp = rospy.Time.from_sec(self.stamp_s)
        height, width = self.picture.shape[:2]
        data = self.picture.tobytes()
        picture = Image(height=height, width=width, encoding="rgb8", step=3 * width, data=data)
        picture.header.stamp = stamp
        if self.camera == "stopped":
            return SHOOT._response_class(success=False, status_message="It has stopped.")
        if self.cut:
            self.cut -= 1
            picture.data = data[:1000]
        if self.camera != "blind":
            self._pictures.publish(picture)
        pose = Pose(Point(0.1, 0.0, -0.05), Quaternion(-0.5, 0.5, -0.5, 0.5))
        if self.unturned:
            self.unturned -= 1
            pose.orientation = Quaternion()
        return SHOOT._response_class(True, "", stamp, pose, 0.002, 400.0, 200.0, 0.1, 1e-4, 0.0)

    def tell(self):
        """Tell pose, map and battery of the next instant."""
        self.stamp_s += self.step_s
        stamp = rospy.Time.from_sec(self.stamp_s)
        self._yaws[stamp.to_nsec()] = self._yaw_rad
        self._poses.send(self.odometry(stamp))
        battery = BatteryState(percentage=self.charge, voltage=12.0, current=-10.0)
        battery.header.stamp = stamp
        self._batteries.send(battery)
        tiles = tiles_class()()
        tiles.header.frame_id, tiles.header.stamp = "map", stamp
        tiles.resolution, tiles.side = RESOLUTION_M, SIDE
        self._maps.send(tiles)

    def odometry(self, stamp):
        """Return the pose that is told."""
        return odometry_of(stamp, self.place, self._yaw_rad, frame="map")

    def send_map(self):
        """Send a room of 9.6 x 9.6 x 4.8 m with walls of a voxel."""
        kinds = block(24, 48, 48)
        kinds[0] = kinds[-1] = kinds[:, 0] = kinds[:, -1] = kinds[:, :, 0] = kinds[:, :, -1] = 2
        tiles, voxels = tiles_of(kinds, SIDE)
        message = tiles_class()()
        message.header.frame_id, message.header.stamp = "map", rospy.Time.from_sec(self.stamp_s)
        message.resolution, message.side = RESOLUTION_M, SIDE
        message.tiles, message.voxels = tiles.ravel().tolist(), voxels.tobytes()
        self._maps.send(message)

    def fly(self, until, what):
        """Fly until something is true."""

        def flown():
            self.tell()
            rospy.sleep(0.02)
            return until()

        wait_until(flown, what, 200.0, self.pause_s)
