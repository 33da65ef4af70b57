"""Missions: which waypoint is flown to when, and the way home."""

import math

import pytest

from flight_basics.errors import MissionError, ParameterError, PoseError
from inspection_tools import Mission, Waypoint, way_home, way_m
from inspection_tools.mission.waypoints import headings_shown

A, B = Waypoint((1.0, 0.0, 2.0)), Waypoint((1.0, 5.0, 2.0), hold_s=2.0)


def test_flies_through_a_waypoint_and_holds_at_the_next():
    mission = Mission([A, B])
    first = mission.update(0.0, (0.0, 0.0, 2.0))
    assert (first.target, first.target_changed, first.reached, first.distance_m) == (A, True, 0, 1.0)
    assert not mission.update(0.1, (0.69, 0.0, 2.0)).target_changed  # 0.31 m away, tolerance 0.3 m
    through = mission.update(0.2, (0.71, 0.0, 2.0))
    assert (through.target, through.target_changed, through.reached, through.done) == (B, True, 1, False)
    for now_s in (2.0, 4.0, 6.0, 8.0):
        mission.update(now_s, (1.0, 3.0, 2.0))
    assert mission.update(10.0, (1.0, 4.8, 2.0)).holding_s == 0.0
    held = mission.update(11.9, (1.0, 5.1, 2.0))
    assert held.holding_s == pytest.approx(1.9)
    assert not held.done
    end = mission.update(12.0, (1.0, 5.1, 2.0))
    assert (end.done, end.reached, end.of, end.target) == (True, 2, 2, B)
    assert mission.done


def test_goes_on_after_the_waypoints_that_are_done_already():
    mission = Mission([A, B, A], reached=1)
    first = mission.update(0.0, (0.0, 0.0, 2.0))
    assert (first.target, first.target_changed, first.reached, first.of) == (B, True, 1, 3)
    with pytest.raises(MissionError, match="Of 2 waypoints 2 cannot be done already"):
        Mission([A, B], reached=2)


def test_stays_done_wherever_the_uav_goes():
    mission = Mission([A])
    assert mission.update(0.0, A.position_m).done
    later = mission.update(1.0, (50.0, 0.0, 0.0))
    assert (later.done, later.reached, later.target_changed) == (True, 1, False)


def test_who_leaves_before_the_time_begins_to_hold_anew():
    mission = Mission([B])
    mission.update(0.0, B.position_m)
    assert mission.update(1.5, (1.0, 5.4, 2.0)).holding_s == 0.0  # 0.4 m away
    mission.update(1.6, B.position_m)
    assert not mission.update(3.5, B.position_m).done
    assert mission.update(3.6, B.position_m).done


@pytest.mark.table("step_s", [-96.0, -0.4, 1.0, 600.0, 31_536_000.0])
def test_a_clock_that_is_set_changes_neither_hold_nor_patience(step_s):
    mission = Mission([A, B], patience_s=10.0)
    for now_s in range(9):
        assert not mission.update(now_s, (0.0, 0.0, 2.0)).stalled
    stamp_s = 8.0 + step_s
    assert not mission.update(stamp_s, (0.0, 0.0, 2.0)).stalled
    mission.update(stamp_s, A.position_m)
    assert mission.update(stamp_s + 0.5, B.position_m).holding_s == 0.0
    stamp_s += 0.5 + step_s
    held_s = mission.update(stamp_s, B.position_m).holding_s
    assert held_s == pytest.approx(1.0 if step_s == 1.0 else 0.0)  # a second may have passed
    stamp_s += 0.4 if step_s == -0.4 else 0.0  # until then the time stands still
    assert not mission.update(stamp_s + 1.0 - held_s, B.position_m).done
    assert mission.update(stamp_s + 2.0 - held_s + 1e-6, B.position_m).done


def test_a_waypoint_that_is_not_reached_stalls_the_mission():
    mission = Mission([A, B], patience_s=10.0)
    for now_s in range(9):
        assert not mission.update(now_s, (0.0, 0.0, 2.0)).stalled
    assert not mission.update(9.0, A.position_m).stalled
    for now_s in range(10, 20):
        assert not mission.update(now_s, (0.0, 0.0, 2.0)).stalled  # the next has its own time
    assert mission.update(19.1, (0.0, 0.0, 2.0)).stalled
    for now_s in (19.2, 20.0, 21.2):
        assert not mission.update(now_s, B.position_m).stalled
    for now_s in range(23, 40):
        assert not mission.update(now_s, (9.0, 9.0, 9.0)).stalled  # over is over


def test_a_long_leg_needs_no_longer_patience():
    mission = Mission([Waypoint((20.0, 0.0, 2.0))], patience_s=10.0, nearer_m=0.5)
    for now_s in range(31):  # 0.5 m/s: 15 m
        assert not mission.update(now_s, (0.5 * now_s, 0.0, 2.0)).stalled
    for now_s in range(31, 41):  # held up there, or creeping
        assert not mission.update(now_s, (15.0 + 0.04 * (now_s - 30), 0.0, 2.0)).stalled
    assert mission.update(40.1, (15.4, 0.0, 2.0)).stalled


def test_height_counts():
    assert not Mission([A]).update(0.0, (1.0, 0.0, 1.6)).done


def test_one_pose_does_one_waypoint_however_many_lie_there():
    mission = Mission([A, A, A])
    assert [mission.update(t, A.position_m).reached for t in (0.0, 0.1, 0.2)] == [1, 2, 3]


def test_a_pose_that_is_not_finite_is_refused_and_changes_nothing():
    mission = Mission([B])
    mission.update(0.0, B.position_m)
    for stamp, place in ((1.0, (math.nan, 0.0, 0.0)), (math.inf, B.position_m)):
        with pytest.raises(PoseError):
            mission.update(stamp, place)
    assert mission.update(2.0, B.position_m).done


def test_the_way_is_that_of_its_legs():
    assert way_m([Waypoint((3.0, 4.0, 0.0)), Waypoint((3.0, 4.0, 2.0))], (0.0, 0.0, 0.0)) == 7.0


def test_no_mission_is_no_mission():
    with pytest.raises(MissionError, match="no waypoints"):
        Mission([])
    with pytest.raises(ParameterError, match="yaw is inf"):
        Waypoint((0.0, 0.0, 0.0), yaw_rad=math.inf)


def test_an_arrow_at_each_waypoint_points_on_to_the_next():
    square = [Waypoint(place) for place in ((0, 0, 2), (4, 0, 2), (4, 3, 2), (0, 3, 2))]
    assert headings_shown(square) == pytest.approx([0.0, math.pi / 2, math.pi, math.pi])


def test_an_arrow_points_on_below_a_waypoint_and_has_the_yaw_that_is_set():
    climb = [
        Waypoint((0, 0, 1)),
        Waypoint((0, -2, 1)),
        Waypoint((0, -2, 3)),
        Waypoint((0, -4, 3), yaw_rad=1.0),
    ]
    assert headings_shown(climb) == pytest.approx([-math.pi / 2] * 3 + [1.0])
    assert headings_shown([Waypoint((1, 2, 3))]) == [0.0]
    lift = [Waypoint((0, 0, 1)), Waypoint((0, 0, 2)), Waypoint((-1, 0, 2))]
    assert headings_shown(lift) == pytest.approx([math.pi] * 3)


# Way home

AROUND = [Waypoint((x, y, 2.0)) for x, y in ((4, 0), (4, 4), (0, 4), (0, 0))]  # a square from (0, 0)


def places(waypoints):
    return [waypoint.position_m for waypoint in waypoints]


@pytest.mark.table(
    ("reached", "expected"),
    [
        (0, [(0, 0, 2)]),
        (1, [(4, 0, 2), (0, 0, 2)]),  # back: 4 m, on: 12 m
        (3, [(0, 0, 2)]),  # on: 4 m, back: 12 m
        (5, [(4, 0, 2), (0, 0, 2)]),  # in the second lap: not all the first one back
        (7, [(0, 0, 2)]),
    ],
)
def test_the_way_home_is_the_shorter_one_along_the_legs(reached, expected):
    home = way_home(2 * AROUND, reached, (0.0, 0.0, 0.0))
    assert places(home) == expected
    assert home[-1].tolerance_m == Waypoint.tolerance_m


def test_without_a_waypoint_at_the_start_the_way_home_is_the_whole_way():
    line = [Waypoint((x, 0.0, z)) for x, z in ((2.0, 1.5), (4.0, 2.0), (9.0, 2.5))]
    assert places(way_home(line, 2, (0.0, 0.0, 0.0))) == [(4.0, 0.0, 2.0), (2.0, 0.0, 1.5), (0.0, 0.0, 1.5)]


def test_on_the_way_home_the_uav_does_not_hold_but_keeps_tolerances():
    line = [Waypoint((x, 0.0, 2.0), tolerance_m=0.5, hold_s=60.0) for x in (2.0, 4.0)]
    home = way_home(line, 2, (0.0, 0.0))
    assert [(waypoint.hold_s, waypoint.tolerance_m) for waypoint in home] == [(0, 0.5), (0, 0.5), (0, 0.3)]


def test_a_waypoint_is_at_the_start_within_its_tolerance():
    line = [Waypoint((5.0, 0.0, 2.0)), Waypoint((0.4, 0.0, 2.0), tolerance_m=0.5), Waypoint((5.0, 0.0, 2.0))]
    assert places(way_home(line, 3, (0.0, 0.0))) == [(5.0, 0.0, 2.0), (0.0, 0.0, 2.0)]
    line[1] = Waypoint((0.4, 0.0, 2.0))
    assert places(way_home(line, 3, (0.0, 0.0)))[-2:] == [(5.0, 0.0, 2.0), (0.0, 0.0, 2.0)]
    assert len(way_home(line, 3, (0.0, 0.0))) == 4
