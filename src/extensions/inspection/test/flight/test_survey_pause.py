"""A pause holds until somebody ends it, and battery and time count whatever else there is."""

from dataclasses import replace

import numpy as np
import pytest
from inspecting_uav import HOME_M, QUICK, VIEWS, Uav, inspection
from voxel_room import PLANNER

from exploration.energy import EnergyParameters, EnergyWatch
from exploration.planning import PathPlanner
from inspection.flight import End, Inspection, PhotographQueue


def paused_while_it_plans(lead, uav):
    """Let somebody pause while the next way is being planned; return where the UAV is then."""
    plan = lead._planner.plan

    def plan_and_pause(*arguments):
        lead.pause(uav.place_m)
        return plan(*arguments)

    lead._planner.plan = plan_and_pause
    lead.look(uav.stamp_s + 1.0, uav.place_m)
    lead._planner.plan = plan
    return uav.place_m.copy()


def hover(lead, uav, place_m, seconds=30.0):
    """Fly for a while; the only setpoint is the place."""
    for _ in range(int(seconds / 0.1)):
        uav.step()
        assert lead.setpoint_m is not None
        assert np.allclose(lead.setpoint_m, place_m)
    assert not lead.is_home
    assert not uav.asked[3:]


def begun_to_come_home():
    lead = inspection()
    uav = Uav(lead)
    while len(uav.asked) < 2:
        uav.step()
    lead.come_home("enough", End.TIME)
    return lead, uav


def test_a_pause_while_the_way_home_is_planned_holds():
    lead, uav = begun_to_come_home()
    place_m = paused_while_it_plans(lead, uav)
    hover(lead, uav, place_m)
    lead.resume()
    uav.fly()
    assert lead.is_home


def test_a_pause_while_the_way_to_a_photograph_is_planned_holds():
    lead = inspection()
    uav = Uav(lead)
    hover(lead, uav, paused_while_it_plans(lead, uav))


@pytest.mark.table("end", [End.TIME, End.CAMERA, End.STORAGE])
def test_what_ends_a_survey_does_not_end_a_pause(end):
    # Given a UAV that hovers by a pause; when its camera fails, or its time is over
    lead = inspection(parameters=replace(QUICK, time_max=10.0 if end is End.TIME else 1000.0))
    uav = Uav(lead)
    for _ in range(12):
        uav.step()
    lead.pause(uav.place_m)
    if end is not End.TIME:
        lead.come_home("It failed.", end)
    # Then it hovers on, and comes home after the pause
    hover(lead, uav, uav.place_m.copy())
    assert lead.end is end
    lead.resume()
    uav.fly()
    assert lead.is_home


def test_an_abort_ends_a_pause_on_the_way_home():
    lead, uav = begun_to_come_home()
    lead.pause(uav.place_m)
    lead.abort("enough")
    assert not lead.is_paused
    uav.fly()
    assert lead.is_home


def test_a_pause_ends_when_the_energy_begins_to_say_come_home():
    watch = EnergyWatch(EnergyParameters(endurance=200.0, landing_time=1.0, reserve=0.5))
    lead = inspection(energy=watch)
    uav = Uav(lead)
    watch.offer(0.0, 1.0)
    uav.step()
    lead.come_home("enough", End.TIME)
    lead.pause(uav.place_m)
    for _ in range(3000):
        uav.step()
        watch.offer(uav.stamp_s, max(1.0 - uav.stamp_s / 200.0, 0.0))
        if lead.is_home or lead.must_land:
            break
    assert lead.is_home
    assert not lead.must_land


@pytest.mark.table("drain", [0.0, 0.01])
def test_without_a_map_battery_and_time_count(drain):
    watch = EnergyWatch(EnergyParameters(endurance=100.0, landing_time=1.0, reserve=0.5))
    quick = replace(QUICK, time_max=1000.0 if drain else 20.0)
    lead = Inspection(PathPlanner(PLANNER), PhotographQueue(VIEWS, (), 2), quick, watch)
    lead.begin(0.0, HOME_M)
    uav = Uav(lead)
    while not lead.is_home and uav.stamp_s < 200.0:
        watch.offer(uav.stamp_s, 1.0 - drain * uav.stamp_s)
        uav.step()
    assert lead.end is (End.BATTERY if drain else End.TIME)
    assert uav.stamp_s < 80.0


def test_a_closer_look_after_a_pause_keeps_what_cepa_refused():
    # Given a place that CEPA has refused, and a UAV that goes on after a pause
    lead = inspection()
    uav = Uav(lead)
    for _ in range(20):
        uav.step()
    refused_m = np.array((3.0, 2.0, 1.0))
    lead._planner.close(refused_m, uav.stamp_s)
    lead.pause(uav.place_m)
    lead.resume()
    # When somebody asks for a closer look
    lead.look_closer(np.array((6.0, 1.0, 1.0)), uav.place_m, 0.8)
    # Then the place is still closed
    assert [closure.place_m for closure in lead._planner._closures.at(uav.stamp_s)] == [tuple(refused_m)]


def test_a_uav_that_is_a_kilometre_off_the_map_does_not_end_the_survey_in_an_error():
    lead = inspection()
    lead.look(1.0, np.add(HOME_M, (1000.0, 0.0, 0.0)))
    uav = Uav(lead, HOME_M)
    uav.stamp_s = 2.0
    uav.fly()
    assert lead.queue.done == {1, 2, 3}
