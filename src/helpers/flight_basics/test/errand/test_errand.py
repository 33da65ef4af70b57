"""What an errand does with its goals, the map and the clock."""

import pytest
from errand_model import Hands, Kept, pose

from flight_basics.errand import messages as came
from flight_basics.errand import outputs as out
from flight_basics.errand.errand import BATTERY_S, FIRST_S
from flight_basics.errand.parameters import ErrandParameters

PARAMETERS = ErrandParameters("test", "Nothing is flown.", needs_battery=True)


def goal(name, content="yes", stamp_s=0.0):
    return came.Goal(name, content, name, stamp_s)


def flying(kept=None):
    """Fly a goal."""
    hands = Hands(PARAMETERS, kept=kept)
    hands.give(pose(10.0))
    hands.give(came.Battery(10.0, 0.9))
    hands.give(goal("one", stamp_s=10.0))
    hands.work_all()
    assert hands.errand.is_active
    return hands


@pytest.mark.table(
    ("told", "waits_s", "words"),
    [
        ([came.Battery(1.0, 0.9)], FIRST_S, "The place of the UAV is not known yet."),
        ([pose(1.0)], FIRST_S + BATTERY_S, "The battery has told nothing yet"),
    ],
)
def test_a_goal_waits_for_what_is_missing_and_is_refused_in_the_end(told, waits_s, words):
    hands = Hands(PARAMETERS)
    for message in told:
        hands.give(message)
    hands.give(goal("one"))
    hands.wall_s = waits_s - 0.1
    hands.give(came.Tick())
    assert hands.finished == []
    hands.wall_s = waits_s + 0.1
    hands.give(came.Tick())
    (finish,) = hands.finished
    assert finish.end is out.End.ABORTED
    assert words in finish.words


def test_a_pose_that_makes_no_sense_is_told_only_while_something_is_flown():
    fault = came.Pose(11.0, None, fault="TF knows no transform.")
    assert not [said for said in Hands(PARAMETERS).give(fault) if isinstance(said, out.Say)]
    assert out.Say("rarely", fault.fault) in flying().give(fault)


def test_a_goal_that_is_refused_does_not_end_the_one_before_in_its_place():
    hands = flying()
    hands.give(goal("two", "no", 11.0))
    assert [(each.goal.name, each.end) for each in hands.finished] == [("one", out.End.CANCELED)]
    hands.work_all()
    assert [(each.goal.name, each.end) for each in hands.finished[1:]] == [("two", out.End.ABORTED)]
    # And the flight whose goal is over comes home all the same
    for step in range(5):
        hands.give(pose(11.0 + step))
        hands.work_all()
    assert not hands.errand.is_active
    assert len(hands.finished) == 2


def test_a_goal_that_was_cancelled_while_it_was_read_comes_home_at_once():
    hands = Hands(PARAMETERS)
    hands.give(pose(10.0))
    hands.give(came.Battery(10.0, 0.9))
    hands.give(goal("one"))
    hands.give(came.Cancel("one"))
    hands.work_all()
    assert hands.leader.end == "aborted"


@pytest.mark.table(
    ("message", "who"),
    [
        (lambda: came.Command("abort"), "Somebody ended the test by the service ~abort."),
        (lambda: came.Cancel("one"), "Somebody cancelled the goal of the test."),
    ],
)
def test_a_flight_that_somebody_ends_says_how(message, who):
    hands = flying()
    hands.give(message())
    assert (hands.leader.end, hands.leader.reason) == ("aborted", who)


@pytest.mark.table("dies", [False, True])
@pytest.mark.table("order", ["abort", "pause"])
def test_an_order_counts_for_a_goal_that_is_still_read_and_after_a_restart(order, dies):
    kept = Kept()
    hands, two = flying(kept), goal("two", stamp_s=11.0)
    command = came.Command(order)
    hands.give(two)
    hands.give(command)
    assert command.reply.result().success
    if dies:
        hands = Hands(PARAMETERS, kept=kept)
        for message in (pose(11.0, (5.0, 0.0, 2.0)), came.Battery(11.0, 0.9), two):
            hands.give(message)
    hands.work_all()
    assert hands.errand.is_active
    assert (hands.leader.end, hands.leader.is_paused) == (
        ("aborted", False) if order == "abort" else ("", True)
    )
    assert hands.leader.home_m == [0.0, 0.0, 2.0]


def test_an_older_goal_of_another_sender_does_not_replace_the_newest_unless_the_clock_was_set_back():
    hands = flying()
    hands.give(goal("older", stamp_s=9.0))
    assert [each.goal.name for each in hands.finished] == ["older"]
    hands.give(pose(-3000.0))
    hands.give(goal("two", stamp_s=-2999.0))
    assert [each.goal.name for each in hands.finished] == ["older", "one"]
    hands.work_all()
    assert [each.name for each in hands.open] == ["two"]


@pytest.mark.table("step_s", [3600.0, -3600.0])
def test_a_clock_that_is_set_is_no_silence_of_the_map(step_s):
    hands = flying()
    hands.give(pose(10.0 + step_s))
    assert hands.leader.end == ""
    assert any("clock was set" in each.words for each in hands.told(out.Say))
    # But a map that tells nothing while the UAV flies is one
    for tenth in range(120):
        hands.give(pose(10.0 + step_s + 0.1 * tenth))
    assert hands.leader.end == "aborted"


def test_what_ended_before_a_restart_is_not_flown_again():
    kept = Kept()
    hands = flying(kept)
    hands.give(came.Command("abort"))
    for step in range(5):
        hands.give(pose(11.0 + step))
        hands.work_all()
    assert [each.end for each in hands.finished] == [out.End.SUCCEEDED]
    again = Hands(PARAMETERS, kept=kept)
    again.give(goal("one", stamp_s=10.0))
    assert again.accepted == []


def test_a_single_pose_far_off_is_left_out():
    hands = flying()
    hands.give(pose(10.02, (2000.0, 0.0, 2.0)))
    assert hands.errand.here.place_m.tolist() == [0.0, 0.0, 2.0]
    assert hands.errand.here.stamp_s == 10.02


def test_what_goes_on_after_a_flight_is_told_before_its_result():
    hands = Hands(ErrandParameters("test", "Nothing is flown.", rests=True))
    hands.give(pose(10.0))
    hands.work_all()
    hands.give(goal("one"))
    hands.work_all()
    hands.give(came.Command("abort"))
    for step in range(5):
        hands.give(pose(11.0 + step))
        hands.work_all()
    kinds = [type(each) for each in hands.outputs]
    end = kinds.index(out.Finish)
    assert hands.leader.rested_at_home
    assert out.Settled in kinds[end - 2 : end]


def test_without_a_pose_time_and_battery_count_and_who_cannot_come_home_is_told_to_land():
    hands = flying()
    hands.leader.until_s = 300.0
    for second in range(400):
        hands.give(came.Battery(10.0 + second, 0.9))
        hands.work_all()
    (finish,) = hands.finished
    assert hands.leader.end == "time"
    assert hands.leader.must_land
    assert finish.end is out.End.SUCCEEDED
    assert "cannot come home" in hands.leader.reason


def test_a_pose_that_comes_back_finds_the_time_that_has_passed_and_a_paused_clock_tells_none():
    hands = flying()
    for second in range(30):
        hands.give(came.Tick(5e8 + second))
        hands.give(came.Tick(5e8 + second))
    assert not hands.finished
    hands.give(pose(40.0))
    assert hands.errand.here.time_s == pytest.approx(40.0, abs=2.0)
    assert not [each for each in hands.told(out.Say) if "clock was set" in each.words]


@pytest.mark.table("content", ["yes", "no"])
def test_a_second_goal_that_comes_in_flight_keeps_the_home(content):
    hands = flying()
    hands.give(pose(10.1, (3.0, 0.0, 2.0)))
    hands.give(goal("two", content, 11.0))
    hands.give(came.Command("abort"))
    hands.work_all()
    assert hands.leader.home_m == [0.0, 0.0, 2.0]
    assert hands.leader.end == "aborted"


def test_a_decision_that_fails_brings_the_uav_home_and_one_that_fails_again_and_again_lands_it():
    hands = flying()
    hands.give(came.Looked(fault="It failed."))
    assert (hands.leader.end, hands.leader.must_land) == ("aborted", False)
    for _ in range(5):
        hands.give(came.Looked(fault="It failed."))
    assert hands.leader.must_land
    assert not hands.errand.is_active


def test_places_of_a_map_that_slam_has_begun_anew_are_not_flown_to():
    hands = Hands(PARAMETERS)
    hands.give(came.MapId("one"))
    hands.give(pose(10.0))
    hands.give(came.Battery(10.0, 0.9))
    hands.give(goal("one", stamp_s=10.0))
    hands.work_all()
    hands.give(came.MapId("one"))
    assert hands.errand.is_active
    hands.give(came.MapId("two"))
    hands.leader.setpoint = hands.leader.setpoint + 5.0
    hands.give(pose(11.0))
    assert [each.setpoint[0] for each in hands.told(out.Send) if each.setpoint is not None] == [0.0]
    (finish,) = hands.finished
    assert hands.leader.must_land
    assert "another map" in finish.words
    # A new goal has places of the new map
    hands.give(goal("two", stamp_s=11.0))
    hands.work_all()
    assert hands.errand.is_active


def test_a_flight_that_a_node_goes_on_with_after_a_restart_may_be_of_another_map():
    kept = Kept()
    before = flying(kept)
    before.give(came.MapId("one"))
    again = Hands(PARAMETERS, kept=kept)
    for message in (came.MapId("two"), pose(11.0), came.Battery(11.0, 0.9), goal("one", stamp_s=10.0)):
        again.give(message)
    again.work_all()
    assert again.leader.must_land
