"""A survey as the leader of an errand: when it ends, and what it answers."""

from types import SimpleNamespace

import numpy as np
import pytest

from flight_basics.errand.leader import Here
from inspection.flight.leader import NO_SURVEY, Survey, SurveyLeader, SurveyPose
from inspection.flight.motion import Motion
from inspection.flight.photograph_records import StampedPose


class Camera:
    """A photographer whose picture comes when the test wants it."""

    is_shooting = waits = is_hurried = False

    def __init__(self):
        self.taken, self.noted = [], []

    def begin(self, inspection, album):
        self.taken.clear()

    def take(self, task, stamp_s):
        self.taken.append((task, stamp_s))

    def hurry(self):
        self.is_hurried = True

    def note(self, pose, in_odom):
        self.noted.append(pose)


class Lead:
    """An inspection that has ended at home."""

    is_home, must_land, reason, is_paused, setpoint_m = True, False, "Done.", False, None
    end = SimpleNamespace(value="done")
    home_m = np.array((1.0, 2.0, 3.0))
    queue = SimpleNamespace(open=[1, 2])

    def begin(self, *arguments, **named):
        self.began = arguments, named

    def follow(self, motion):
        self.motion = motion
        return True

    def shutter(self, motion):
        return "task"


def here(stamp_s=7.0):
    motion = Motion(float("nan"), np.zeros(3), 0.5)
    more = SurveyPose(motion, StampedPose(stamp_s, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)), None)
    return Here(5.0, stamp_s, np.zeros(3), more, deviation_m=0.3)


@pytest.fixture
def leader():
    goals = SimpleNamespace(album="album", plan=None, second_look=None, abort=lambda: True)
    leader = SurveyLeader(goals, Camera(), SimpleNamespace(has_map=True), None, 1.0)
    leader.begin(Survey(Lead(), 60.0), here(), None)
    return leader


def test_it_ends_when_every_picture_has_come(leader):
    leader._photographer.waits = True
    assert leader.outcome() is None
    assert leader._photographer.is_hurried
    leader._photographer.waits = False
    assert leader.outcome().words == "Done."


def test_where_it_must_land_it_waits_for_no_picture(leader):
    leader._photographer.waits, leader.inspection.must_land = True, True
    assert leader.outcome().must_land


def test_it_keeps_home_and_begin_and_a_node_that_died_begins_with_them(leader):
    assert leader.kept == {"home": [1.0, 2.0, 3.0], "began": 7.0}
    leader.begin(Survey(Lead(), 60.0), here(9.0), {**leader.kept, "goal": "one"})
    began_s, _, home_m, time_max_s = leader.inspection.began[0]
    assert home_m.tolist() == [1.0, 2.0, 3.0]
    assert here(9.0).time_s - began_s == 2.0  # its clock differs from that of the stamps
    assert time_max_s == 60.0
    assert leader.kept == {"home": [1.0, 2.0, 3.0], "began": 7.0}


def test_the_shutter_opens_at_the_stamp_of_the_message_and_the_way_is_followed_by_steady_time(leader):
    assert leader.follow(here())
    assert leader._photographer.taken == [("task", 7.0)]
    assert leader.inspection.motion.time_s == 5.0


def test_the_records_know_how_far_the_place_may_be_off(leader):
    leader.note(here())
    assert [each.deviation_m for each in leader._photographer.noted] == [0.3]


def test_a_survey_that_has_ended_looks_no_closer(leader):
    assert leader.look_closer(np.zeros(3), np.zeros(3)) == (False, NO_SURVEY)


def test_an_abort_on_the_ground_ends_the_search(leader):
    assert "are not searched any more" in leader.stop_waiting()
    leader._goals.abort = lambda: False
    assert leader.stop_waiting() == ""
