"""What leads the publisher from one phase to the next: take-over, failsafes, landings, silence, resets."""

from __future__ import annotations

import pytest

from simulation_tools.geometry import Pose
from simulation_tools.publisher import (
    AnnounceReady,
    Log,
    Phase,
    RequestArm,
    RequestMode,
    SendPosition,
    SendVelocity,
)

from .conftest import GROUND, LANDING, MS


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
    assert said.text == "AUTO.LAND was ordered: the flight controller lands the UAV by itself."
    assert not said.is_warning  # every flight ends so
    bench.set("AUTO.LAND", status=3, armed=False, landed=GROUND).run(30.0)
    assert bench.publisher.phase is Phase.IDLE
    assert not bench.of(RequestMode)
    assert not bench.of(RequestArm)
    bench.publisher.restart()
    bench.run(1.0)
    assert bench.of(RequestArm)


@pytest.mark.parametrize("mode", ["AUTO.LAND", "AUTO.RTL"])
def test_what_the_flight_controller_says_of_its_own_mode_is_told(bench, mode):
    bench.fly()
    bench.publisher.on_text(bench.now, 0, "Dangerous battery level!, landing")
    bench.set(mode, landed=LANDING).run(1.0)
    assert bench.publisher.phase is Phase.YIELDED
    assert bench.of(Log)[-1].text == (
        f'the mode is {mode} now, and the flight controller says "Dangerous battery level!, landing": '
        "leaving the UAV to it until it is OFFBOARD."
    )


@pytest.mark.parametrize(("severity", "before_s"), [(6, 0.0), (2, 6.0)])
def test_what_is_no_warning_or_was_said_long_before_explains_no_mode(bench, severity, before_s):
    bench.fly()
    bench.publisher.on_text(bench.now, severity, "Takeoff detected")
    bench.run(before_s)
    bench.set("AUTO.RTL", landed=LANDING).run(1.0)
    assert bench.of(Log)[-1].text.startswith("somebody else has set the mode AUTO.RTL")


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


def test_after_a_failsafe_it_climbs_before_commands_count(bench):
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


def test_started_in_a_failsafe_it_climbs_to_the_hover_height(bench):
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
