"""A UAV whose lidar sees its own arms, among walls in closed form, through the whole loop."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from cepa import CepaParameters, Dynamic, Improved, LaserScan2D, Motion, SteeringLoop
from cepa.dynamic.constants.free_space import COARSE_BINS, COARSE_ROWS
from cepa.dynamic.free_space.cloud_picture import CloudPicture
from cepa.steering.clouds import CloudLimits, SensedPoints
from cepa.steering.mount import Mount
from cepa.steering.own_motion import OwnState

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from planar_flight import Scene

HALL = np.array([(-20, -5, 20, -5), (-20, 5, 20, 5), (-20, -5, -20, 5), (20, -5, 20, 5)], float)
LEVEL = Mount.of_pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
BEAMS, PERIOD_S, LAG_S = 720, 0.05, 0.45
ANGLES = -math.pi + 2.0 * math.pi / BEAMS * np.arange(BEAMS)
LIMITS = CloudLimits((-0.26, 0.26), (-math.pi, math.pi), (0.1, 50.0))


class Bench:
    """A UAV that flies what the loop answers. arms: bearings in degrees, each 6 degrees wide."""

    def __init__(self, walls=HALL, algorithm=Dynamic, arms=(), arm_m=0.24, place=(0.0, 0.0), **parameters):
        self.said = []
        self.algorithm = algorithm(CepaParameters(**parameters))
        self.loop = SteeringLoop(self.algorithm, lambda frame: LEVEL, self.said.append, LIMITS)
        self.scene, self.rng = Scene(walls=walls), np.random.default_rng(1)
        self.place, self.speed, self.time_s = np.array(place), np.zeros(2), 100.0
        self.is_arm = np.zeros(BEAMS, bool)
        for bearing in arms:
            self.is_arm |= np.abs(np.degrees(ANGLES) - bearing) < 3.0
        self.arm_m, self.least_m = arm_m, math.inf

    def ranges(self, yaw_rad):
        directions = np.stack((np.cos(ANGLES + yaw_rad), np.sin(ANGLES + yaw_rad)), axis=1)
        found = self.scene.ranges(self.place, directions) + self.rng.normal(0.0, 0.01, BEAMS)
        return np.where(self.is_arm, self.arm_m + self.rng.normal(0.0, 0.003, BEAMS), found)

    def fly(
        self, seconds, reference=(0.0, 0.0), led=False, yaw=lambda at_s: 0.0, with_clouds=False, off_m=0.0
    ):
        """led: fly the reference, whatever the loop answers. reference: along the hall's axes, m/s.

        off_m: by which odometry's places are wrong at the end, along x; its drift is even.
        """
        for k in range(round(seconds / PERIOD_S)):
            self.time_s += PERIOD_S
            stamp_ns, yaw_rad = round(1e9 * self.time_s), yaw(k * PERIOD_S)
            c, s = math.cos(yaw_rad), math.sin(yaw_rad)
            turn, half = np.array(((c, -s), (s, c))), 0.5 * yaw_rad
            own, wanted = turn.T @ self.speed, turn.T @ np.array(reference)
            x, y = self.place
            x += off_m * k * PERIOD_S / seconds
            state = OwnState((*own, 0.0), (x, y, 2.0), (0.0, 0.0, math.sin(half), math.cos(half)))
            ranges = self.ranges(yaw_rad)
            if with_clouds:
                up = np.radians((-2.0, 0.0, 2.0))[:, None]
                rows = ranges * np.cos(ANGLES), ranges * np.sin(ANGLES), ranges * np.tan(up)
                points = np.stack(np.broadcast_arrays(*rows), -1).reshape(-1, 3)
                self.loop.on_cloud(stamp_ns, SensedPoints(points, LEVEL))
            self.loop.on_odometry(stamp_ns, state)
            self.loop.on_reference(stamp_ns, (*wanted, 0.0))
            scan = LaserScan2D(ranges, -math.pi, 2.0 * math.pi / BEAMS, 0.06, 30.0)
            for command in self.loop.on_scan(stamp_ns, scan, "laser"):
                answer = turn @ command.velocity_m_s[:2]
            wanted = np.array(reference) if led else answer
            self.speed = self.speed + PERIOD_S / LAG_S * (wanted - self.speed)
            self.place = self.place + PERIOD_S * self.speed
            self.least_m = min(self.least_m, self.scene.clearance(self.place))
        return self

    def says(self, words):
        return any(words in sentence for sentence in self.said)


SEEN = "within the UAV's own body or moving with it"
ARMS = (45, 135, -45, -135)


@pytest.mark.table("algorithm", [Dynamic, Improved])
def test_arms_are_told_with_their_bearings_and_nobody_is_told_to_lead_it_another_way(algorithm):
    bench = Bench(algorithm=algorithm, arms=ARMS).fly(15.0, (1.0, 0.0))
    assert bench.says(SEEN)
    assert bench.says("-135, -45, 45, 135 degrees")
    assert bench.says("self_filter")
    assert not bench.says("Lead it another way")


def test_who_no_longer_sees_himself_is_told_that_he_is_held_up():
    sides = (1.0, -1.0, 1.0, 1.0), (-1.0, -1.0, -1.0, 1.0), (-1.0, 1.0, 1.0, 1.0), (-1.0, -1.0, 1.0, -1.0)
    bench = Bench(np.array(sides), arms=ARMS).fly(5.0, (1.0, 0.0))
    bench.is_arm[:] = False  # a hand that held it
    assert bench.fly(20.0, (1.0, 0.0)).says("Lead it another way")


@pytest.mark.table("with_clouds", [False, True])
@pytest.mark.table("algorithm", [Dynamic, Improved])
def test_arms_that_are_left_out_are_no_obstacle(algorithm, with_clouds):
    bench = Bench(algorithm=algorithm, arms=ARMS, self_filter=True)
    bench.fly(12.0, (1.0, 0.0), with_clouds=with_clouds)
    assert bench.place[0] > 6.0  # 10 s of 1 m/s, less what it takes to find them
    assert bench.says("left out")


def test_a_wall_still_counts_for_one_who_leaves_out_his_arms():
    wall = np.array([(5.0, -5.0, 5.0, 5.0)])
    bench = Bench(np.concatenate((HALL, wall)), arms=ARMS, self_filter=True).fly(15.0, (1.0, 0.0))
    assert bench.algorithm.parameters.body_radius < bench.least_m < 3.0


def test_what_is_behind_an_arm_that_is_left_out_is_unseen():
    bench = Bench(algorithm=Improved, arms=(45,), self_filter=True).fly(4.0)
    x, y = bench.fly(1.0, (0.7, 0.7)).speed
    assert math.hypot(x, y) > 0.5
    assert abs(math.degrees(math.atan2(y, x)) - 45.0) > 3.0  # improved flies where a beam looks


def test_a_leg_beyond_the_bodys_radius_is_found_by_flying():
    bench = Bench(arms=(135,), arm_m=0.55).fly(3.0)
    assert not bench.says(SEEN)
    assert bench.fly(4.0, (1.0, 0.0), led=True).says(SEEN)


def test_a_leg_beyond_the_bodys_radius_is_found_by_turning():
    bench = Bench(arms=(135,), arm_m=0.55)
    assert bench.fly(4.0, yaw=lambda at_s: 0.5 * at_s).says(SEEN)


@pytest.mark.table("self_filter", [False, True])
def test_walls_and_poles_beside_which_it_flies_are_not_its_own(self_filter):
    beside = Bench(place=(-15.0, -4.5), self_filter=self_filter)  # 0.5 m from a wall
    beside.fly(15.0, (2.0, 0.0), led=True)
    narrow = Bench(np.array([(-30.0, -0.5, 30.0, -0.5), (-30.0, 0.5, 30.0, 0.5)]), self_filter=self_filter)
    narrow.fly(10.0, (1.0, 0.0), led=True)
    assert not beside.says(SEEN)
    assert not narrow.says(SEEN)


def test_a_pole_around_which_it_flies_with_its_front_towards_it_is_not_its_own():
    corners = [(-0.05, -0.05), (0.05, -0.05), (0.05, 0.05), (-0.05, 0.05)]
    pole = np.array([(*corners[k], *corners[(k + 1) % 4]) for k in range(4)])
    bench = Bench(pole)
    for k in range(300):
        angle = 0.05 * k
        bench.place, bench.speed = 0.7 * np.array((math.cos(angle), math.sin(angle))), np.zeros(2)
        bench.fly(PERIOD_S, yaw=lambda at_s, angle=angle: angle + math.pi)
    assert not bench.says(SEEN)


def test_a_pole_beside_which_it_hovers_is_not_its_own_when_odometry_drifts_or_jumps():
    bench = Bench(np.array([(0.6, -0.05, 0.6, 0.05)])).fly(30.0, off_m=0.6)
    bench.fly(5.0)  # the places jump back by 0.6 m
    assert not bench.says(SEEN)


def test_nothing_is_free_behind_what_a_cloud_shows_of_the_uav_itself():
    ahead, behind = np.array([[0.3, 0.0, 0.0]]), np.array([[-9.0, 0.01 * k, 0.0] for k in range(100)])
    level = Motion(0.0, (0.0, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    picture, row = CloudPicture(), COARSE_ROWS // 2
    picture.take_in(LIMITS.cloud(behind), level)
    assert picture.free[row, COARSE_BINS // 2] > 40.0  # nothing returns from there, so it is free
    points = picture.take_in(LIMITS.cloud(behind, ahead), level)
    assert picture.free[row, COARSE_BINS // 2] == 0.0
    assert picture.free[row, COARSE_BINS // 4] > 40.0
    assert (points[:, 0] < 0.0).all()  # and it is no obstacle
