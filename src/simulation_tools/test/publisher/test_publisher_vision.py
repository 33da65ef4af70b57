"""Without external poses the UAV stops before its flight controller gives up, and lands."""

from __future__ import annotations

import pytest

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

from .conftest import GROUND, LANDING, MS, Bench

ZERO = (0.0, 0.0, 0.0)


@pytest.fixture
def flying():
    """Flies by commands of 1 m/s, with vision."""
    bench = Bench(PublisherParameters(needs_vision=True))
    bench.vision = bench.commands = True
    bench.fly().run(1.0)
    return bench


def test_without_need_for_vision_nothing_changes(bench):
    bench.commands = True
    bench.fly()
    assert all(action.linear == (1.0, 0.0, 0.0) for action in Bench.of(bench, SendVelocity)[20:])
    bench.run(5.0)
    assert bench.publisher.phase is Phase.FLYING


def test_it_stops_within_half_a_second_and_lands_before_px4_gives_up(flying):
    flying.vision = False
    flying.run(0.5)
    assert flying.publisher.phase is Phase.BLIND
    assert flying.of(AnnounceReady) == [AnnounceReady(False)]
    assert [log.text for log in flying.of(Log)] == [
        "the flight controller has had no external pose for 0.08 s: stopping, then landing."
    ]
    assert flying.publisher.waiting_for == "the flight controller gets no external pose"
    speeds = [action.linear for action in flying.of(SendVelocity)]
    assert speeds[-8:] == [ZERO] * 8  # for 0.2 s
    flying.run(2.0)
    assert {action.linear for action in flying.of(SendVelocity)} == {ZERO}
    assert not flying.of(SendPosition)
    assert not flying.of(RequestMode)
    flying.run(1.0)
    assert flying.of(RequestMode) == [RequestMode("AUTO.LAND")] * len(flying.of(RequestMode))
    assert flying.of(RequestMode)
    flying.set("AUTO.LAND", landed=LANDING).run(1.0)
    assert flying.publisher.phase is Phase.YIELDED
    flying.set("AUTO.LAND", 5).run(2.0)  # PX4's own failsafe, when it gives up its position
    assert not flying.of(RequestMode)
    flying.set("AUTO.LAND", 3, armed=False, landed=GROUND).run(1.0)
    assert flying.publisher.phase is Phase.IDLE


def test_a_landing_without_a_sure_pose_is_told_once(flying):
    flying.set("AUTO.LAND", landed=LANDING).run(1.0)
    assert flying.publisher.phase is Phase.YIELDED
    flying.vision = False
    flying.run(0.4)
    assert not flying.of(Log)
    flying.run(2.0)
    assert [log.text for log in flying.of(Log)] == [
        "no sure pose while the UAV lands: the flight controller brings it down level."
    ]


def test_when_vision_comes_back_it_flies_on(flying):
    flying.vision = False
    flying.run(1.0)
    flying.vision = True
    flying.run(1.0)
    assert flying.of(AnnounceReady) == [AnnounceReady(True)]
    assert flying.of(SendVelocity)[-1].linear == (1.0, 0.0, 0.0)
    assert flying.publisher.waiting_for == ""


def test_poses_that_go_and_come_are_told_once_and_where_they_stay_away(flying):
    said = []
    for _ in range(8):  # 0.3 s without, 0.5 s with poses
        for flying.vision, lasts_s in ((False, 0.3), (True, 0.5)):
            flying.run(lasts_s)
            said += [log.text for log in flying.of(Log)]
    assert said == [
        "the flight controller has had no external pose for 0.08 s: stopping, then landing.",
        "the flight controller gets poses again, ready.",
    ]
    flying.vision = False
    flying.run(2.0)
    (told,) = [log.text for log in flying.of(Log)]
    assert told.startswith("the flight controller has had no external pose for 1.0")


def test_one_lost_pose_does_not_matter(flying):
    flying.vision = False
    actions = flying.run(0.025)
    flying.vision = True
    actions += flying.run(0.5)
    assert {action.linear for action in actions if isinstance(action, SendVelocity)} == {(1.0, 0.0, 0.0)}


def test_it_notices_the_loss_by_the_clock_alone(flying):
    flying.vision = flying.commands = flying.poses = False
    flying.run(0.1)
    flying.now += 20 * MS
    flying.actions = []
    flying.tell_clock()
    assert flying.publisher.phase is Phase.BLIND
    assert len(flying.of(SendVelocity)) == 1


def test_during_the_take_off_it_stops_too_until_vision_is_back():
    bench = Bench(PublisherParameters(needs_vision=True))
    bench.vision = True
    bench.run(0.5)
    bench.state, bench.landed = FcuState(True, True, "OFFBOARD", 4), 2
    bench.run(0.5)
    assert bench.publisher.phase is Phase.TAKING_OFF
    bench.vision = False
    bench.run(1.0)
    assert bench.publisher.phase is Phase.BLIND
    assert bench.of(SendVelocity)[-1].linear == ZERO
    bench.vision = True
    bench.run(0.5)
    assert bench.publisher.phase is Phase.RETURNING
    assert isinstance(bench.actions[-1], SendPosition)


def test_it_does_not_arm_without_vision():
    bench = Bench(PublisherParameters(needs_vision=True))
    bench.run(3.0)
    assert not bench.of(RequestArm)
    assert bench.publisher.waiting_for == "the flight controller gets no external pose"
    bench.vision = True
    bench.run(1.0)
    assert bench.of(RequestArm)


def test_a_publisher_that_begins_in_the_air_without_vision_stops(flying):
    bench = Bench(PublisherParameters(needs_vision=True))
    bench.commands = True
    bench.set("OFFBOARD").run(1.0)
    assert bench.publisher.phase is Phase.BLIND
    assert bench.of(SendVelocity)[-1].linear == ZERO


def test_late_commands_make_no_ready_of_a_blind_landing(flying):
    """A command tells an older time than the pose before it. What was known then decides nothing any more."""
    flying.command_age = 80 * MS
    flying.vision = False
    flying.run(3.2)
    assert flying.of(RequestMode) == [RequestMode("AUTO.LAND")]
    actions = flying.set("AUTO.LAND", landed=LANDING).run(2.0)
    assert flying.publisher.phase is Phase.YIELDED
    assert {action.ready for action in actions if isinstance(action, AnnounceReady)} == {False}
    assert not flying.of(RequestMode)


@pytest.mark.table("began", [True, False])
def test_offboard_without_vision_is_not_ready(began):
    """Whether the node starts in the air, or somebody gives OFFBOARD back."""
    bench = Bench(PublisherParameters(needs_vision=True))
    bench.commands = True
    if not began:
        bench.set("POSCTL").run(1.0)
        assert bench.publisher.phase is Phase.YIELDED
    bench.set("OFFBOARD").run(1.0)
    assert bench.publisher.phase is Phase.BLIND
    assert {action.ready for action in bench.of(AnnounceReady)} == {False}
    bench.vision = True
    bench.run(1.0)
    assert bench.of(AnnounceReady) == [AnnounceReady(True)]
