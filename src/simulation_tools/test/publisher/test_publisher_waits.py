"""The publisher with a flight controller as slow and imprecise as PX4 is; and what it says while it waits."""

from __future__ import annotations

import pytest

from simulation_tools.geometry import Pose
from simulation_tools.publisher import (
    AnnounceReady,
    AnnounceStatus,
    FcuState,
    Log,
    Phase,
    PublisherParameters,
    RequestArm,
    RequestMode,
    SendPosition,
    SendVelocity,
    SetpointPublisher,
)

MS = 1_000_000
GROUND, TAKEOFF, AIR = 1, 3, 4
ACTIVE, CRITICAL = 4, 5


class Px4Like:
    """PX4 as it was measured: boots for seconds, tells its state once a second, knows home late.

    Times in ms. Position valid at 6.1 s, home at 7.1 s (EKF2 needs GPS first). Who arms before that gets a
    failsafe, until OFFBOARD can be entered. Climbs 1 m/s from 3 s after arming, to `off_m` from its setpoint.
    """

    def __init__(self, off_m=0.0, stamps_behind_ms=0, home_at_ms=7100):
        self.off_m, self.stamps_behind_ms, self.home_at_ms = off_m, stamps_behind_ms, home_at_ms
        self.armed_ms, self.mode, self.failsafe = None, "MANUAL", False
        self.z, self.target_z = -0.02, None
        self.publisher = SetpointPublisher(PublisherParameters())
        self.now_ms = 0
        self.log = []  # (time in ms, action)

    @property
    def state(self):
        status = 3 if self.armed_ms is None else CRITICAL if self.failsafe else ACTIVE
        return FcuState(True, self.armed_ms is not None, self.mode, status)

    def run(self, until_ms, velocity=None):
        while self.now_ms < until_ms:
            self.now_ms += 1
            self.fly()
            stamp = (self.now_ms - self.stamps_behind_ms) * MS
            self.tell(self.publisher.on_clock(self.now_ms * MS))
            if self.now_ms % 1000 == 700:
                self.tell(self.publisher.on_state(stamp, self.state))
            if self.now_ms % 200 == 0:
                climbing = self.armed_ms is not None and self.now_ms > self.armed_ms + 1900
                self.tell(self.publisher.on_landed_state(stamp, AIR if climbing else GROUND))
            if self.now_ms >= self.home_at_ms and self.now_ms % 2000 == 100:
                self.tell(self.publisher.on_home(stamp))
            if self.now_ms > 1300 and self.now_ms % 20 == 0:
                self.tell(self.publisher.on_local_pose(stamp, Pose((0.0, 0.0, self.z))))
            if velocity is not None and self.now_ms % 25 == 0:
                self.tell(self.publisher.on_velocity(self.now_ms * MS, "base_frame", velocity, 0.0))

    def fly(self):
        if self.armed_ms is None or self.now_ms < self.armed_ms + 3000 or self.target_z is None:
            return
        missing = self.target_z - self.off_m - self.z
        self.z += max(min(missing, 0.001), -0.001)

    def tell(self, actions):
        for action in actions:
            self.log.append((self.now_ms, action))
            if isinstance(action, SendPosition):
                # It settles where the setpoint's law would have it: the climb aims higher than its end.
                self.target_z = self.publisher._hover.point[0][2]
            elif isinstance(action, RequestMode) and self.now_ms > 6100:
                self.mode, self.failsafe = action.mode, False
            elif isinstance(action, RequestArm) and self.armed_ms is None:
                self.armed_ms, self.failsafe = self.now_ms, self.mode != "OFFBOARD"

    def said(self, kind):
        return [action for _, action in self.log if isinstance(action, kind)]

    def when(self, kind):
        return [time_ms for time_ms, action in self.log if isinstance(action, kind)]


def test_it_arms_once_it_knows_its_home_and_not_twice_meanwhile():
    px4 = Px4Like()
    px4.run(20_000)
    assert not px4.failsafe
    assert len(px4.when(RequestArm)) == 1
    assert 7100 <= px4.when(RequestArm)[0] <= 8400  # HOME_POSITION comes every two seconds
    assert [action.ready for action in px4.said(AnnounceReady)] == [True]
    assert px4.publisher.phase is Phase.FLYING


def test_without_need_of_a_home_it_arms_despite_the_failsafe():
    px4 = Px4Like(home_at_ms=10**9)
    px4.publisher.parameters = PublisherParameters(needs_home=False)
    px4.run(25_000)
    assert px4.when(RequestArm)[0] < 3000  # PX4 takes it, and flashes its failsafe
    assert [action.ready for action in px4.said(AnnounceReady)] == [True]
    assert px4.publisher.phase is Phase.FLYING


@pytest.mark.table("off_m", [-0.1, 0.1])
def test_a_height_that_settles_a_hand_off_is_a_hover_all_the_same(off_m):
    px4 = Px4Like(off_m=off_m)
    px4.run(25_000, velocity=(1.0, 0.0, 0.0))
    assert px4.publisher.phase is Phase.FLYING
    assert px4.said(SendVelocity)[-1].linear == (1.0, 0.0, 0.0)
    # ... and so is the hover after a failsafe
    px4.mode, px4.failsafe = "AUTO.LAND", True
    px4.run(28_000, velocity=(1.0, 0.0, 0.0))
    px4.run(40_000, velocity=(1.0, 0.0, 0.0))
    assert [action.ready for action in px4.said(AnnounceReady)] == [True, False, True]
    assert px4.publisher.phase is Phase.FLYING


def test_a_status_that_is_critical_in_offboard_takes_nothing_away():
    px4 = Px4Like()
    px4.run(20_000)
    px4.failsafe = True
    px4.run(23_000)
    assert [action.ready for action in px4.said(AnnounceReady)] == [True]
    assert px4.publisher.phase is Phase.FLYING


def test_stamps_that_lag_behind_ros_are_no_missing_poses_and_are_told_of():
    """A constant lag once looked like poses that never come: it hovered for ever, and said nothing."""
    px4 = Px4Like(stamps_behind_ms=700)
    px4.run(25_000, velocity=(1.0, 0.0, 0.0))
    assert px4.publisher.phase is Phase.FLYING
    assert px4.said(SendVelocity)[-1].linear == (1.0, 0.0, 0.0)
    said = [action.text for action in px4.said(Log) if action.is_warning]
    assert len(said) == 1
    assert "stamped 0.7 s behind ROS's clock" in said[0]


def test_the_old_poses_of_a_mavros_that_hung_are_no_hover():
    """All that came meanwhile arrives at once: the UAV has sunk, and old poses say that it hovers."""
    px4 = Px4Like()
    px4.run(20_000)
    hung_ms = px4.now_ms
    for _ in range(3000):  # MAVROS hangs; PX4 lands
        px4.now_ms += 1
        px4.tell(px4.publisher.on_clock(px4.now_ms * MS))
    for old_ms in range(hung_ms + 20, px4.now_ms - 600, 20):
        px4.tell(px4.publisher.on_clock(px4.now_ms * MS))
        px4.tell(px4.publisher.on_local_pose(old_ms * MS, Pose((0.0, 0.0, px4.z))))
    assert [action.ready for action in px4.said(AnnounceReady)] == [True, False]
    assert px4.publisher.waiting_for == "MAVROS sends no poses any more"


def publisher_told(state=None, landed=None, pose=None, home=False, seconds=31):
    """Return a publisher that heard this and no more for so long, and what it said."""
    publisher, actions = SetpointPublisher(PublisherParameters()), []
    for tick in range(1, 20 * seconds):
        now = tick * 50 * MS
        actions += publisher.on_clock(now)
        actions += publisher.on_state(now, state) if state else []
        actions += publisher.on_landed_state(now, landed) if landed else []
        actions += publisher.on_home(now) if home else []
        actions += publisher.on_local_pose(now, pose) if pose else []
    return publisher, actions


STANDS = FcuState(True, False, "AUTO.LOITER", 3)
FLIES = FcuState(True, True, "OFFBOARD", ACTIVE)
POSE = Pose((0.0, 0.0, 0.12))


@pytest.mark.table(
    ("told", "words"),
    [
        ({}, "no `state` from MAVROS yet"),
        ({"state": FcuState(False, False, "", 0)}, "MAVROS hears no flight controller"),
        ({"state": STANDS, "pose": POSE}, "no `extended_state` from MAVROS yet"),
        ({"state": STANDS, "landed": GROUND}, "no `local_position/pose` from MAVROS yet"),
        ({"state": STANDS, "landed": GROUND, "pose": POSE}, "no home position"),
        ({"state": STANDS, "landed": GROUND, "pose": POSE, "home": True}, "AUTO.LOITER, not OFFBOARD"),
        (
            {"state": FcuState(True, False, "OFFBOARD", 3), "landed": GROUND, "pose": POSE, "home": True},
            "the flight controller is not armed",
        ),
        ({"state": FLIES, "landed": GROUND, "pose": POSE}, "not at its hover point yet"),
    ],
)
def test_every_wait_says_for_what(told, words):
    publisher, actions = publisher_told(**told)
    statuses = [action.text for action in actions if isinstance(action, AnnounceStatus)]
    assert words in statuses[-1]
    assert words in publisher.waiting_for
    said = [action.text for action in actions if isinstance(action, Log)]
    assert len(said) in (2, 3)  # every 10 s of the 31
    assert all(words in text and "still " in text for text in said)


def test_without_gnss_it_says_where_the_pose_should_come_from():
    publisher = SetpointPublisher(PublisherParameters(needs_home=False, needs_vision=True))
    publisher.on_state(50 * MS, STANDS)
    publisher.on_landed_state(50 * MS, GROUND)
    assert "no `local_position/pose` from MAVROS yet" in publisher.waiting_for
    assert "needs external poses" in publisher.waiting_for
    publisher.on_vision(100 * MS)  # and nothing comes of it
    assert "no `local_position/pose` from MAVROS yet" in publisher.waiting_for
    assert "has it mavros_extras" in publisher.waiting_for


def test_nothing_is_waited_for_in_flight():
    px4 = Px4Like()
    px4.run(20_000)
    assert px4.publisher.waiting_for == ""
    assert px4.said(AnnounceStatus)[-1] == AnnounceStatus("")
    assert not [action for action in px4.said(Log) if action.is_warning]
