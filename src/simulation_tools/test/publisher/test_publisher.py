"""How the publisher takes off and answers commands, message by message."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from simulation_tools.geometry import Pose
from simulation_tools.publisher import (
    AnnounceReady,
    FcuState,
    Log,
    Phase,
    PublisherParameters,
    RequestArm,
    RequestMode,
    SendPosition,
    SendVelocity,
)

from .conftest import AIR, GROUND, MS, Bench


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


def test_it_stands_until_it_is_told_the_height_and_to_begin(bench):
    publisher = bench.publisher
    publisher.parameters = replace(publisher.parameters, awaits_order=True)
    bench.run(3.0)
    assert not bench.of(RequestArm)
    assert publisher.waiting_for == "no order to take off yet (rosservice call /mavros_publisher/restart)"
    # When the height is told, and the order
    publisher.parameters = replace(publisher.parameters, hover_height_m=0.5)
    publisher.restart()
    bench.run(1.0)
    assert bench.of(RequestArm)
    # Then the UAV, whose origin stands 0.12 m high, rises by 0.38 m
    bench.set("OFFBOARD")
    bench.pose = Pose((1.0, 2.0, bench.pose.position_m[2] + 0.38))
    rest_z_m = bench.pose.position_m[2]
    bench.run(1.0)
    assert bench.of(SendPosition)[-1].position[2] == pytest.approx(rest_z_m)


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


def test_a_command_waits_for_the_pose_that_it_is_judged_by():
    """In lockstep the command may come sooner than MAVROS's messages of the same time."""
    bench = Bench()
    assert bench.publisher.patience_s(500 * MS) == 0.0  # not on a real UAV, whatever the stamps are
    bench.publisher.parameters = replace(bench.publisher.parameters, time_is_simulated=True)
    first = bench.publisher.patience_s(500 * MS)
    assert 0.0 < first < 0.1
    bench.publisher.on_clock(600 * MS)
    bench.publisher.on_local_pose(600 * MS, bench.pose)
    assert bench.publisher.patience_s(650 * MS) == 0.0
    assert bench.publisher.patience_s(690 * MS) > first
    bench.publisher.on_local_pose(630 * MS, bench.pose)
    assert bench.publisher.patience_s(690 * MS) == 0.0
    bench.publisher.on_clock(2000 * MS)  # MAVROS is away: nobody waits
    assert bench.publisher.patience_s(2000 * MS) == 0.0


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


@pytest.mark.table("rate_hz", [30, 130, 250, 1000])
def test_commands_as_old_as_they_may_be_are_answered_at_every_rate_of_poses(rate_hz):
    """MAVROS sends 30 poses a second. PX4 sends more if it is asked to (SET_MESSAGE_INTERVAL)."""
    bench = Bench(PublisherParameters(command_timeout_s=5.0))
    bench.pose_period = 1_000_000_000 // rate_hz
    bench.commands, bench.command_age = True, 4900 * MS
    bench.run(0.5)
    bench.state, bench.landed = FcuState(True, True, "OFFBOARD", 4), AIR
    bench.run(1.0)
    bench.pose = Pose((1.0, 2.0, 2.0))
    bench.run(7.0)
    assert bench.publisher.phase is Phase.FLYING
    assert bench.of(SendVelocity)[-1].linear == (1.0, 0.0, 0.0)
