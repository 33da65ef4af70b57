"""The publisher's state machine, message by message; the flights through ROS are in mavros_publisher.test."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest

from simulation_tools.geometry import Pose
from simulation_tools.publisher import (
    AnnounceReady,
    FcuState,
    Log,
    Phase,
    PublisherError,
    PublisherParameters,
    RequestArm,
    RequestMode,
    SendPosition,
    SendVelocity,
    SetpointPublisher,
)
from simulation_tools.px4.modes import LandedState

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
        self.commands = False  # whether velocity commands come, at 40 Hz
        self.velocity, self.yaw_rate = (1.0, 0.0, 0.0), 0.1

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
        self.actions += self.publisher.on_local_pose(self.now, self.pose)

    def run(self, seconds):
        """Let time pass; returns the actions of this time."""
        self.actions = []
        end = self.now + round(1e9 * seconds)
        while self.now < end:
            self.now += MS
            tick = self.now // MS
            if tick % 100 == 0:
                self.tell_state()
            if tick % 33 == 0 and self.poses:
                self.tell_pose()
            if self.commands and tick % 25 == 0:
                velocity, yaw_rate = self.velocity, self.yaw_rate
                self.tell_clock()
                stamp = self.now + self.clock_ahead
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


def test_it_streams_before_it_asks_and_asks_for_offboard_before_arming(bench):
    actions = bench.run(1.0)
    kinds = [type(action) for action in actions]
    assert kinds.index(RequestMode) < kinds.index(RequestArm)
    before = actions[: kinds.index(RequestMode)]
    assert sum(isinstance(action, (SendVelocity, SendPosition)) for action in before) >= 3
    assert bench.of(RequestMode)[0].mode == "OFFBOARD"


def test_nothing_is_asked_without_a_connection_or_a_pose():
    unconnected = Bench()
    unconnected.state = FcuState(False, False, "", 0)
    unconnected.run(2.0)
    assert not unconnected.of(RequestArm)
    blind = Bench()
    blind.tell_pose = lambda: None
    blind.commands = True
    blind.run(2.0)
    assert not blind.of(RequestArm)
    assert all(action.linear == (0.0, 0.0, 0.0) for action in blind.of(SendVelocity))


def test_requests_are_repeated_every_half_second_until_they_hold(bench):
    bench.run(3.0)
    assert 4 <= len(bench.of(RequestArm)) <= 6
    bench.set("OFFBOARD", landed=GROUND).run(0.5)
    bench.run(2.0)
    assert not bench.of(RequestArm)


def test_it_climbs_to_the_hover_height_over_the_ground_with_its_heading(bench):
    bench.pose = Pose.from_xyz_rpy(1.0, 2.0, 0.12, yaw=0.7)
    bench.run(0.5)
    setpoint = bench.of(SendPosition)[-1]
    assert setpoint.position[:2] == (1.0, 2.0)
    assert setpoint.position[2] > 2.0  # it aims higher while it is far below
    assert setpoint.yaw == pytest.approx(0.7)
    bench.set("OFFBOARD")
    bench.pose = Pose.from_xyz_rpy(1.0, 2.0, 2.0, yaw=0.7)
    bench.run(1.0)
    assert bench.of(SendPosition)[-1].position == pytest.approx((1.0, 2.0, 2.0))


def test_ready_is_said_when_it_hovers_and_not_while_it_passes(bench):
    bench.run(0.5)
    bench.set("OFFBOARD")
    bench.actions = []
    for i in range(20):  # 1 m/s upwards
        bench.pose = Pose((1.0, 2.0, 1.2 + 0.05 * i))
        bench.now += 50 * MS
        bench.tell_pose()
        bench.tell_state()
    assert not bench.of(AnnounceReady)
    bench.pose = Pose((1.0, 2.0, 2.04))
    bench.run(1.2)
    assert bench.of(AnnounceReady) == [AnnounceReady(True)]


def test_every_velocity_is_answered_with_its_stamp_from_the_first_on():
    bench = Bench()
    for i in range(200):
        bench.now += 25 * MS
        actions = bench.publisher.on_velocity(bench.now, "base_frame", (1.0, 0.0, 0.0), 0.0)
        setpoints = [a for a in actions if isinstance(a, (SendVelocity, SendPosition))]
        assert [a.stamp_ns for a in setpoints] == [bench.now]
        if i % 4 == 0:
            bench.tell_state()
            poses = bench.publisher.on_local_pose(bench.now, bench.pose)
            # Poses are not answered while commands are: lockstep would take an answer for the scan's.
            assert i == 0 or not any(isinstance(a, (SendVelocity, SendPosition)) for a in poses)


def test_in_flight_velocities_are_handed_on_and_never_positions(bench):
    bench.fly()
    bench.commands = True
    bench.run(1.0)
    assert {action.linear for action in bench.of(SendVelocity)} == {(1.0, 0.0, 0.0)}
    assert len(bench.of(SendVelocity)) == 40
    assert len(bench.of(SendPosition)) <= 1  # one pose may come before the first command


def test_commands_of_zero_keep_the_hover_point_of_the_take_off(bench):
    bench.fly()
    bench.commands, bench.velocity, bench.yaw_rate = True, (0.0, 0.0, 0.0), 0.0
    bench.pose = Pose((1.0, 2.0, 1.9))  # sunk: the hover point must not sink with it
    bench.run(3.0)
    assert not bench.of(SendVelocity)
    x, y, z = bench.of(SendPosition)[-1].position
    assert (x, y) == (1.0, 2.0)
    assert z >= 2.0


def test_a_command_of_zero_brakes_and_then_holds_the_position(bench):
    bench.fly()
    bench.commands, bench.yaw_rate = True, 0.0
    for i in range(80):  # at 1 m/s all the time
        bench.now += 25 * MS
        bench.pose = Pose((1.0 + 0.025 * i, 2.0, 2.0))
        bench.tell_pose()
        bench.tell_state()
        bench.velocity = (1.0 if i < 40 else 0.0, 0.0, 0.0)
        bench.actions += bench.publisher.on_velocity(bench.now, "base_frame", bench.velocity, 0.0)
    assert bench.of(SendVelocity)[-1].linear == (0.0, 0.0, 0.0)
    assert len(bench.of(SendVelocity)) == 80
    bench.run(1.0)
    held = bench.of(SendPosition)[-1].position
    assert held == pytest.approx(bench.pose.position_m, abs=0.03)
    bench.pose = Pose((2.9, 2.0, 1.8))
    bench.run(1.0)
    assert {action.position for action in bench.of(SendPosition)} == {held}
    bench.velocity = (0.0, 0.0, 0.1)
    bench.run(0.5)
    assert len(bench.of(SendVelocity)) == 20


def test_a_turn_on_the_spot_is_no_command_of_zero(bench):
    bench.fly()
    bench.commands, bench.velocity = True, (0.0, 0.0, 0.0)
    bench.run(0.5)
    assert {action.yaw_rate for action in bench.of(SendVelocity)} == {0.1}


def test_an_old_command_is_replaced_by_hover_where_it_is(bench):
    bench.fly()
    bench.commands = True
    bench.run(1.0)
    bench.commands = False
    bench.pose = Pose((7.0, 8.0, 2.0))
    bench.run(0.4)
    assert not bench.of(SendPosition)
    bench.run(1.0)
    assert {action.position for action in bench.of(SendPosition)} == {(7.0, 8.0, 2.0)}
    bench.pose = Pose((7.5, 8.0, 2.0))  # drifting does not move the hover point
    bench.run(0.5)
    assert {action.position for action in bench.of(SendPosition)} == {(7.0, 8.0, 2.0)}
    assert len(bench.of(SendPosition)) >= 10  # at least 20 Hz


@pytest.mark.parametrize("off_s", [-0.6, -900.0, 0.6, 900.0])
def test_a_command_stamped_far_from_now_is_answered_but_not_flown(bench, off_s):
    bench.fly()
    stamp = bench.now + round(off_s * 1e9)
    late = bench.publisher.on_velocity(stamp, "base_frame", (1.0, 0.0, 0.0), 0.0)
    assert isinstance(late[-1], SendPosition)
    assert late[-1].stamp_ns == max(stamp, 0)
    bench.run(1.0)
    assert bench.publisher.phase is Phase.FLYING
    assert not bench.of(SendVelocity)
    assert len(bench.of(SendPosition)) >= 20  # the stream goes on


@pytest.mark.parametrize(
    ("frame", "linear", "word"),
    [
        ("base_frame", (math.nan, 0.0, 0.0), "NaN"),
        ("base_frame", (0.0, math.inf, 0.0), "NaN"),
        ("base_frame", (1e308, 0.0, 0.0), "absurd number"),
        ("map", (1.0, 0.0, 0.0), "unknown frame"),
    ],
)
def test_bad_velocities_are_refused_and_lead_to_hover(bench, frame, linear, word):
    bench.fly()
    bench.actions = bench.publisher.on_velocity(bench.now, frame, linear, 0.0)
    assert word in bench.of(Log)[0].text
    assert bench.of(Log)[0].repeated
    assert isinstance(bench.actions[-1], SendPosition)
    assert bench.actions[-1].stamp_ns == bench.now


def test_positions_are_flown_when_asked_for_and_expire_too():
    bench = Bench(PublisherParameters(use_position_setpoint=True)).fly()
    bench.commands = True
    bench.actions = bench.publisher.on_position(bench.now, (5.0, 5.0, 3.0), 0.5)
    bench.run(0.4)
    assert {action.position for action in bench.of(SendPosition)} == {(5.0, 5.0, 3.0)}
    assert not bench.of(SendVelocity)
    bench.run(0.3)
    bench.run(0.5)
    assert {action.position for action in bench.of(SendPosition)} == {(1.0, 2.0, 2.0)}
    for bad in (math.nan, math.inf, -1e300):
        assert bench.publisher.on_position(bench.now, (bad, 0.0, 0.0), 0.0)[0].repeated


def test_in_mid_air_it_takes_over_where_the_uav_is(bench):
    bench.pose = Pose((9.0, 9.0, 4.0))
    bench.set("OFFBOARD").run(1.0)
    assert bench.publisher.phase is Phase.FLYING
    assert bench.of(AnnounceReady) == [AnnounceReady(True)]
    assert not bench.of(RequestArm)
    assert bench.of(SendPosition)[-1].position == (9.0, 9.0, 4.0)


def test_in_mid_air_in_a_failsafe_it_asks_for_offboard_again(bench):
    bench.pose = Pose((9.0, 9.0, 4.0))
    bench.set("AUTO.LAND", status=5, landed=LANDING).run(1.0)
    assert bench.publisher.phase is Phase.RETURNING
    assert bench.of(RequestMode)
    assert not bench.of(RequestArm)


def test_in_mid_air_in_somebody_elses_mode_it_keeps_out(bench):
    bench.set("AUTO.LAND", landed=LANDING).run(2.0)
    assert bench.publisher.phase is Phase.YIELDED
    assert not bench.of(RequestMode)
    assert not bench.of(RequestArm)


def test_somebody_elses_landing_is_left_alone_to_the_end(bench):
    bench.fly()
    bench.commands = True
    bench.set("AUTO.LAND", landed=LANDING).run(3.0)
    assert bench.publisher.phase is Phase.YIELDED
    assert bench.of(AnnounceReady) == [AnnounceReady(False)]
    (said,) = bench.of(Log)
    assert "AUTO.LAND was ordered" in said.text
    assert not said.is_warning  # every flight ends so
    bench.set("AUTO.LAND", status=3, armed=False, landed=GROUND).run(30.0)
    assert bench.publisher.phase is Phase.IDLE
    assert not bench.of(RequestMode)
    assert not bench.of(RequestArm)
    bench.publisher.restart()
    bench.run(1.0)
    assert bench.of(RequestArm)


def test_offboard_given_back_is_taken_up_where_the_uav_is(bench):
    bench.fly()
    bench.set("AUTO.LOITER").run(1.0)
    assert bench.publisher.phase is Phase.YIELDED
    assert bench.of(Log)[-1].is_warning  # nobody here does that
    bench.pose = Pose((3.0, 3.0, 3.0))
    bench.set("OFFBOARD").run(1.0)
    assert bench.publisher.phase is Phase.FLYING
    assert bench.of(SendPosition)[-1].position == (3.0, 3.0, 3.0)


def test_a_failsafe_in_flight_is_answered_by_asking_for_offboard(bench):
    bench.fly()
    bench.set("AUTO.LAND", status=5, landed=LANDING).run(1.6)
    assert 2 <= len(bench.of(RequestMode)) <= 4
    assert bench.of(AnnounceReady) == [AnnounceReady(False)]


def test_after_a_failsafe_it_climbs_back_to_the_hover_height_before_commands_count(bench):
    bench.fly()
    bench.commands = True
    bench.pose = Pose((7.0, 8.0, 0.4))
    bench.set("AUTO.LAND", status=5, landed=LANDING).run(1.0)
    bench.set("OFFBOARD").run(2.0)
    assert not bench.of(AnnounceReady)
    assert not bench.of(SendVelocity)
    x, y, z = bench.of(SendPosition)[-1].position
    assert (x, y) == (7.0, 8.0)
    assert z >= 2.0
    bench.pose = Pose((7.0, 8.0, 2.0))
    bench.run(1.5)
    assert bench.of(AnnounceReady) == [AnnounceReady(True)]
    assert bench.of(SendVelocity)


def test_started_in_a_failsafe_it_climbs_to_the_hover_height_over_the_ground(bench):
    """It has not seen the UAV stand; PX4's frame begins where an Iris stands, 0.12 m over the ground."""
    bench.pose = Pose((7.0, 8.0, 0.4))
    bench.set("AUTO.LAND", status=5, landed=LANDING).run(1.0)
    bench.set("OFFBOARD").run(1.0)
    bench.pose = Pose((7.0, 8.0, 1.88))
    bench.run(1.5)
    assert bench.of(AnnounceReady)[-1] == AnnounceReady(True)
    assert bench.of(SendPosition)[-1].position == pytest.approx((7.0, 8.0, 1.88))


def test_after_a_failsafe_high_up_it_stays_there(bench):
    bench.fly()
    bench.pose = Pose((7.0, 8.0, 6.0))
    bench.set("AUTO.LAND", status=5, landed=LANDING).run(1.0)
    bench.set("OFFBOARD").run(1.5)
    assert bench.of(SendPosition)[-1].position == (7.0, 8.0, 6.0)
    assert bench.publisher.phase is Phase.FLYING


def test_a_silent_mavros_is_called_by_its_name_and_no_commands_are_taken(bench):
    bench.fly()
    bench.commands = True
    bench.run(0.5)
    bench.actions = []
    died = bench.now
    while bench.now < died + 3000 * MS:
        bench.now += 25 * MS
        bench.actions += bench.publisher.on_clock(bench.now)
        bench.actions += bench.publisher.on_velocity(bench.now, "base_frame", bench.velocity, 0.0)
    said = [action.text for action in bench.of(Log)]
    assert said[0] == "MAVROS has sent no pose for 0.5 s."
    assert "no pose for 1.5 s" in said[2]
    assert not any("future" in text for text in said)
    assert len(said) == 4  # once a second, and what follows from it
    assert bench.of(AnnounceReady) == [AnnounceReady(False)]
    late = [a for a in bench.of(SendVelocity) if a.stamp_ns > died + 600 * MS]
    assert not late
    bench.commands = False
    bench.run(1.5)
    assert bench.of(AnnounceReady) == [AnnounceReady(True)]


def test_it_says_nothing_of_missing_poses_on_the_ground_when_all_is_over(bench):
    bench.fly()
    bench.set("AUTO.LAND", landed=LANDING).run(1.0)
    bench.set("AUTO.LAND", status=3, armed=False, landed=GROUND).run(1.0)
    assert bench.publisher.phase is Phase.IDLE
    bench.actions = bench.publisher.on_clock(bench.now + 60_000 * MS)
    assert bench.of(Log) == []


def test_after_a_failsafe_landing_it_takes_off_again(bench):
    bench.fly()
    bench.set("AUTO.LAND", status=5, landed=LANDING).run(1.0)
    bench.set("AUTO.LAND", status=3, armed=False, landed=GROUND)
    bench.pose = Pose((4.0, 4.0, 0.12))
    bench.run(1.0)
    assert bench.publisher.phase is Phase.TAKING_OFF
    assert bench.of(RequestArm)
    assert bench.of(SendPosition)[-1].position[:2] == (4.0, 4.0)


def test_a_take_off_that_somebody_aborts_is_not_repeated(bench):
    bench.run(0.5)
    bench.pose = Pose((1.0, 2.0, 1.0))
    bench.set("OFFBOARD").run(1.0)
    bench.set("AUTO.LAND", landed=LANDING).run(1.0)
    assert bench.publisher.phase is Phase.YIELDED


def test_a_clock_that_jumps_back_starts_it_again(bench):
    bench.fly()
    bench.now = 0
    bench.set("MANUAL", status=3, armed=False, landed=GROUND)
    bench.pose = Pose((1.0, 2.0, 0.12))
    bench.run(0.2)
    assert AnnounceReady(False) in bench.of(AnnounceReady)
    assert bench.of(Log)[0].text.startswith("the clock jumped back")
    bench.run(1.0)
    assert bench.publisher.phase is Phase.TAKING_OFF


def test_a_reset_is_noticed_before_the_first_pose_after_it(bench):
    bench.fly()
    bench.publisher.on_clock(12_000_000_000)
    bench.actions = bench.publisher.on_clock(11_990_000_000)
    assert bench.of(AnnounceReady) == []
    assert AnnounceReady(False) in bench.publisher.on_clock(0)
    assert bench.publisher.phase is Phase.WAITING
    bench.actions = bench.publisher.on_clock(4_000_000)
    assert bench.of(Log) == []


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_parameters_are_checked(value):
    with pytest.raises(PublisherError, match="command_timeout_s"):
        PublisherParameters(command_timeout_s=value)


# In closed loop, without ROS


def fly_closed_loop(extra_kg, seconds, velocity=None):
    """Fly the publisher on the flight controller; returns (flight, publisher, time when ready).

    velocity: commanded at 40 Hz all the time.
    """
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "px4"))
    from flight import Flight

    from simulation_tools.px4.modes import Mode
    from simulation_tools.px4.setpoint import Setpoint

    flight = Flight.of_iris(extra_kg, seed=2)
    publisher = SetpointPublisher(PublisherParameters(ground_clearance_m=0.0))
    ready_s = None

    def act(actions):
        nonlocal ready_s
        for action in actions:
            if isinstance(action, SendPosition):
                flight.px4.offer_setpoint(Setpoint.hold(action.position, action.yaw))
            elif isinstance(action, SendVelocity):
                flight.px4.offer_setpoint(Setpoint.fly(action.linear, action.yaw_rate))
            elif isinstance(action, RequestMode):
                flight.px4.request_mode(Mode.OFFBOARD)
            elif isinstance(action, RequestArm):
                flight.px4.request_arm()
            elif isinstance(action, AnnounceReady) and action.ready:
                ready_s = flight.time_s

    for tick in range(round(seconds / 0.004)):
        flight.step()
        now = 1000 * flight.body.time_us
        status = flight.px4.status
        if tick % 50 == 0:
            act(publisher.on_landed_state(now, int(status.landed_state)))
            state = FcuState(True, status.armed, status.mode.label, status.system_status)
            act(publisher.on_state(now, state))
            if flight.px4.home is not None:
                act(publisher.on_home(now))
        if tick % 8 == 0 and status.position_valid:
            act(publisher.on_local_pose(now, Pose(flight.body.position, flight.body.attitude)))
        if velocity is not None and tick % 6 == 0:
            act(publisher.on_velocity(now, "", velocity, 0.0))
    return flight, publisher, ready_s


# Over six seeds of the estimate's noise 9.6 to 10.4 s and 10.5 to 11.4 s.
@pytest.mark.parametrize(("extra_kg", "limit_s"), [(0.13, 10.6), (0.80, 11.6)])
def test_in_closed_loop_it_is_ready_soon_and_does_not_overshoot(extra_kg, limit_s):
    flight, _, ready_s = fly_closed_loop(extra_kg, 14.0)
    assert ready_s is not None
    assert ready_s < limit_s
    assert flight.body.position == pytest.approx((0.0, 0.0, 2.0), abs=0.05)
    assert flight.px4.status.landed_state is LandedState.IN_AIR


@pytest.mark.parametrize("extra_kg", [0.13, 0.80])
def test_in_closed_loop_commands_of_zero_hover_at_the_hover_height(extra_kg):
    flight, _, ready_s = fly_closed_loop(extra_kg, 30.0, velocity=(0.0, 0.0, 0.0))
    assert ready_s is not None
    assert flight.body.position == pytest.approx((0.0, 0.0, 2.0), abs=0.05)
