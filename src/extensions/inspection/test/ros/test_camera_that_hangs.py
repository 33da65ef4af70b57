"""A camera that hangs, or whose pictures never come, ends the survey. Nothing waits for it for ever."""

import json
import sys
from pathlib import Path

import pytest

pytest.importorskip("rosgraph", reason="needs ROS")
pytestmark = pytest.mark.ros


@pytest.fixture(scope="module")
def told(master_of_module):
    probe = Path(__file__).with_name("camera_probe.py")
    done = master_of_module.run(sys.executable, str(probe), timeout_s=90.0)
    assert done.returncode == 0, done.stdout
    return json.loads(next(line for line in done.stdout.splitlines() if line.startswith("{")))


@pytest.mark.parametrize(
    ("camera", "words"), [("hangs", "it gave no answer within"), ("blind", "picture did not come")]
)
def test_after_three_photographs_the_survey_ends_and_each_is_missed(told, camera, words):
    assert [number for number, _ in told[camera]["lost"]] == [1, 2, 3]
    assert all(words in why for _, why in told[camera]["lost"])
    ((end, reason),) = told[camera]["aborts"]
    assert end == "camera"
    assert "It was asked 3 times." in reason


def test_a_picture_that_comes_when_another_survey_is_flown_belongs_to_its_own(told):
    assert (told["late"]["first"], told["late"]["second"]) == ([1], [])
    assert told["late"]["shots"] == 0  # of the survey that is flown


def test_the_camera_is_told_what_is_asked_for_and_a_white_picture_is_taken_again(told):
    assert told["white"]["asked"] == [0.001, -0.5]
    ((number, lost, bias_ev),) = told["white"]["exposures"]
    assert (number, lost) == (2, 1.0)
    assert -4.5 < bias_ev < -2.4  # two stops below -0.5 EV at least


def test_what_is_still_open_holds_the_photograph_whose_picture_is_still_to_come(told):
    assert told["four"]["said"] == [
        "Photograph 1 is stored; still open: 3.",
        "Photograph 2 is stored; still open: 2.",
    ]


def test_nobody_waits_for_it_any_more(told):
    assert not any(each["waits"] for each in told.values())
