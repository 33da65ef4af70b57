"""The publisher with ArduPilot: GUIDED, take-off by command, an origin; failsafes have the last word."""

from __future__ import annotations

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
    RequestTakeoff,
    SendLevel,
    SendPosition,
    SendVelocity,
    SetOrigin,
)
from simulation_tools.publisher.families import ARDUPILOT, PX4, family_of
from simulation_tools.values import ParameterError

from .conftest import AIR, GROUND, LANDING, Bench


def bench_of(**parameters):
    bench = Bench(PublisherParameters(family=ARDUPILOT, **parameters))
    bench.state = FcuState(True, False, "STABILIZE", 3)
    return bench


def flying(**parameters):
    bench = bench_of(**parameters)
    bench.vision = bench.publisher.parameters.needs_vision
    bench.run(0.5)
    bench.set("GUIDED", landed=GROUND).run(0.5)
    bench.pose = Pose((1.0, 2.0, 2.0))
    bench.set("GUIDED").run(1.0)
    assert bench.publisher.phase is Phase.FLYING
    return bench


def test_autopilots_have_families():
    assert (family_of("standin"), family_of("px4"), family_of("ardupilot")) == (PX4, PX4, ARDUPILOT)
    with pytest.raises(ParameterError, match="autopilot"):
        family_of("betaflight")


def test_it_asks_for_guided_then_arms_and_sends_no_setpoint_that_would_end_the_climb():
    bench = bench_of()
    bench.run(0.5)  # knows the states
    bench.run(1.0)
    assert bench.of(RequestMode)[0] == RequestMode("GUIDED")
    assert bench.of(RequestArm)
    for kind in (RequestTakeoff, SendPosition, SendVelocity):
        assert not bench.of(kind)


def test_once_armed_it_asks_for_the_height_over_the_ground_until_the_uav_climbs():
    bench = bench_of(hover_height_m=2.0, ground_clearance_m=0.12)
    bench.run(0.5)
    bench.set("GUIDED", landed=GROUND).run(2.0)
    assert set(bench.of(RequestTakeoff)) == {RequestTakeoff(1.88)}
    assert len(bench.of(RequestTakeoff)) > 1  # it may refuse the first
    bench.set("GUIDED", landed=AIR).run(0.3)  # climbs
    bench.run(2.0)
    assert not bench.of(RequestTakeoff)
    assert not bench.of(SendPosition)
    assert not bench.of(AnnounceReady)


def test_at_its_height_it_takes_commands():
    bench = flying()
    assert bench.of(AnnounceReady) == [AnnounceReady(True)]
    bench.commands = True
    bench.run(1.0)
    assert bench.of(SendVelocity)[-1].linear == (1.0, 0.0, 0.0)


def test_a_landing_that_was_ordered_ends_the_flight():
    bench = flying()
    bench.set("LAND", landed=LANDING).run(1.0)
    assert bench.publisher.phase is Phase.YIELDED
    bench.set("LAND", status=3, armed=False, landed=GROUND).run(1.0)
    assert bench.publisher.phase is Phase.IDLE


@pytest.mark.table("mode", ["RTL", "LAND"])
def test_a_failsafe_has_the_last_word(mode):
    """PX4's is answered by asking for OFFBOARD again."""
    bench = flying()
    bench.set(mode, status=5).run(3.0)
    assert bench.publisher.phase is Phase.YIELDED
    assert not bench.of(RequestMode)


def test_without_gnss_it_tells_the_origin_before_it_arms():
    bench = bench_of(needs_home=False, needs_vision=True)
    bench.vision, bench.home = True, False
    bench.run(2.0)
    assert bench.of(SetOrigin)
    assert not bench.of(RequestArm)
    bench.home = True
    bench.run(0.5)
    bench.run(1.0)
    assert not bench.of(SetOrigin)
    assert bench.of(RequestArm)


def test_when_external_poses_end_it_gets_zeros_then_lands():
    bench = flying(needs_home=False, needs_vision=True)
    bench.commands = True
    bench.run(1.0)
    bench.vision = False
    bench.run(1.0)
    assert bench.publisher.phase is Phase.BLIND
    assert bench.of(SendVelocity)[-1].linear == (0.0, 0.0, 0.0)
    assert not bench.of(RequestMode)
    bench.run(3.0)
    assert bench.of(RequestMode)[0] == RequestMode("LAND")


def test_when_a_pose_was_late_before_it_left_the_ground_it_is_told_to_take_off_again():
    """It obeys no position on the ground, and would disarm there."""
    bench = bench_of(needs_home=False, needs_vision=True)
    bench.vision = bench.home = True
    bench.run(0.5)
    bench.set("GUIDED", landed=GROUND).run(1.0)
    assert bench.of(RequestTakeoff)
    bench.vision = False
    bench.run(1.0)
    assert bench.publisher.phase is Phase.BLIND
    bench.vision = True
    bench.run(2.0)
    assert bench.publisher.phase is Phase.TAKING_OFF
    assert bench.of(RequestTakeoff)
    bench.pose = Pose((1.0, 2.0, 2.0))
    bench.set("GUIDED", landed=AIR).run(1.0)
    assert bench.publisher.phase is Phase.FLYING


def landing_without_a_pose():
    bench = flying(needs_home=False, needs_vision=True)
    bench.pose = Pose((1.0, 2.0, 2.0), (0.0, 0.0, 0.6, 0.8))
    bench.commands = True
    bench.run(0.5)
    bench.set("LAND", landed=LANDING).run(1.0)
    bench.vision = False
    return bench


def test_a_pose_that_is_late_does_not_end_its_landing():
    bench = landing_without_a_pose()
    bench.run(0.9)
    bench.vision = True
    bench.run(1.0)
    assert bench.publisher.phase is Phase.YIELDED
    assert not bench.of(SendLevel)


def test_where_it_lands_without_a_pose_it_comes_down_level_and_then_disarms():
    """Its LAND would follow a velocity that nobody measures, and tip over on the ground."""
    # Given a landing
    bench = landing_without_a_pose()
    # When it has no pose for more than a second
    bench.run(1.3)
    # Then it is told so, and the UAV sinks with its heading, even if MAVROS sends no poses any more
    assert [log.text for log in bench.of(Log) if "level" in log.text] == [
        "no sure pose while the UAV lands: it comes down level, and may drift."
    ]
    assert bench.of(RequestMode) == [RequestMode("GUIDED_NOGPS")]
    bench.set("GUIDED_NOGPS").poses = False
    bench.vision = True  # poses that come back change nothing
    bench.run(2.0)
    levels = bench.of(SendLevel)
    assert len(levels) > 20
    assert {(round(level.yaw, 6), level.thrust < 0.5) for level in levels} == {(1.287002, True)}
    assert not [bench.of(kind) for kind in (SendVelocity, SendPosition, RequestMode) if bench.of(kind)]
    # And on the ground it is disarmed
    bench.set("GUIDED_NOGPS", landed=GROUND).run(0.5)
    assert bench.of(RequestMode)[0] == RequestMode("LAND")
    bench.set("LAND", landed=GROUND).run(2.0)
    assert not bench.of(RequestMode)
    bench.set("LAND", status=3, armed=False, landed=GROUND).run(1.0)
    assert bench.publisher.phase is Phase.IDLE


def test_a_pilot_takes_over_while_it_comes_down_level():
    bench = landing_without_a_pose()
    bench.run(1.3)
    bench.set("STABILIZE").run(1.0)
    assert bench.publisher.phase is Phase.YIELDED
    bench.run(1.0)
    assert not bench.of(SendLevel)
    assert not bench.of(RequestMode)
