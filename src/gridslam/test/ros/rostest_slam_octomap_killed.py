"""A map outlives its node: what roslaunch starts again goes on with the copy that was kept."""

import os
import signal
import unittest
from xmlrpc.client import ServerProxy

import numpy as np
import rospy
from nav_msgs.msg import Path as PathMessage
from octomap_msgs.msg import Octomap
from rostest_slam_octomap import WALL, cloud, occupied, path_of
from sensor_msgs.msg import PointCloud2
from slam_probe import transform
from tf2_msgs.msg import TFMessage

from gridslam.volume.saved.saved_map import read_volume
from node_tools.testing import Input, Output, address_of, wait_until

NODE = "/killed/slam_octomap"

POST = [(1.1, 1.1, z) for z in np.arange(0.1, 1.0, 0.2)]
"""Centres of the voxels of a post, away from the ways to the wall."""


class KilledTest(unittest.TestCase):
    def setUp(self):
        self.full = Output("killed/octomap_full", Octomap)
        self.clouds, self.tf = Input("killed/cloud_in", PointCloud2), Input("killed/tf", TFMessage)
        self.static = Input("killed/tf_static", TFMessage, latch=True)
        self.static.send(transform("base_link", "lidar", rospy.Time(0)))
        self.paths = Input("killed/path", PathMessage)
        self.stamp = rospy.Time(1000)

    def send(self, points, x=0.0):
        self.stamp += rospy.Duration(2.0)
        self.tf.send(transform("map", "odom", self.stamp))
        self.tf.send(transform("odom", "base_link", self.stamp, (x, 0.0, 0.0)))
        self.clouds.send(cloud(points, self.stamp))

    def kept(self):
        """How many clouds the copy holds."""
        told = rospy.get_param(NODE + "/kept", None)
        return len(read_volume(told["file"]).corrected.nodes) if told else 0

    def test_a_node_that_is_killed_goes_on_with_its_map_and_loops_still_move_it(self):
        wall, post = ({tuple(np.round(at, 3).tolist()) for at in centres} for centres in (WALL, POST))
        for number in range(3):
            self.send(np.array(WALL) - (number, 0.0, 0.0), x=float(number))
            wait_until(lambda: self.kept() == number + 1, "a copy with the cloud")  # noqa: B023
        self.full.last(lambda m: occupied(m) == wall, "the wall")
        old = address_of(NODE)
        os.kill(ServerProxy(old).getPid("/killed_probe")[2], signal.SIGKILL)
        wait_until(lambda: address_of(NODE) not in (None, old), "the node that was started again", 200.0)
        self.full.last(lambda m: occupied(m) == wall, "the wall, without another cloud")
        path = path_of([(self.stamp - rospy.Duration(2.0 * (2 - k)), float(k), 0.6) for k in range(3)])
        moved = {tuple(np.round((x, y + 0.6, z), 3).tolist()) for x, y, z in wall}

        def has_moved():
            self.paths.send(path)  # again and again: the new node may not have subscribed yet
            return occupied(self.full.messages[-1]) == moved

        wait_until(has_moved, "the wall where the path says")

        def has_both():
            self.send(np.array(POST) - (2.0, 0.0, 0.0), x=2.0)
            return occupied(self.full.messages[-1]) == moved | post

        wait_until(has_both, "the wall and the post")
