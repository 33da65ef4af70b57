"""The node inspection_camera as other nodes see it: a gimbal, a shutter, and pictures that come later."""

from __future__ import annotations

import math
import threading
import unittest

import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image
from std_msgs.msg import Float64
from tf2_msgs.msg import TFMessage

from node_tools.testing import Input, Output, Warned, long
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.geometry import Pose, rotate
from simulation_tools.srv import Shoot, ShootRequest
from simulation_tools_ros.conversions import pose_message

EXPOSURE_S = CameraOptics.exposure_s
RATE_RAD_S = math.radians(60.0)
STEP_S = 0.02


class TestInspectionCamera(unittest.TestCase):
    seconds = 10.0
    """Of the last pose."""

    @classmethod
    def setUpClass(cls):
        cls.poses, cls.tilts = Input("photo/ground_truth", Odometry), Input("photo/camera/tilt", Float64)
        cls.tf, cls.images = Output("photo/tf", TFMessage), Output("photo/camera/image_raw", Image)
        cls.truths, cls.warned = Output("photo/camera/ground_truth", PoseStamped), Warned("/photo/camera")
        cls.shoot = rospy.ServiceProxy("photo/camera/shoot", Shoot)
        cls.shoot.wait_for_service(200.0)

    def tell(self, seconds):
        """Tell that the UAV is at rest 1 m above the origin."""
        message = Odometry()
        message.header.stamp = rospy.Time.from_sec(seconds)
        message.pose.pose = pose_message(Pose.from_xyz_rpy(0.0, 0.0, 1.0))
        self.poses.send(message)

    def fly(self, for_s):
        """Tell the poses of so many seconds, and wait until the camera has the last one."""
        for _ in range(round(for_s / STEP_S)):
            type(self).seconds = round(self.seconds + STEP_S, 6)
            self.tell(self.seconds)
        stamp = rospy.Time.from_sec(self.seconds)
        self.tf.last(lambda message: message.transforms[0].header.stamp == stamp, "the pose")

    def tilt(self, angle_rad):
        self.tilts.deliver(Float64(angle_rad))  # another topic than the poses: it must be there before them

    @long  # the node waits 15 s for one
    def test_1_without_a_pose_it_takes_no_photograph(self):
        told = self.shoot(ShootRequest())
        self.assertFalse(told.success)
        self.assertIn("no pose", told.status_message)

    def test_2_the_gimbal_turns_at_its_rate_and_a_shot_meanwhile_blurs(self):
        self.fly(0.1)
        self.tilt(math.radians(30.0))
        self.fly(0.24)
        turning = self.shoot(ShootRequest())
        self.fly(0.5)
        rests = self.shoot(ShootRequest())
        self.assertTrue(turning.success and rests.success)
        self.assertLess(rests.blur, 0.01)
        # 60 deg/s while it is open, in the middle of a picture of 320 px across 60 deg; more in the corners
        middle_px = RATE_RAD_S * EXPOSURE_S * 160.0 / math.tan(math.radians(30.0))
        self.assertGreater(turning.blur, middle_px)
        self.assertLess(turning.blur, 2.0 * middle_px)
        self.assertAlmostEqual(turning.turn, RATE_RAD_S * EXPOSURE_S)
        self.assertLess(max(rests.turn, rests.shift, turning.shift), 1e-4)
        for told, tilt_rad in ((turning, RATE_RAD_S * 0.24), (rests, math.radians(30.0))):
            q = told.pose.orientation
            ahead = rotate((q.x, q.y, q.z, q.w), (0.0, 0.0, 1.0))
            self.assertAlmostEqual(math.asin(ahead[2]), tilt_rad, delta=RATE_RAD_S * STEP_S + 1e-6)

    def test_3_the_shutter_waits_for_the_pose_that_the_caller_names(self):
        told = []
        later = rospy.Time.from_sec(self.seconds + STEP_S)
        asking = threading.Thread(target=lambda: told.append(self.shoot(ShootRequest(not_before=later))))
        asking.start()
        rospy.sleep(0.5)
        self.assertFalse(told)
        self.fly(STEP_S)
        asking.join(60.0)
        self.assertTrue(told[0].success)
        self.assertEqual(told[0].stamp, later)

    @long  # as above
    def test_4_a_pose_that_does_not_come_is_told(self):
        told = self.shoot(ShootRequest(not_before=rospy.Time.from_sec(self.seconds + 1.0)))
        self.assertFalse(told.success)
        self.assertIn(f"The UAV's pose of {self.seconds + 1.0:.3f} s has not come", told.status_message)

    def test_5_the_picture_comes_with_the_stamp_of_the_shutter_and_shows_the_wall(self):
        self.tilt(0.0)
        self.fly(1.0)
        self.images.messages.clear()
        told = self.shoot(ShootRequest())
        picture = self.images.next()
        self.assertEqual(picture.header.stamp, told.stamp)
        self.assertEqual((picture.width, picture.height, picture.encoding), (320, 240, "rgb8"))
        self.assertEqual(len(picture.data), 320 * 240 * 3)
        self.assertGreater(told.lux, 0.0)
        truth = self.truths.last(lambda each: each.header.stamp == told.stamp, "the shot's true pose")
        self.assertAlmostEqual(truth.pose.position.z, 0.95, places=6)

    def test_6_bad_input_is_told_and_it_goes_on(self):
        self.tilts.send(Float64(math.nan))
        self.warned.wait_for("The tilt is not finite")
        message = Odometry()
        message.header.stamp = rospy.Time.from_sec(self.seconds + STEP_S)
        message.pose.pose.position.x = math.nan
        self.poses.send(message)
        self.warned.wait_for("The true pose is ignored")
        self.assertTrue(self.shoot(ShootRequest()).success)

    def test_7_the_exposure_follows_the_bias_and_a_bias_that_makes_no_sense_is_refused(self):
        plain, darker = (self.shoot(ShootRequest(bias=each)) for each in (0.0, -0.5))
        self.assertAlmostEqual(math.log2(plain.iso / darker.iso), 0.5, places=6)
        for request in (ShootRequest(bias=math.nan), ShootRequest(bias=1e9), ShootRequest(detail=-1.0)):
            told = self.shoot(request)
            self.assertFalse(told.success)
            self.assertIn("makes no sense", told.status_message)

    def test_8_a_clock_that_jumps_back_is_followed(self):
        type(self).seconds = 1.0
        self.fly(0.1)
        told = self.shoot(ShootRequest(not_before=rospy.Time.from_sec(self.seconds)))
        self.assertEqual(told.stamp, rospy.Time.from_sec(self.seconds))
