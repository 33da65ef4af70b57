"""A publisher on the bench: poses, states and commands come by hand."""

from __future__ import annotations

import pytest

from simulation_tools.geometry import Pose
from simulation_tools.publisher import FcuState, Phase, PublisherParameters, SetpointPublisher

MS = 1_000_000
GROUND, AIR, LANDING = 1, 2, 4


class Bench:
    """Feeds a publisher at 30 Hz poses, 1 Hz states, and gathers what it wants done."""

    def __init__(self, parameters=None):
        self.publisher = SetpointPublisher(parameters or PublisherParameters())
        self.now = 1000 * MS
        self.pose = Pose((1.0, 2.0, 0.12))
        self.state = FcuState(True, False, "AUTO.LOITER", 3)
        self.landed = GROUND
        self.home = True
        self.actions = []
        self.poses = True
        self.clock_ahead = 0  # of ROS's clock, of the poses' stamps, ns
        self.vision = False  # whether external poses go to the flight controller, at 40 Hz
        self.commands = False  # whether velocity commands come, at 40 Hz
        self.velocity, self.yaw_rate = (1.0, 0.0, 0.0), 0.1
        self.command_age = 0  # ns
        self.pose_period = 33 * MS
        self.pose_stamp = lambda now: now  # what MAVROS stamps a pose of this time

    def tell_clock(self):
        """As the node does before every message."""
        self.actions += self.publisher.on_clock(self.now + self.clock_ahead)

    def tell_state(self):
        self.tell_clock()
        self.actions += self.publisher.on_state(self.now, self.state)
        self.actions += self.publisher.on_landed_state(self.now, self.landed)
        if self.home:
            self.actions += self.publisher.on_home(self.now)

    def tell_pose(self):
        self.tell_clock()
        self.actions += self.publisher.on_local_pose(self.pose_stamp(self.now), self.pose)

    def run(self, seconds):
        """Let time pass; returns the actions of this time."""
        self.actions = []
        end = self.now + round(1e9 * seconds)
        while self.now < end:
            self.now += MS
            tick = self.now // MS
            if tick % 100 == 0:
                self.tell_state()
            if self.now % self.pose_period < MS and self.poses:
                self.tell_pose()
            if self.vision and tick % 25 == 0:
                self.tell_clock()
                self.actions += self.publisher.on_vision(self.now + self.clock_ahead)
            if self.commands and tick % 25 == 0:
                velocity, yaw_rate = self.velocity, self.yaw_rate
                self.tell_clock()
                stamp = self.now + self.clock_ahead - self.command_age
                self.actions += self.publisher.on_velocity(stamp, "base_frame", velocity, yaw_rate)
        return self.actions

    def of(self, kind):
        return [action for action in self.actions if isinstance(action, kind)]

    def fly(self):
        """Bring it to where it takes commands."""
        self.run(0.5)
        self.state, self.landed = FcuState(True, True, "OFFBOARD", 4), AIR
        self.pose = Pose((1.0, 2.0, 2.0))
        self.run(1.0)
        assert self.publisher.phase is Phase.FLYING
        return self

    def set(self, mode, status=4, armed=True, landed=AIR):
        self.state, self.landed = FcuState(True, armed, mode, status), landed
        return self


@pytest.fixture
def bench():
    return Bench()
