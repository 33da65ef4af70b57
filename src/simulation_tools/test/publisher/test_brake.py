"""The stop of a UAV that has lost its external pose."""

import math

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.publisher import PublisherParameters
from simulation_tools.publisher.brake import Brake
from simulation_tools.publisher.history import History

P = PublisherParameters()
MS = 1_000_000
NOW_NS = 10_000 * MS
NEWEST_S = 0.045  # age of the newest pose that the brake may know
G_M_S2 = 9.81
NORTH = math.pi / 2


class Uav:
    """PX4's velocity law along one way, a lean that follows late, and the air's drag.

    With 0.05 s and 0.11 s a step reaches 10 % after 0.20 s, 50 % after 0.56 s; PX4's after 0.20, 0.52 s.
    """

    STEP_S = 0.005
    P_1_S, I_1_S2, D, DRAG_1_S = 1.8, 0.4, 0.2, 0.3

    def __init__(self, speed_m_s, delay_s, lag_s):
        self.delay_s, self.lag_s, self.heading_rad = delay_s, lag_s, NORTH
        self.place_m, self.speed_m_s = 0.0, speed_m_s
        self.lean_m_s2 = self.integral_m_s2 = self.DRAG_1_S * speed_m_s  # it flies steadily
        self.commands = [(-1.0, speed_m_s)]
        self.poses, self.time_s = History(), -0.5
        while self.time_s < -1e-9:
            self.step(speed_m_s)

    def step(self, command_m_s):
        """Fly on for a step, and tell the pose."""
        self.commands.append((self.time_s, command_m_s))
        flown = [v for t, v in self.commands if t <= self.time_s - self.delay_s + 1e-9][-1]
        acceleration = self.lean_m_s2 - self.DRAG_1_S * self.speed_m_s
        off = flown - self.speed_m_s
        wanted = self.P_1_S * off + self.integral_m_s2 - self.D * acceleration
        self.integral_m_s2 += self.I_1_S2 * off * self.STEP_S
        self.lean_m_s2 += (wanted - self.lean_m_s2) * self.STEP_S / self.lag_s
        self.speed_m_s += acceleration * self.STEP_S
        self.place_m += self.speed_m_s * self.STEP_S
        self.time_s += self.STEP_S
        pitch = math.atan(self.lean_m_s2 / G_M_S2)
        pose = Pose.from_xyz_rpy(0.0, self.place_m, 2.0, 0.0, pitch, self.heading_rad)
        self.poses.add(NOW_NS + round(1e9 * self.time_s), pose)

    def stop(self, brakes_s=0.1, lasts_s=1.5):
        """Fly on for brakes_s, then brake; return times since then and speeds."""
        speed_m_s = self.speed_m_s
        while self.time_s < brakes_s - 1e-9:
            self.step(speed_m_s)
        brake, rows = Brake(NOW_NS + round(1e9 * self.time_s), self.poses, P), []
        while self.time_s < lasts_s:
            self.step(brake.velocity(NOW_NS + round(1e9 * self.time_s))[0])
            rows.append((self.time_s, self.speed_m_s))
        return np.array(rows).T


def poses(east=0.0, north=0.0, yaw=NORTH, turn=0.0, until_s=-NEWEST_S, history=None):
    """Return poses of steady flight until this time: m/s, heading, rad/s. The lean is what the drag needs.

    history: poses before them.
    """
    history = history or History()
    for before_s in (0.06, 0.0):
        heading = yaw - turn * before_s
        ahead = 0.3 * (math.cos(heading) * east + math.sin(heading) * north)
        aside = 0.3 * (math.sin(heading) * east - math.cos(heading) * north)
        lean = math.atan(aside / G_M_S2), math.atan(ahead / G_M_S2)
        pose = Pose.from_xyz_rpy(5.0 - east * before_s, -north * before_s, 2.0, *lean, heading)
        history.add(NOW_NS + round(1e9 * (until_s - before_s)), pose)
    return history


@pytest.mark.table("share", [0.7, 1.0, 1.3])
@pytest.mark.table("speed_m_s", [0.3, 1.0, 2.0])
def test_a_uav_that_leans_sooner_or_later_stops_and_hardly_swings_back(speed_m_s, share):
    times_s, speeds = Uav(speed_m_s, 0.05 * share, 0.11 * share).stop()
    over_s = 0.1 + max(P.brake_time_s, 1.5 * speed_m_s / P.brake_acceleration_m_s2)
    assert speeds[times_s > over_s + 0.05].max() < 0.25 * speed_m_s
    assert speeds[times_s > over_s + 0.5].max() < 0.1
    assert speeds.min() > -0.12 * speed_m_s


@pytest.mark.table(
    ("east", "north", "ahead", "left"),
    [
        (1.0, 0.0, 0, 1),  # to the right of a UAV that looks north
        (-0.5, 0.0, 0, -1),
        (0.0, 0.5, -1, 0),
        (0.0, -0.5, 1, 0),
    ],
)
def test_it_is_commanded_against_its_own_motion(east, north, ahead, left):
    x, y, z = Brake(NOW_NS, poses(east, north), P).velocity(NOW_NS)
    assert z == 0.0
    assert (x, y) == pytest.approx((ahead * math.hypot(x, y), left * math.hypot(x, y)), abs=1e-6)
    assert math.hypot(x, y) > 2.0 * math.hypot(east, north)


def test_the_command_follows_the_plan():
    """The least jerk from v to rest in T: v (1 - 3 s^2 + 2 s^3), s = t / T."""
    t = 0.085 / P.brake_time_s
    speed = 1 - 3 * t**2 + 2 * t**3
    acceleration = (-6 * t + 6 * t**2) / P.brake_time_s
    jerk = (-6 + 12 * t) / P.brake_time_s**2
    lean = acceleration + 0.11 * jerk + 0.28 * (speed - 1.0)
    expected = speed + (lean + 0.2 * acceleration) / 1.8
    late_s = NEWEST_S + 0.03  # the lean goes on from the middle of the two poses
    drift = 0.3 * late_s
    command = Brake(NOW_NS, poses(north=1.0), P).velocity(NOW_NS)[0]
    assert command == pytest.approx(expected * (1.0 + drift), abs=0.02)


def test_the_command_is_bounded():
    history = poses(north=1.0)
    stop = Brake(NOW_NS, history, P)
    poses(north=5.0, until_s=0.1, history=history)  # it did not brake, but was pushed on
    x, y, _ = stop.velocity(NOW_NS + 200 * MS)
    assert math.hypot(x, y) == pytest.approx(P.brake_speed_m_s)


def test_a_uav_that_turns_has_turned_on_when_it_brakes():
    straight = Brake(NOW_NS, poses(north=0.5), P).velocity(NOW_NS)
    turning = Brake(NOW_NS, poses(north=0.5, turn=2.0), P).velocity(NOW_NS)
    turned = math.atan2(turning[1], turning[0]) - math.atan2(straight[1], straight[0])
    # Since the newest pose, and until it turns no more; the motion then points to its right
    assert math.remainder(turned, 2 * math.pi) == pytest.approx(-2.0 * (NEWEST_S + 0.05), abs=0.02)


def test_a_slow_uav_hovers():
    assert Brake(NOW_NS, poses(north=0.1), P).velocity(NOW_NS) == (0.0, 0.0, 0.0)


def test_after_a_second_the_command_is_zero():
    history = poses(north=1.0)
    stop = Brake(NOW_NS, history, P)
    poses(north=0.3, until_s=0.96, history=history)
    assert stop.velocity(NOW_NS + 999 * MS)[0] < -0.1
    assert stop.velocity(NOW_NS + 1001 * MS) == (0.0, 0.0, 0.0)


def test_without_two_poses_it_is_commanded_to_stand():
    history = History()
    assert Brake(NOW_NS, history, P).velocity(NOW_NS) == (0.0, 0.0, 0.0)
    history.add(NOW_NS - 50 * MS, Pose.from_xyz_rpy(5.0, 1.0, 2.0, 0.0, 0.0, 0.0))
    assert Brake(NOW_NS, history, P).velocity(NOW_NS) == (0.0, 0.0, 0.0)


def test_when_the_poses_end_it_is_commanded_to_stand():
    stop = Brake(NOW_NS, poses(north=1.0), P)
    assert stop.velocity(NOW_NS + 150 * MS)[0] < 0.0
    assert stop.velocity(NOW_NS + 170 * MS) == (0.0, 0.0, 0.0)  # the newest is more than 0.2 s old
