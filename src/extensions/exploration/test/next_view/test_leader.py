"""The exploration as the leader of an errand, flown without ROS: what people ask, and the way home."""

from collections import deque
from types import SimpleNamespace

import numpy as np
import pytest
from voxel_room import open_box

from exploration.energy import EnergyParameters, EnergyWatch, Readings
from exploration.next_view import ExplorationParameters, Explorer
from exploration.next_view.leader import ExplorationLeader
from flight_basics.errand import messages as came
from flight_basics.errand import outputs as out
from flight_basics.errand.begun import BegunGoal
from flight_basics.errand.errand import Errand
from flight_basics.errand.parameters import ErrandParameters

HOVER_M, FAR_M = np.array((1.0, 2.0, 3.0)), np.array((3.0, 2.0, 3.0))
PARAMETERS = ErrandParameters("exploration", "Nothing is being explored.", needs_battery=True)


class Kept:
    def __init__(self, values=()):
        self.values = dict(values)

    def keep(self, values):
        self.values = dict(values)


class Uav:
    """Is where the errand sends it, and does the worker's work at once."""

    def __init__(self, kept=None, place_m=HOVER_M):
        self.kept = kept or Kept()
        energy = EnergyWatch(EnergyParameters())
        parameters = ExplorationParameters(first_sink=0.0)
        self.leader = ExplorationLeader(open_box(), Explorer(), parameters, energy, {})
        self.errand = Errand(self.leader, BegunGoal(self.kept), PARAMETERS, None, Readings(), lambda: 0.0)
        self.place_m, self.stamp_s, self.charge = place_m, 100.0, 0.9
        self.ended = []

    def give(self, message):
        messages = deque([message])
        while messages:
            for output in self.errand.take(messages.popleft()):
                if isinstance(output, out.Send) and output.setpoint is not None:
                    self.place_m = output.setpoint
                elif isinstance(output, out.Finish):
                    self.ended.append(output)
                elif isinstance(output, out.Reply):
                    output.to.set_result(output.answer)
                elif isinstance(output, out.Prepare):
                    plan = self.leader.prepare(output.goal.content)
                    messages.append(came.Prepared(output.goal, plan))
                elif isinstance(output, out.Look):
                    messages.append(came.Looked(tuple(self.leader.look(output.here, output.readings))))

    def step(self, step_s=0.5):
        self.stamp_s += step_s
        self.give(came.Battery(self.stamp_s, self.charge))
        self.give(came.MapCame(self.stamp_s))
        self.give(came.Pose(self.stamp_s, self.place_m, more=0.01))

    def begin(self, name="one"):
        self.step()
        self.give(came.Goal(name, SimpleNamespace(time_max=0.0), name, self.stamp_s))
        assert self.errand.is_active

    def fly_home(self):
        for _ in range(40):
            self.step()
            if not self.errand.is_active:
                return
        pytest.fail("it did not come home")


def test_an_abort_brings_it_home_and_ends_the_goal_once():
    uav = Uav()
    uav.begin()
    uav.place_m = FAR_M
    uav.give(came.Command("abort"))
    uav.fly_home()
    (finish,) = uav.ended
    assert (finish.end, finish.words) == (
        out.End.SUCCEEDED,
        "Somebody ended the exploration by the service ~abort.",
    )
    assert np.allclose(uav.place_m, HOVER_M, atol=0.5)


def test_a_battery_at_its_reserve_brings_it_home():
    uav = Uav()
    uav.begin()
    uav.charge = 0.1
    uav.fly_home()
    assert uav.leader.end == "battery"


def test_a_node_that_died_in_flight_comes_home_to_the_same_place():
    uav = Uav()
    uav.begin()
    assert np.allclose(uav.kept.values["home"], HOVER_M)
    again = Uav(uav.kept, FAR_M)
    again.stamp_s = uav.stamp_s
    again.begin()
    again.give(came.Command("abort"))
    again.fly_home()
    assert np.allclose(again.place_m, HOVER_M, atol=0.5)
    assert again.kept.values["has_ended"]


def test_when_slam_begins_another_map_nothing_is_flown_in_it_and_the_next_goal_has_a_home_there():
    uav = Uav()
    uav.give(came.MapId("one"))
    uav.begin()
    uav.place_m = FAR_M
    uav.step()
    uav.give(came.MapId("one"))  # latched, so it may come twice
    assert uav.errand.is_active
    # When the map's frame is another one, then the UAV's place reads otherwise, and no old place is flown to
    uav.give(came.MapId("two"))
    (finish,) = uav.ended
    assert "another map" in finish.words
    assert uav.leader.outcome().must_land
    uav.place_m = elsewhere_m = np.array((2.5, 2.5, 2.0))
    for _ in range(5):
        uav.step()
        assert np.array_equal(uav.place_m, elsewhere_m)
    # And a node that is started again does not go on with the old goal in the new map
    again = Uav(uav.kept, elsewhere_m)
    again.stamp_s = uav.stamp_s
    again.give(came.MapId("two"))
    again.step()
    again.give(came.Goal("one", SimpleNamespace(time_max=0.0), "one", again.stamp_s))
    assert not again.errand.is_active
    again.begin("two")
    assert np.allclose(again.kept.values["home"], elsewhere_m)


def test_without_a_pose_it_hovers_and_lands_where_it_is_when_the_energy_says_come_home():
    uav = Uav()
    uav.begin()
    uav.place_m = FAR_M
    uav.step()
    for second in range(1000):
        uav.charge = 0.9 - second / 1000.0
        uav.give(came.Battery(uav.stamp_s + second, uav.charge))
        if not uav.errand.is_active:
            break
    (finish,) = uav.ended
    assert uav.leader.end == "battery"
    assert uav.leader.outcome().must_land
    assert "cannot come home" in finish.words
    assert uav.charge > 0.1
    assert np.allclose(uav.place_m, FAR_M)
