"""The contract of the node slam_gridslam, seen from outside; simulated time stands still all the while."""

import itertools
import math
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
import rospy
from geometry_msgs.msg import PoseArray
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.msg import Path as PathMessage
from nav_msgs.srv import GetMap
from roslib.packages import find_node
from sensor_msgs.msg import LaserScan
from slam_probe import ROOM_XY, room_scan, transform
from std_msgs.msg import Float64, Header
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from gridslam.files.map_file import read_map
from node_tools.testing import Input, Output, Warned, long, wait_until

NODE = "/gridslam"
PARTICLES = 5
TF_DELAY_S = 0.1
CELL_M = 0.05


class SlamGridslamTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.processed = Output(NODE + "/processed", Header)
        cls.maps = Output("map", OccupancyGrid)
        cls.tf = Output("/tf", TFMessage)
        cls.warned = Warned(NODE)
        cls.scans = Input("scan", LaserScan)
        cls.odometry = Input("/tf", TFMessage)
        cls.static = Input("/tf_static", TFMessage, latch=True)
        cls.static.send(transform("base_link", "laser", rospy.Time(0)))
        cls.starts_s = itertools.count(100_000.0, -1000.0)

    def setUp(self):
        """Each test begins with a filter of its own, since the clock goes back."""
        self.now_s = next(self.starts_s)
        self.warned.sentences.clear()
        self.step()

    # moving about

    def step(self, pose=(0.0, 0.0, 0.0), odom=None, seconds=1.0, wait=True, **changes):
        """Send odometry and the scan of a pose in the room; returns the scan's stamp once acknowledged."""
        self.now_s += seconds
        stamp = rospy.Time.from_sec(self.now_s)
        self.odometry.send(transform("odom", "base_link", stamp, pose if odom is None else odom))
        self.scans.send(room_scan(stamp, pose, **changes))
        if wait:
            self.wait_for_processed(stamp)
        return stamp

    def wait_for_processed(self, stamp):
        wait_until(lambda: stamp in [each.stamp for each in self.processed.messages], f"processed {stamp}")

    def map_to_odom(self):
        for message in reversed(self.tf.messages):
            for edge in message.transforms:
                if (edge.header.frame_id, edge.child_frame_id) == ("map", "odom"):
                    t, q = edge.transform.translation, edge.transform.rotation
                    return edge.header.stamp, (t.x, t.y, 2.0 * math.atan2(q.z, q.w))
        raise AssertionError("no map -> odom")

    def wait_for_map_to_odom(self, stamp):
        """Wait for the one that a scan of this stamp has led to, a little after the one for its odometry."""
        of_odometry = stamp + rospy.Duration.from_sec(TF_DELAY_S)
        wait_until(
            lambda: 0.0 < (self.map_to_odom()[0] - of_odometry).to_sec() < 1e-3,  # not of an earlier test
            "map -> odom",
        )

    # what it publishes

    def test_scans_become_a_map_of_the_room(self):
        for x in (0.6, 1.2, 1.8):
            self.step((x, 0.0, 0.0))
        grid = rospy.ServiceProxy("dynamic_map", GetMap)().map
        self.assertEqual(grid.header.frame_id, "map")
        cells = np.array(grid.data).reshape(grid.info.height, grid.info.width)
        self.assertAlmostEqual(grid.info.resolution, CELL_M, places=6)
        rows, columns = np.nonzero(cells == 100)
        x = grid.info.origin.position.x + (columns + 0.5) * CELL_M
        y = grid.info.origin.position.y + (rows + 0.5) * CELL_M
        from_wall = np.minimum(np.abs(np.abs(x) - ROOM_XY[0]), np.abs(np.abs(y) - ROOM_XY[1]))
        self.assertGreater(len(x), 300)
        self.assertLess(from_wall.mean(), CELL_M)
        middle = cells[int(-grid.info.origin.position.y / CELL_M), int(-grid.info.origin.position.x / CELL_M)]
        self.assertEqual(middle, 0)

    def test_the_last_map_comes_when_the_vehicle_stands_still(self):
        self.step((0.6, 0.0, 0.0))
        first = rospy.Time.from_sec(self.now_s - 1.0)
        self.maps.last(lambda grid: grid.header.stamp == first, "the map of the first scan")
        for seconds in (1.0, 1.0, 1.0, 1.0):
            self.step((0.6, 0.0, 0.0), seconds=seconds)
        last = self.maps.last(lambda grid: grid.header.stamp > first, "the map of the last scan integrated")
        self.assertAlmostEqual(last.header.stamp.to_sec(), first.to_sec() + 1.0)

    def test_what_is_latched_waits_for_latecomers(self):
        self.step((0.6, 0.0, 0.0))
        self.assertTrue(Output("map", OccupancyGrid).last(lambda grid: grid.info.width > 0, "a map"))
        metadata = Output("map_metadata", MapMetaData).last(lambda info: info.width > 0, "the metadata")
        self.assertAlmostEqual(metadata.resolution, CELL_M, places=6)
        path = Output(NODE + "/path", PathMessage).last(lambda path: path.poses, "a path")
        self.assertEqual(path.header.frame_id, "map")
        self.assertTrue(Output(NODE + "/entropy", Float64).last(lambda entropy: entropy.data >= 0.0, "it"))
        particles = Output(NODE + "/particles", PoseArray).last(lambda poses: True, "particles")
        self.assertEqual(len(particles.poses), PARTICLES)

    def test_the_path_is_the_vehicles(self):
        for x in (0.6, 1.2):
            self.step((x, 0.0, 0.0))
        rospy.ServiceProxy("dynamic_map", GetMap)()
        stamp = rospy.Time.from_sec(self.now_s)
        path = Output(NODE + "/path", PathMessage).last(
            lambda path: path.poses[-1].header.stamp == stamp, "it"
        )
        x = [pose.pose.position.x for pose in path.poses]
        np.testing.assert_allclose(x, [0.0, 0.6, 1.2], atol=0.05)

    def test_every_scan_is_acknowledged_integrated_or_not(self):
        stamps = [self.step((0.001 * index, 0.0, 0.0), seconds=0.025, wait=False) for index in range(20)]
        for stamp in stamps:
            self.wait_for_processed(stamp)

    def test_map_to_odom_is_ahead_and_never_goes_back(self):
        stamp = self.step((0.6, 0.0, 0.0))
        self.wait_for_map_to_odom(stamp)
        self.tf.messages.clear()
        for index in range(20):
            self.step((0.6 + 0.01 * index, 0.0, 0.0), seconds=0.02)
        stamps = [
            edge.header.stamp.to_nsec()
            for message in self.tf.messages
            for edge in message.transforms
            if edge.header.frame_id == "map"
        ]
        self.assertTrue(4 <= len(stamps) <= 12, stamps)  # 0.4 s, every 0.05 s
        self.assertEqual(stamps, sorted(set(stamps)))

    def test_without_drift_map_and_odom_are_one(self):
        for x in (0.6, 1.2, 1.8):
            stamp = self.step((x, 0.0, 0.0))
        self.wait_for_map_to_odom(stamp)
        np.testing.assert_allclose(self.map_to_odom()[1], (0.0, 0.0, 0.0), atol=0.05)

    def test_drift_is_undone(self):
        # Given odometry that says 8 % too much
        for x in (0.6, 1.2, 1.8):
            stamp = self.step((x, 0.0, 0.0), odom=(1.08 * x, 0.0, 0.0))
        self.wait_for_map_to_odom(stamp)
        # Then map -> odom takes it back
        np.testing.assert_allclose(self.map_to_odom()[1], (-0.08 * 1.8, 0.0, 0.0), atol=0.05)

    # what goes wrong

    def test_bad_scans_are_left_out_with_a_warning(self):
        for changes in ({"ranges": [math.nan] * 360}, {"ranges": []}, {"angle_increment": 0.0}):
            self.step((0.6, 0.0, 0.0), **changes)
        self.warned.wait_for("No beam of the scan is usable")
        self.warned.wait_for("row of numbers")
        self.warned.wait_for("angle_increment")

    def test_another_lidar_in_mid_run(self):
        self.step((0.6, 0.0, 0.0))
        for x, beams in ((1.2, 720), (0.6, 20), (1.2, 10_000), (1.8, 360)):
            self.step((x, 0.0, 0.0), beams=beams)
            self.assert_maps(x)
        self.warned.wait_for("changed from 360 beams")
        self.assertEqual(self.warned.count("changed from"), 1)

    def assert_maps(self, x):
        """Scans are still integrated: a particle is where the vehicle is."""
        particles = Output(NODE + "/particles", PoseArray)
        particles.last(lambda poses: abs(poses.poses[0].position.x - x) < 0.1, f"particles near {x} m")

    def test_tf_that_comes_late_is_waited_for(self):
        self.now_s += 1.0
        stamp = rospy.Time.from_sec(self.now_s)
        self.scans.send(room_scan(stamp, (0.6, 0.0, 0.0)))
        rospy.rostime.wallsleep(0.2)
        self.assertNotIn(stamp, [header.stamp for header in self.processed.messages])
        self.odometry.send(transform("odom", "base_link", stamp, (0.6, 0.0, 0.0)))
        self.wait_for_processed(stamp)
        self.assert_maps(0.6)

    def test_tf_that_does_not_come_is_missed_aloud(self):
        lost = [self.step(frame="nowhere", seconds=0.6, wait=False) for _ in range(4)]
        self.warned.wait_for('no transform from "base_link" to "nowhere"')
        self.step((0.6, 0.0, 0.0))
        for stamp in lost:
            self.wait_for_processed(stamp)
        self.assert_maps(0.6)

    def test_tf_of_two_roots_is_named(self):
        """And the scans of a second lidar whose frame hangs on odometry are mapped all the while."""
        self.static.send(transform("elsewhere", "island", rospy.Time(0)))
        lost = [self.step(frame="island", seconds=0.6, wait=False) for _ in range(4)]
        self.warned.wait_for('TF has two roots: "island" hangs on "elsewhere", and "base_link" on "odom"')
        self.step((0.6, 0.0, 0.0))
        for stamp in lost:
            self.wait_for_processed(stamp)
        self.assert_maps(0.6)

    def test_a_second_parent_of_the_base_does_no_harm(self):
        for x in (0.6, 1.2):
            ahead = rospy.Time.from_sec(self.now_s + 1.0)
            self.odometry.send(transform("world", "base_link", ahead, (9.0, 9.0, 1.0)))
            self.step((x, 0.0, 0.0))
        self.warned.wait_for('"base_link" has two parents in TF, "odom" and "world"')
        self.assert_maps(1.2)

    def test_odometry_without_scans_is_told(self):
        for second in range(0, 200, 10):
            stamp = rospy.Time.from_sec(self.now_s + second)
            self.odometry.send(transform("odom", "base_link", stamp))
        self.warned.wait_for("without a scan; check the lidar and the scans' topic")

    def test_a_lidar_that_is_upside_down_untold_is_refused(self):
        self.static.send(transform("base_link", "hanging", rospy.Time(0)))
        for turn in range(12):
            pose = (0.6, 0.2, 0.3 * turn)
            ranges = room_scan(rospy.Time(0), pose).ranges
            # From -pi on, so the first beam is its own mirror image
            self.step(pose, seconds=0.5, frame="hanging", ranges=np.roll(ranges[::-1], 1))
        self.warned.wait_for("the lidar hangs upside down and TF does not tell")

    def test_odometry_that_jumps_does_not_move_the_vehicle(self):
        self.step((0.6, 0.0, 0.0), seconds=0.1)
        stamp = self.step((0.6, 0.0, 0.0), odom=(70.0, 20.0, 2.0), seconds=0.1)
        self.warned.wait_for("Odometry jumped")
        self.wait_for_map_to_odom(stamp)
        x, y, yaw = self.map_to_odom()[1]
        base = (
            x + 70.0 * math.cos(yaw) - 20.0 * math.sin(yaw),
            y + 70.0 * math.sin(yaw) + 20.0 * math.cos(yaw),
        )
        np.testing.assert_allclose((*base, yaw + 2.0), (0.6, 0.0, 0.0), atol=0.05)

    def test_a_clock_that_goes_back_starts_anew(self):
        self.step((0.6, 0.0, 0.0))
        self.now_s -= 500.0
        self.step((-1.0, 0.5, 0.0))
        self.warned.wait_for("The clock jumped back by 49")
        self.step((-1.6, 0.5, 0.0))
        self.assert_maps(-1.6)

    def test_a_scan_out_of_order_is_left_out(self):
        self.now_s -= 0.3
        self.step((0.6, 0.0, 0.0), seconds=0.0)
        self.warned.wait_for("older than the one before")

    # services and tools

    def test_a_saved_state_goes_on_where_it_was(self):
        with tempfile.TemporaryDirectory() as folder:
            rospy.set_param(NODE + "/state_file", folder + "/state")
            self.step((0.6, 0.0, 0.0))
            self.assertTrue(rospy.ServiceProxy(NODE + "/save_state", Trigger)().success)
            self.step((1.2, 0.0, 0.0))
            self.assert_maps(1.2)
            answer = rospy.ServiceProxy(NODE + "/load_state", Trigger)()
            self.assertTrue(answer.success, answer.message)
            saved = rospy.Time.from_sec(self.now_s - 1.0)
            self.maps.last(lambda grid: grid.header.stamp == saved, "the map of the saved state")
            self.step((0.6, 0.55, 0.0))
            self.assert_maps(0.6)
            rospy.set_param(NODE + "/state_file", folder + "/nothing")
            answer = rospy.ServiceProxy(NODE + "/load_state", Trigger)()
            self.assertFalse(answer.success)
            self.assertIn("nothing", answer.message)

    def test_map_saver_writes_what_map_server_reads(self):
        self.step((0.6, 0.0, 0.0))
        with tempfile.TemporaryDirectory() as folder:
            saver = find_node("gridslam", "map_saver")[0]
            command = [saver, "--occ=60", "-f", f"{folder}/room", "map:=/map"]
            said = subprocess.run(command, capture_output=True, text=True, timeout=200.0)
            self.assertEqual(said.returncode, 0, said.stderr)
            grid = read_map(f"{folder}/room.yaml")
        same = [one for one in self.maps.messages if np.array_equal(grid.cells.ravel(), one.data)]
        self.assertTrue(same, "no map that was published is the saved one")
        self.assertAlmostEqual(grid.origin_xy_m[0], same[-1].info.origin.position.x, places=5)

    # parameters

    def test_unknown_parameters_are_named(self):
        self.assertIn("no_such_parameter", " ".join(self.said_at_the_start()))

    def said_at_the_start(self):
        """Warnings of the start, which /rosout has no more: from the node's own log."""
        folder = Path(subprocess.check_output(["roslaunch-logs"], text=True).strip())
        return [log.read_text(errors="replace") for log in folder.glob("gridslam*.log")]

    @long
    def test_what_makes_no_sense_ends_it_with_a_sentence(self):
        cases = {
            "_particles:=0": "particles must be at least 1",
            "_starting_map:=/nothing.yaml": "/nothing.yaml cannot be read",
        }
        node = find_node("gridslam", "slam_gridslam")[0]
        running = {
            argument: subprocess.Popen(
                [node, "__ns:=/elsewhere", f"__name:=bad_{index}", argument],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
            for index, argument in enumerate(cases)
        }
        for argument, process in running.items():
            said, _ = process.communicate(timeout=200.0)
            self.assertEqual(process.returncode, 1, said)
            self.assertIn(cases[argument], said)
            self.assertNotIn("Traceback", said)
