"""What stays open, and cracks from nearer, are photographed in the same flight."""

from dataclasses import replace

import numpy as np
import pytest
from inspecting_uav import (
    HOME_M,
    QUICK,
    VIEWS,
    Uav,
    inspection,
)

from exploration.energy import EnergyParameters, EnergyWatch
from inspection.findings.background import Answer
from inspection.flight import End
from inspection.flight.second_look import SearchState, SecondLook
from inspection.survey.views.candidates import View


class Search:
    """It answers some steps after it was asked. open_: views in its answers before the last."""

    def __init__(self, views, patience, open_=()):
        self.answers = [Answer(each, "Some is open.", False) for each in open_]
        self.answers.append(Answer(views, "Two cracks.", True))
        self.patience, self.patient, self.waits = patience, patience, False
        self.added, self.asked, self.closed, self.left_out = [], 0, 0, []

    def add(self, photograph):
        self.added.append(photograph)

    def ask(self, left_out):
        self.asked, self.waits, self.patient = self.asked + 1, True, self.patience
        self.left_out.append(left_out)

    def close(self):
        self.closed += 1

    def take_answer(self):
        self.patient -= self.waits
        if not self.waits or self.patient >= 0:
            return None
        self.waits = False
        return self.answers.pop(0)


def fly_second_look(search, steps=4000):
    """Fly with a second look. Return the inspection, the numbers asked, and all phases of waiting at home."""
    lead = inspection(VIEWS[:2], parameters=replace(QUICK, search_hover=100.0))
    second, uav, at_home = SecondLook(lead, search), Uav(lead), 0
    for _ in range(steps):
        second.look(waits=False)
        uav.step()
        at_home += lead.is_waiting and float(np.linalg.norm(uav.place_m - HOME_M)) < 2 * QUICK.arrived
        if lead.is_home:
            break
    return lead, [task.number for task in uav.asked], at_home


def test_the_second_look_follows_the_survey_in_the_same_flight():
    search = Search((VIEWS[2], VIEWS[0]), patience=3)
    lead, numbers, at_home = fly_second_look(search)
    assert numbers == [1, 2, -1, -2]
    assert (lead.end, lead.is_home, lead.queue.done) == (End.DONE, True, {1, 2, -1, -2})
    assert (search.asked, search.closed, at_home) == (1, 1, 0)
    assert lead.reason == "Every photograph of the plan is taken. 2 more are taken from nearer."


def test_what_stays_open_is_photographed_before_the_nearer_ones_and_the_search_is_asked_again():
    search = Search((VIEWS[0],), patience=3, open_=[(VIEWS[2],), (VIEWS[1],)])
    lead, numbers, _ = fly_second_look(search)
    assert numbers == [1, 2, 3, 4, -1]
    assert [task.view for task in lead.queue.tasks] == [*VIEWS[:2], VIEWS[2], VIEWS[1]]
    assert (search.asked, search.closed, lead.end) == (3, 1, End.DONE)
    assert lead.queue.done == {1, 2, 3, 4, -1}


def test_the_search_is_told_what_could_not_be_taken():
    search = Search((), patience=3)
    beyond = View((30.0, 1.0, 1.0), 0.0, 0.0)
    lead = inspection([VIEWS[0], beyond], parameters=replace(QUICK, wait=0.5))
    second, uav = SecondLook(lead, search), Uav(lead)
    while not lead.is_home and uav.stamp_s < 120.0:
        second.look(waits=False)
        uav.step()
    assert search.left_out == [[beyond]]


def test_a_uav_waits_at_home_for_a_slow_search_and_ends_if_nothing_is_found():
    search = Search((), patience=400)
    lead, numbers, at_home = fly_second_look(search)
    assert numbers == [1, 2]
    assert at_home > 100  # of 40 s it flies home in some 6 s
    assert (lead.end, lead.is_home, search.closed) == (End.DONE, True, 1)


def test_while_a_search_takes_long_the_uav_lands_and_goes_on_with_the_answer():
    search = Search((VIEWS[2],), patience=10**6)
    lead = inspection(VIEWS[:1], parameters=replace(QUICK, search_hover=5.0))
    second, uav = SecondLook(lead, search), Uav(lead)
    second.look(waits=False)
    assert second.state is SearchState.IDLE
    at_home_s = None
    while not lead.is_home:
        second.look(waits=False)
        uav.step()
        if at_home_s is None and lead.is_waiting and np.linalg.norm(uav.place_m - HOME_M) < 2 * QUICK.arrived:
            at_home_s = uav.stamp_s
    assert (lead.end, second.state) == (End.SEARCHING, SearchState.SEARCHING)
    assert uav.stamp_s - at_home_s == pytest.approx(5.0, abs=2 * QUICK.look_period)
    search.patient = 0
    assert second.look(waits=False) == "Two cracks."
    assert second.state is SearchState.IDLE
    lead.begin(uav.stamp_s, uav.place_m)
    uav.fly()
    assert [task.number for task in uav.asked] == [1, -1]
    assert (lead.end, lead.is_home) == (End.DONE, True)


def test_a_uav_that_has_landed_for_the_search_need_not_take_off_if_nothing_is_found():
    """A second battery and a flight of no photographs would follow."""
    search = Search((), patience=10**6)
    watch = EnergyWatch(EnergyParameters(endurance=60.0, landing_time=1.0, reserve=0.5))
    lead = inspection(VIEWS[:1], parameters=replace(QUICK, search_hover=1000.0), energy=watch)
    second, uav = SecondLook(lead, search), Uav(lead, drain=1.0 / 60.0)
    while not lead.is_home and uav.stamp_s < 60.0:
        watch.offer(uav.stamp_s, uav.charge)
        second.look(waits=False)
        uav.step()
    # The battery ends the wait, but no photograph needs another one yet
    assert ([task.number for task in uav.asked], lead.end) == ([1], End.SEARCHING)
    assert second.state is SearchState.SEARCHING
    search.patient = 0
    second.look(waits=False)
    assert second.state is SearchState.DONE


def test_an_abort_while_the_search_is_awaited_ends_at_home():
    lead = inspection(VIEWS[:1])
    second, uav = SecondLook(lead, Search((), patience=10**6)), Uav(lead)
    while not lead.is_waiting:
        second.look(waits=False)
        uav.step()
    lead.abort("It was aborted.")
    uav.fly()
    assert (lead.end, lead.is_home) == (End.ABORTED, True)


def test_an_aborted_search_is_ended_once_and_its_answer_does_not_count():
    search = Search((VIEWS[2],), patience=10**6)
    lead = inspection(VIEWS[:1], parameters=replace(QUICK, search_hover=5.0))
    second, uav = SecondLook(lead, search), Uav(lead)
    while not lead.is_home:
        second.look(waits=False)
        uav.step()
    second.abort()
    search.patient = 0
    assert [second.look(waits=False), second.look(waits=False)] == ["", ""]
    second.close()
    assert (second.state, search.closed, lead.awaits) == (SearchState.ABORTED, 1, False)
    assert lead.queue.next is None


def test_photographs_are_searched_until_the_search_has_answered_for_the_last_time():
    lead = inspection(VIEWS[:1])
    search = Search((), patience=10**6)
    second = SecondLook(lead, search)
    second.stored("one")
    Uav(lead).fly(5.0)
    second.look(waits=True)
    assert search.asked == 0  # a picture is still to come
    lead.queue.note_done(lead.queue.tasks[0])
    second.look(waits=False)
    second.stored("late")
    assert (search.asked, search.added) == (1, ["one", "late"])
    search.patient = 0
    second.look(waits=False)
    second.stored("later")
    assert (search.closed, search.added) == (1, ["one", "late"])


def test_the_first_photographs_of_a_draft_are_taken_while_the_others_are_planned():
    search = Search((VIEWS[0],), patience=3, open_=[(VIEWS[2],)])
    search.waits, search.patient = True, 30  # its first answer comes unasked, 3 s after the start
    lead = inspection(VIEWS[:2])
    second, uav = SecondLook(lead, search, is_draft=True), Uav(lead)
    states = []
    while not lead.is_home and uav.stamp_s < 300.0:
        second.look(waits=False)
        uav.step()
        states.append(second.state)
    assert [task.number for task in uav.asked] == [1, 2, 3, -1]
    assert (search.asked, search.closed, lead.end) == (1, 1, End.DONE)
    assert states[:30] == [SearchState.IDLE] * 30


def test_a_uav_that_has_taken_a_draft_s_photographs_lands_until_the_others_are_planned():
    search = Search((), patience=3, open_=[(VIEWS[2],)])
    search.waits, search.patient = True, 10**6
    lead = inspection(VIEWS[:1], parameters=replace(QUICK, search_hover=5.0))
    second, uav = SecondLook(lead, search, is_draft=True), Uav(lead)
    while not lead.is_home:
        second.look(waits=False)
        uav.step()
    assert (lead.end, second.state, search.asked) == (End.SEARCHING, SearchState.SEARCHING, 0)
    search.patient = 0
    assert second.look(waits=False) == "Some is open."
    assert second.state is SearchState.IDLE
    lead.begin(uav.stamp_s, uav.place_m)
    while not lead.is_home and uav.stamp_s < 300.0:
        second.look(waits=False)
        uav.step()
    assert [task.number for task in uav.asked] == [1, 2]
    assert (search.asked, lead.end) == (1, End.DONE)


def test_a_survey_whose_planner_dies_takes_what_it_has_and_says_that_its_plan_is_not_complete():
    search = Search((), patience=3)
    search.waits, search.patient = True, 30
    lead = inspection(VIEWS[:2])
    second, uav = SecondLook(lead, search, is_draft=True), Uav(lead)
    while not lead.is_home and uav.stamp_s < 300.0:
        second.look(waits=False)
        uav.step()
    assert (lead.end, lead.reason) == (End.ABORTED, "The plan is not complete. Two cracks.")
    assert (lead.queue.done, search.closed) == ({1, 2}, 1)
