"""The threads of an errand: a person gets an answer while the worker decides, and nobody waits for ever."""

import queue
import threading

import pytest
from errand_model import Away, Kept, pose

from flight_basics.errand import errand_thread
from flight_basics.errand import messages as came
from flight_basics.errand import outputs as out
from flight_basics.errand.begun import BegunGoal
from flight_basics.errand.errand import Errand
from flight_basics.errand.errand_thread import ErrandThread
from flight_basics.errand.parameters import ErrandParameters
from flight_basics.errors import FlightBasicsError

PATIENCE_S = 60.0


class Slow(Away):
    """Its looks take as long as the test wants."""

    def __init__(self):
        super().__init__()
        self.looks, self.may_end = threading.Event(), threading.Event()

    def look(self, here, readings):
        self.looks.set()
        assert self.may_end.wait(PATIENCE_S)
        return super().look(here, readings)


@pytest.fixture
def flight():
    """An errand whose worker is deciding."""
    leader, outputs, errors = Slow(), queue.SimpleQueue(), []
    errand = Errand(leader, BegunGoal(Kept()), ErrandParameters("test", "Nothing is flown."))
    thread = ErrandThread(errand, leader, outputs.put, errors.append)
    thread.leader, thread.outputs = leader, outputs
    thread.start()
    thread.put(pose(1.0))
    thread.put(came.Goal("one", "yes", "one"))
    thread.put(pose(1.02))
    while not isinstance(outputs.get(timeout=PATIENCE_S), out.Send):
        thread.put(pose(1.04))
    assert leader.looks.wait(PATIENCE_S)
    yield thread
    leader.may_end.set()
    assert thread.close(PATIENCE_S)
    assert errors == []


def test_a_person_is_answered_and_obeyed_while_the_worker_decides(flight):
    assert flight.ask(came.Command("pause")) == (True, "The UAV hovers.")
    assert flight.leader.is_paused
    assert flight.ask(came.Command("resume")) == (True, "The test goes on.")


def test_a_question_that_is_not_answered_in_time_is_told_so_and_dropped(flight, monkeypatch):
    monkeypatch.setattr(errand_thread, "LONG_ANSWER_S", 0.1)
    question = came.Question(lambda here_m: 1.0)
    assert flight.ask(question) == (False, "There was no answer within 0 s. Ask again.")
    flight.leader.may_end.set()
    assert flight.ask(came.Command("pause")).success  # the worker's late answer does no harm


def test_a_question_that_makes_no_sense_is_answered_with_its_sentence(flight):
    def answer(_):
        raise FlightBasicsError("There is no map.")

    flight.leader.may_end.set()
    assert flight.ask(came.Question(answer)) == (False, "There is no map.")


class Broken(Away):
    """Whatever it does in the worker raises what nobody expects."""

    def prepare(self, content):
        if content == "broken":
            raise KeyError("why")
        return content

    def look(self, here, readings):
        raise ZeroDivisionError


def test_what_the_worker_raises_refuses_a_goal_or_ends_a_flight_and_the_node_flies_on():
    outputs, errors, faults, leader = queue.SimpleQueue(), [], queue.SimpleQueue(), Broken()
    errand = Errand(leader, BegunGoal(Kept()), ErrandParameters("test", "Nothing is flown."))
    thread = ErrandThread(errand, leader, outputs.put, errors.append, faults.put)
    thread.start()
    thread.put(pose(1.0))

    def finished():
        while not isinstance(output := outputs.get(timeout=PATIENCE_S), out.Finish):
            thread.put(pose(1.0))
        return output

    thread.put(came.Goal("one", "broken", "one"))
    assert finished().end is out.End.ABORTED
    assert isinstance(faults.get(timeout=PATIENCE_S), KeyError)
    thread.put(came.Goal("two", "yes", "two"))
    assert finished().end is out.End.SUCCEEDED
    assert leader.must_land
    assert thread.close(PATIENCE_S)
    assert errors == []


def test_what_a_thread_raises_is_told():
    errors, leader = queue.SimpleQueue(), Away()
    errand = Errand(leader, BegunGoal(Kept()), ErrandParameters("test", "Nothing is flown."))
    thread = ErrandThread(errand, leader, lambda _: None, errors.put)
    thread.start()
    thread.put("no message")
    assert isinstance(errors.get(timeout=PATIENCE_S), KeyError)
