"""A board and a turn by hand show a lidar that is mirrored or turned."""

import math

import numpy as np
import pytest

from doctor.preflight.by_hand import Answer, Odometry, View, board, carry, side_of, turn

NEAR_M = 0.5
CORNER = np.array([2.0, 5.0])
"""Half sizes of a room, m."""


def answer(bearing_deg, away=1.0, range_m=0.3):
    bearing = math.radians(bearing_deg)
    command = (-away * 0.4 * math.cos(bearing), -away * 0.4 * math.sin(bearing))
    return Answer(bearing, range_m, command)


def test_giving_way_is_passed_and_names_the_sides():
    verdict = board([answer(0)] * 5 + [answer(90)] * 5, NEAR_M)
    assert verdict.passed
    assert verdict.sentence == "CEPA gives way to a board ahead, to the left"


@pytest.mark.table(
    ("answers", "words"),
    [
        ([answer(0)] * 4, "nothing came nearer"),
        ([answer(0, range_m=0.8)] * 9, "nothing came nearer"),
        ([answer(-90, away=0.0)] * 9, "did not move away from a board 0.30 m to the right"),
        ([answer(90, away=-1.0)] * 9, "commands 0.4 m/s towards the board to the left"),
        ([answer(-90, away=-1.0)] * 9, "commands 0.4 m/s towards the board to the right"),
    ],
)
def test_a_wrong_answer_fails(answers, words):
    verdict = board(answers, NEAR_M)
    assert not verdict.passed
    assert words in verdict.sentence


@pytest.mark.table("side", [0, 90, 180, -90])
def test_no_side_is_outvoted_by_the_others(side):
    """A mirrored lidar answers well to a board ahead and behind."""
    others = [answer(bearing) for bearing in (0, 90, 180, -90) if bearing != side for _ in range(20)]
    towards = board(others + [answer(side, away=-1.0)] * 3, NEAR_M)
    assert not towards.passed
    assert f"commands 0.4 m/s towards the board {side_of(math.radians(side))}" in towards.sentence
    still = board(others + [answer(side, away=0.0)] * 3, NEAR_M)
    assert not still.passed
    assert f"did not move away from a board 0.30 m {side_of(math.radians(side))}" in still.sentence


def test_one_stray_command_of_a_side_is_noise():
    assert board([answer(0)] * 9 + [answer(0, away=-1.0)], NEAR_M).passed
    assert board([answer(0)] * 9 + [answer(90, away=-1.0)], NEAR_M).passed


@pytest.mark.table("number", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_no_number_is_no_answer(number):
    verdict = board([Answer(0.0, 0.3, (number, 0.0))] * 9, NEAR_M)
    assert not verdict.passed
    assert "did not move away from a board 0.30 m ahead" in verdict.sentence
    assert not board([Answer(0.0, number, (-0.4, 0.0))] * 9, NEAR_M).passed


def test_sides():
    assert [side_of(math.radians(angle)) for angle in (10, 80, 179, -179, -95)] == [
        "ahead",
        "to the left",
        "behind",
        "behind",
        "to the right",
    ]


def view(heading_deg, told_deg=None, mirrored=False):
    """What a UAV off the middle of a room sees, in closed form; told_deg: odometry's heading."""
    heading = math.radians(heading_deg)
    bearings = np.radians(np.arange(-135.0, 135.0, 0.5))
    x, y = np.cos(bearings + heading), np.sin(bearings + heading)
    place = np.array([0.7, -1.5])
    with np.errstate(divide="ignore"):
        to_walls = [
            np.where(along > 0, (size - at) / along, (-size - at) / along)
            for along, size, at in ((x, CORNER[0], place[0]), (y, CORNER[1], place[1]))
        ]
    ranges = np.minimum(*to_walls)
    told = math.radians(heading_deg if told_deg is None else told_deg)
    return View(-bearings if mirrored else bearings, ranges, told)


@pytest.mark.table("degrees", [60, -90, 150])
def test_a_turn_that_both_see_is_passed(degrees):
    assert turn(view(0), view(degrees)).passed
    assert turn(view(170), view(170 + degrees)).passed


def test_a_mirrored_lidar_a_wrong_heading_and_no_turn_fail():
    mirrored = turn(view(0, mirrored=True), view(90, mirrored=True))
    assert not mirrored.passed
    assert "turned by 90 degrees, the view by -90" in mirrored.sentence
    wrong = turn(view(0), view(90, told_deg=60))
    assert "turned by 60 degrees, the view by 90" in wrong.sentence
    assert "changed by 10 degrees only" in turn(view(0), view(10)).sentence


def test_a_round_or_empty_place_tells_nothing():
    bearings = np.radians(np.arange(-135.0, 135.0, 0.5))
    round_place = [View(bearings, np.full(len(bearings), 3.0), heading) for heading in (0.0, 1.5)]
    empty = [View(np.zeros(0), np.zeros(0), heading) for heading in (0.0, 1.5)]
    for views in (round_place, empty):
        assert "too little to compare" in turn(*views).sentence


def carried(told_of, legs=((1.2, 0.0), (0.0, 1.2)), heading_rad=math.pi / 2):
    """Odometry of a UAV that is carried for 3 s a leg (m/s ahead, left). told_of(body, world): its twist."""
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    place, found = np.zeros(3), []
    level = (0.0, 0.0, math.sin(heading_rad / 2), math.cos(heading_rad / 2))
    for k, (ahead, left) in enumerate(legs):
        world = np.array((c * ahead - s * left, s * ahead + c * left, 0.0))
        for at in range(100):
            place = place + 0.03 * world
            told = told_of(np.array((ahead, left, 0.0)), world)
            found.append(Odometry(30_000_000 * (100 * k + at), tuple(told), tuple(place), level, False))
    return found


def test_a_uav_that_is_carried_tells_the_axes_of_its_velocity():
    assert carry(carried(lambda body, world: body)).passed
    wrong = {
        "header.frame_id": lambda body, world: world,
        "FRD": lambda body, world: body * (1.0, -1.0, -1.0),
        "empty": lambda body, world: 0.0 * body,
    }
    for words, told_of in wrong.items():
        verdict = carry(carried(told_of))
        assert not verdict.passed
        assert words in verdict.sentence


@pytest.mark.table("way", [{"legs": ()}, {"legs": ((0.2, 0.0), (0.0, 0.2))}, {"heading_rad": 0.0}])
def test_a_way_that_does_not_tell_the_axes_is_not_passed(way):
    verdict = carry(carried(lambda body, world: body, **way))
    assert not verdict.passed
    assert "Carry the UAV" in verdict.remedy
