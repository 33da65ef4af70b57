"""What slam_octomap promises: the topics and services of octomap_server, boxes that change, and loops."""

import math
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from xmlrpc.client import ServerProxy

import numpy as np
import rospy
from geometry_msgs.msg import Point, PoseStamped, Quaternion, Vector3
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Path as PathMessage
from octomap_msgs.msg import Octomap
from octomap_msgs.srv import BoundingBoxQuery, GetOctomap
from sensor_msgs.msg import LaserScan, PointCloud2, PointField, Range
from slam_probe import transform
from std_msgs.msg import Header
from std_srvs.srv import Empty, Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from gridslam.msg import VoxelTiles
from gridslam.srv import GetDistances, GetFrontiers
from gridslam.volume import VolumeParameters, map_from, read_octree
from node_tools.testing import Input, Output, Warned, long, wait_until

NODE = "/volume/slam_octomap"
SIDE = 0.2
WALL = [(3.1, y, z) for y in np.arange(-1.9, 2.0, 0.2) for z in np.arange(0.1, 1.0, 0.2)]
"""Centres of a wall's voxels, seen from the origin."""


def cloud(points, stamp, frame="lidar", names="xyz"):
    points = np.asarray(points, "<f4").reshape(-1, 3)
    fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate(names)]
    message = PointCloud2(
        fields=fields, height=1, width=len(points), point_step=12, row_step=12 * len(points)
    )
    message.data, message.header.stamp, message.header.frame_id = points.tobytes(), stamp, frame
    return message


def occupied(message):
    """Occupied voxels' centres of an octree."""
    data = bytes(byte & 255 for byte in message.data)
    voxels = map_from(data, message.binary, VolumeParameters(resolution_m=message.resolution))
    box = voxels.box()
    z, y, x = np.nonzero(voxels.values(box) >= 0.0)
    return {tuple(row) for row in np.round((np.stack((x, y, z), axis=1) + box.low + 0.5) * SIDE, 3).tolist()}


def path_of(places):
    """SLAM's path through places: stamp, x, y and, if it is not 0, yaw."""
    path = PathMessage()
    for stamp, x, y, *yaw_rad in places:
        pose = PoseStamped()
        pose.header.stamp = stamp
        pose.pose.position.x, pose.pose.position.y = x, y
        half_rad = 0.5 * sum(yaw_rad)
        pose.pose.orientation.z, pose.pose.orientation.w = math.sin(half_rad), math.cos(half_rad)
        path.poses.append(pose)
    return path


def cpu_s(node):
    """CPU time that the process of a node has used."""
    address = rospy.get_master().lookupNode(node)[2]
    _, _, pid = ServerProxy(address).getPid("/octomap_probe")
    words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, words[11:13])) / os.sysconf("SC_CLK_TCK")


class OctomapTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.binary = Output("volume/octomap_binary", Octomap)
        cls.full = Output("volume/octomap_full", Octomap)
        cls.markers = Output("volume/occupied_cells_vis_array", MarkerArray)
        cls.free_markers = Output("volume/free_cells_vis_array", MarkerArray)
        cls.centres = Output("volume/octomap_point_cloud_centers", PointCloud2)
        cls.projected = Output("volume/projected_map", OccupancyGrid)
        cls.unknown = Output(NODE + "/unknown", PointCloud2)
        cls.updates = Output(NODE + "/updates", VoxelTiles)
        cls.processed = Output(NODE + "/processed", Header)
        cls.warned = Warned(NODE)
        cls.clouds = Input("volume/cloud_in", PointCloud2)
        cls.scans = Input("volume/scan_in", LaserScan)
        cls.ranges_up = Input("volume/range_up_in", Range)
        cls.paths = Input("volume/path", PathMessage)
        cls.tf = Input("volume/tf", TFMessage)
        cls.static = Input("volume/tf_static", TFMessage, latch=True)
        cls.static.send(transform("base_link", "lidar", rospy.Time(0)))
        cls.stamp = rospy.Time(1000)
        cls.services = {
            name: rospy.ServiceProxy(name, kind)
            for name, kind in (
                ("/volume/octomap_binary", GetOctomap),
                ("/volume/octomap_full", GetOctomap),
                (NODE + "/clear_bbx", BoundingBoxQuery),
                (NODE + "/reset", Empty),
                (NODE + "/distances", GetDistances),
                (NODE + "/frontiers", GetFrontiers),
                (NODE + "/save_state", Trigger),
                (NODE + "/load_state", Trigger),
            )
        }
        for service in cls.services.values():
            service.wait_for_service(200.0)

    def setUp(self):
        self.call(NODE + "/reset")
        self.warned.sentences.clear()

    def call(self, name, *given):
        return self.services[name](*given)

    def send(self, points=WALL, wait_s=2.0, at=(0.0, 0.0, 0.0), **how):
        """Send a cloud and its transforms; return its stamp."""
        cls = type(self)
        cls.stamp += rospy.Duration(wait_s)
        self.tf.send(transform("map", "odom", cls.stamp))
        self.tf.send(transform("odom", "base_link", cls.stamp, at))
        self.clouds.send(cloud(points, cls.stamp, **how))
        return cls.stamp

    def walls(self):
        """Send the wall, and wait until the map has it."""
        stamp = self.send()
        wait_until(
            lambda: self.call("/volume/octomap_binary").map.header.stamp >= stamp, "a map with the wall"
        )

    def test_a_change_that_is_not_due_yet_takes_no_processor(self):
        self.walls()
        stamp = self.send(wait_s=0.6)  # the map has changed, and was published less than a second before
        self.processed.last(lambda header: header.stamp == stamp, "the cloud, processed")
        before_s = cpu_s(NODE)
        rospy.rostime.wallsleep(1.0)
        self.assertLess(cpu_s(NODE) - before_s, 0.2)

    def test_a_scan_of_a_lidar_that_looks_down_maps_the_floor(self):
        """Its first beam leaves (0.1, 0.1, 0.1), 45 degrees down, and ends 1 m ahead and 1 m below."""
        cls, half = type(self), math.radians(22.5)
        down = transform("base_link", "nodding", rospy.Time(0))
        down.transforms[0].transform.translation = Vector3(0.1, 0.1, 0.1)
        down.transforms[0].transform.rotation = Quaternion(0.0, math.sin(half), 0.0, math.cos(half))
        self.static.send(down)
        cls.stamp += rospy.Duration(2.0)
        self.tf.send(transform("map", "odom", cls.stamp))
        self.tf.send(transform("odom", "base_link", cls.stamp))
        scan = LaserScan(angle_increment=0.1, range_min=0.1, range_max=10.0, scan_time=0.025)
        scan.header.stamp, scan.header.frame_id = cls.stamp, "nodding"
        scan.ranges = [math.sqrt(2.0), math.nan, math.inf, -math.inf]
        self.scans.send(scan)
        floor = {(1.1, 0.1, -0.9)}
        wait_until(lambda: occupied(self.call("/volume/octomap_binary").map) == floor, "a map with the floor")
        cls.stamp += rospy.Duration(2.0)
        scan.header.stamp, scan.time_increment = cls.stamp, -1.0
        self.scans.send(scan)
        self.warned.wait_for("time_increment")

    def test_a_range_finder_shows_what_no_beam_of_the_lidar_meets(self):
        """It looks up from 0.1 m above the base, and meets a ceiling 2 m above itself."""
        up = transform("base_link", "range_up", rospy.Time(0))
        up.transforms[0].transform.translation = Vector3(0.1, 0.1, 0.1)
        up.transforms[0].transform.rotation = Quaternion(0.0, -math.sqrt(0.5), 0.0, math.sqrt(0.5))
        self.static.send(up)
        told = Range(range=2.0, min_range=0.1, max_range=10.0)
        told.header.frame_id, told.header.stamp = "range_up", type(self).stamp + rospy.Duration(2.0)
        self.ranges_up.deliver(told)  # ranges and clouds come by different ways
        self.send()
        seen = {tuple(np.round(centre, 3).tolist()) for centre in (*WALL, (0.1, 0.1, 2.1))}
        wait_until(lambda: occupied(self.call("/volume/octomap_binary").map) == seen, "wall and ceiling")

    def test_topics_hold_what_the_cloud_saw(self):
        self.walls()
        wall = {tuple(np.round(centre, 3).tolist()) for centre in WALL}
        message = self.binary.last(lambda m: occupied(m) == wall, "octomap_binary with the wall")
        self.assertEqual((message.id, message.binary, message.header.frame_id), ("OcTree", True, "map"))
        self.full.last(lambda m: not m.binary and occupied(m) == wall, "octomap_full with the wall")
        self.assertEqual(occupied(self.call("/volume/octomap_full").map), wall)
        marker = self.markers.last(lambda m: len(m.markers[0].points) == len(wall), "cubes").markers[0]
        points = {tuple(np.round((p.x, p.y, p.z), 3).tolist()) for p in marker.points}
        self.assertEqual(points, wall)
        self.assertEqual(len(marker.colors), len(wall))
        self.centres.last(lambda m: m.width == len(wall), "centres")
        grid = self.projected.last(
            lambda m: m.data.count(100) == len({y for _, y, _ in WALL}), "a map from above"
        )
        self.assertIn(0, grid.data)
        self.assertIn(-1, grid.data)
        self.assertTrue(self.free_markers.messages)

    def test_boxes_that_change_add_up_to_the_map(self):
        self.walls()
        kinds = {}

        def is_whole():
            for message in list(self.updates.messages):
                tiles = np.array(message.tiles).reshape(-1, 3)
                for tile, cube in zip(
                    tiles.tolist(), np.frombuffer(message.voxels, np.uint8).reshape(-1, 4096)
                ):
                    kinds[tuple(tile)] = cube
            return sum(np.count_nonzero(cube == 2) for cube in kinds.values()) == len(WALL)

        wait_until(is_whole, "all of the wall's voxels in ~updates")

    def test_planners_hear_of_each_change_while_the_whole_map_keeps_its_period(self):
        """A cloud each 0.6 s, an ~updates for each, and octomap_binary once a second at most."""
        self.walls()
        stamps = []
        for number in range(1, 5):
            seen = np.add(WALL, (0.0, 2.0 * number, 0.0))
            stamps.append(self.send(seen, wait_s=0.6))
            self.updates.last(lambda m: m.header.stamp == stamps[-1], "an update of this cloud")
        self.binary.last(lambda m: m.header.stamp == stamps[-1], "the map of the last cloud")
        published = {m.header.stamp for m in self.binary.messages}.intersection(stamps)
        self.assertEqual(published, {stamps[1], stamps[3]})

    def test_every_cloud_is_acknowledged_and_repeated_ones_change_nothing(self):
        """A simulator in lockstep waits for it, and repeats its first cloud until all nodes have started."""
        self.walls()
        repeats = 4  # older ones, so many, would begin the map anew

        def acknowledged():
            return sum(header.stamp == self.stamp for header in self.processed.messages)

        wait_until(lambda: acknowledged() == 1, "the acknowledgement of a cloud")
        for _ in range(repeats):
            self.send([(5.0, 5.0, 0.0)], wait_s=0.0)
        wait_until(lambda: acknowledged() == 1 + repeats, "the acknowledgements of repeated clouds")
        self.assertEqual(len(occupied(self.call("/volume/octomap_binary").map)), len(WALL))
        self.assertEqual(self.warned.count("map"), 0)
        self.send([(5.0, 5.0, 0.0)], wait_s=0.2)  # sooner than cloud_period
        wait_until(lambda: acknowledged() == 1, "the acknowledgement of a cloud that came too soon")
        self.assertEqual(len(occupied(self.call("/volume/octomap_binary").map)), len(WALL))
        self.send(names="abc")
        wait_until(lambda: acknowledged() == 1, "the acknowledgement of a cloud that is not used")

    def test_a_corrected_path_moves_the_map(self):
        for x in (0.0, 1.0, 2.0):
            self.send(np.array(WALL) - (x, 0.0, 0.0), at=(x, 0.0, 0.0))
        wait_until(
            lambda: self.call("/volume/octomap_binary").map.header.stamp >= self.stamp,
            "the clouds in the map",
        )
        # SLAM finds that all was 0.6 m to the left
        self.paths.send(
            path_of([(self.stamp - rospy.Duration(2.0 * (2 - k)), float(k), 0.6) for k in range(3)])
        )
        moved = {tuple(np.round((x, y + 0.6, z), 3).tolist()) for x, y, z in WALL}
        wait_until(
            lambda: occupied(self.call("/volume/octomap_binary").map) == moved, "the wall where the path says"
        )

    def test_a_pose_of_the_path_between_two_clouds_of_the_map_is_compared_with_odometry_then(self):
        """The map takes a cloud each 0.5 s. In between the UAV has turned, and its path tells the same."""
        for wait_s, yaw_rad in ((2.0, 0.0), (0.15, 0.6), (0.45, 0.0)):
            cosine, sine = math.cos(yaw_rad), math.sin(yaw_rad)
            seen = [(x * cosine + y * sine, y * cosine - x * sine, z) for x, y, z in WALL]
            self.send(seen, wait_s, at=(0.0, 0.0, yaw_rad))
        wait_until(
            lambda: self.call("/volume/octomap_binary").map.header.stamp >= self.stamp,
            "the clouds in the map",
        )
        # All is 0.6 m to the left: were odometry's turn not known, the wall would turn, too
        self.paths.send(path_of([(self.stamp - rospy.Duration(0.45), 0.0, 0.6, 0.6), (self.stamp, 0.0, 0.6)]))
        moved = {tuple(np.round((x, y + 0.6, z), 3).tolist()) for x, y, z in WALL}
        wait_until(
            lambda: occupied(self.call("/volume/octomap_binary").map) == moved, "the wall where the path says"
        )

    def test_planners_get_distances_and_frontiers(self):
        self.walls()
        answer = self.call(NODE + "/distances", Point(1.0, 0.0, 0.4), Point(3.1, 0.1, 0.5))
        distances = np.array(answer.distances).reshape(answer.size[::-1])
        self.assertAlmostEqual(distances[0, 0, -1], 0.0)
        np.testing.assert_allclose(distances[0, 0], (3.1 - (np.arange(11) + 5.5) * SIDE).clip(0.0), atol=1e-5)
        cloud_message = self.call(
            NODE + "/frontiers", Point(-9.0, -9.0, -9.0), Point(9.0, 9.0, 9.0)
        ).frontiers
        self.assertGreater(cloud_message.width, 0)
        self.unknown.last(lambda m: m.width > 0, "the unknown voxels beside free ones")

    def test_a_cleared_box_is_free(self):
        self.walls()
        self.call(NODE + "/clear_bbx", Point(2.0, -5.0, -5.0), Point(4.0, 0.0, 5.0))
        self.assertEqual({y > 0.0 for _, y, _ in occupied(self.call("/volume/octomap_binary").map)}, {True})

    def test_bad_input_is_told_and_the_map_stays(self):
        self.walls()
        before = occupied(self.call("/volume/octomap_binary").map)
        cases = {
            "no fields x, y and z": {"names": "abc"},
            "no point with finite": {"points": np.full((4, 3), np.nan)},
            "A cloud has no point": {"points": np.zeros((0, 3))},
            "too large": {"points": np.zeros((4_000_001, 3))},
            "older than the map": {"wait_s": -8.0},
        }
        for sentence, how in cases.items():
            with self.subTest(sentence):
                self.send(**how)
                self.warned.wait_for(sentence)
        type(self).stamp += rospy.Duration(8.0)
        unknown = 'TF did not lead from "nobody"'
        wait_until(lambda: self.send(frame="nobody") and self.warned.count(unknown), "a warning about TF")
        with self.assertRaises(rospy.ServiceException):
            self.call(NODE + "/clear_bbx", Point(1.0, 0.0, 0.0), Point(-1.0, 0.0, 0.0))
        with self.assertRaises(rospy.ServiceException):
            self.call(NODE + "/distances", Point(-1e5, -1e5, -1e5), Point(1e5, 1e5, 1e5))
        self.assertEqual(occupied(self.call("/volume/octomap_binary").map), before)

    def test_a_cloud_that_lockstep_repeats_is_not_counted_as_left_out(self):
        cls, told = type(self), "clouds are left out so far"
        before = self.warned.count(told)
        cls.stamp += rospy.Duration(2.0)
        for _ in range(9):  # the node keeps five, and acknowledges each that it leaves out
            self.clouds.deliver(cloud(WALL, cls.stamp, frame="nobody"))
        wait_until(
            lambda: sum(header.stamp == cls.stamp for header in self.processed.messages) >= 4,
            "four clouds, acknowledged",
        )
        self.assertEqual(self.warned.count(told), before)

    def test_a_saved_state_brings_the_map_back(self):
        self.walls()
        before = occupied(self.call("/volume/octomap_binary").map)
        with tempfile.TemporaryDirectory() as folder:
            rospy.set_param(NODE + "/state_file", f"{folder}/map.volume")
            self.assertFalse(self.call(NODE + "/load_state").success)
            answer = self.call(NODE + "/save_state")
            self.assertTrue(answer.success, answer.message)
            self.call(NODE + "/reset")
            self.assertEqual(occupied(self.call("/volume/octomap_binary").map), set())
            self.assertTrue(self.call(NODE + "/load_state").success)
            self.assertEqual(occupied(self.call("/volume/octomap_binary").map), before)
            Path(folder, "map.volume").write_bytes(b"no state")
            answer = self.call(NODE + "/load_state")
            self.assertFalse(answer.success)
            self.assertIn("cannot be read", answer.message)
        self.assertEqual(occupied(self.call("/volume/octomap_binary").map), before)
        rospy.delete_param(NODE + "/state_file")
        self.assertIn("state_file", self.call(NODE + "/save_state").message)

    @long
    def test_octomap_saver_writes_files(self):
        self.walls()
        saver = Path(sys.argv[0]).parents[1] / "gridslam/octomap_saver"  # rosrun takes long to find it
        with tempfile.TemporaryDirectory() as folder:
            for name in ("map.bt", "map.ot"):
                path = f"{folder}/{name}"
                subprocess.run([str(saver), path, "__ns:=/volume"], check=True, timeout=200.0)
                voxels = read_octree(path)
                self.assertEqual(np.count_nonzero(voxels.values(voxels.box()) >= 0.0), len(WALL))
