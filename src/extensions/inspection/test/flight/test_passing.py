"""In passing the UAV flies through the places of photographs; where it cannot, it comes to rest as ever."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from inspecting_uav import BLURRED, QUICK, VIEWS, Uav, inspection

from inspection.camera.survey_camera import SurveyCamera
from inspection.flight import InspectionParameters
from inspection.flight.legs.passing import AHEAD_S, TURN_PER_M, Passing, overshoot
from inspection.flight.motion import Motion
from inspection.flight.places import body_place_m
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan import SurveyPlan
from inspection.survey.views.candidates import View

PASSING = replace(QUICK, passing_speed=1.0, exposure=2e-4)
OFFSET_M = np.array((QUICK.camera_x, QUICK.camera_y, QUICK.camera_z))
ROW = tuple(View((x, 1.0, 1.0), 0.0, 0.0) for x in (2.0, 3.0, 4.0))
AHEAD = np.array((0.0, 1.0, 0.0))
NEAR_M, TURNED_RAD = 0.15, math.radians(1.5)


def test_the_aim_lies_straight_ahead_on_the_way():
    way = np.array(((0.0, 0.0, 1.0), (3.0, 0.0, 1.0), (3.0, 4.0, 1.0), (3.0, 4.0, 1.0)))
    np.testing.assert_allclose(overshoot(way, 0.5), (3.0, 4.0 + 0.5 * AHEAD_S, 1.0))
    assert overshoot(way[-2:], 0.5) is None
    assert overshoot(way[:1], 0.5) is None


@given(
    place=st.tuples(*[st.floats(-50.0, 50.0)] * 3),
    here=st.tuples(*[st.floats(-5.0, 5.0)] * 3),
    yaw=st.floats(-4.0, 4.0),
    off=st.floats(-4.0, 4.0),
)
def test_it_goes_on_only_before_the_place_and_with_its_front_nearly_there(place, here, yaw, off):
    place_m = np.array(place)
    passing = Passing(place_m, place_m + 0.3 * AHEAD, yaw, NEAR_M, TURNED_RAD)
    left_m, turn = -float(AHEAD @ here), abs(math.remainder(off, 2.0 * math.pi))
    may = TURNED_RAD + TURN_PER_M * max(left_m, 0.0)
    if min(abs(left_m + NEAR_M), abs(turn - may)) > 1e-6:
        assert passing.goes_on(Motion(0.0, place_m + here, yaw + off)) == (left_m > -NEAR_M and turn < may)


def flown(views, parameters, **faults):
    uav = Uav(inspection(views, parameters=parameters, **faults))
    setpoints = []
    while len(uav.asked) < len(views) and uav.stamp_s < 60.0:
        uav.step()
        setpoints.append(uav.inspection.setpoint_m)
    return uav, setpoints


def test_photographs_are_taken_at_their_places_without_a_stop():
    uav, setpoints = flown(ROW, PASSING)
    rested, rested_setpoints = flown(ROW, QUICK)
    assert [task.number for task in uav.asked] == [task.number for task in rested.asked] == [1, 2, 3]
    assert np.linalg.norm(uav.shot_m - body_place_m(ROW[-1], OFFSET_M)) <= QUICK.near
    last_m = body_place_m(ROW[-1], OFFSET_M)
    assert max(place_m[0] for place_m in setpoints) == pytest.approx(last_m[0] + AHEAD_S)
    assert max(place_m[0] for place_m in rested_setpoints) == pytest.approx(last_m[0])
    assert uav.stamp_s < rested.stamp_s


def test_in_a_pause_it_stays_where_it_is():
    uav = Uav(inspection(ROW[:1], parameters=PASSING))
    lead, end_m = uav.inspection, body_place_m(ROW[0], OFFSET_M)
    while lead.setpoint_m is None or lead.setpoint_m[0] <= end_m[0] + 0.1:  # it aims behind the place
        uav.step()
    lead.pause(uav.place_m)
    np.testing.assert_array_equal(lead.setpoint_m, uav.place_m)


def test_a_photograph_that_failed_in_passing_is_taken_at_rest():
    uav = Uav(inspection(ROW[:1], parameters=PASSING))
    uav.faults[1] = BLURRED
    while not uav.asked:
        uav.step()
    del uav.faults[1]
    while len(uav.asked) < 2:
        uav.step()
        assert uav.inspection.setpoint_m[0] <= body_place_m(ROW[0], OFFSET_M)[0] + 1e-9
    assert uav.inspection.queue.done == {1}


def test_before_a_wall_and_for_a_closer_look_it_comes_to_rest():
    end_m = body_place_m(ROW[-1], OFFSET_M)
    _, setpoints = flown(ROW, PASSING, walls=[((4.4, 0.0, 0.0), (4.8, 4.0, 3.0))])
    assert max(place_m[0] for place_m in setpoints) == pytest.approx(end_m[0])
    lead = inspection((), parameters=PASSING)
    lead.awaits = True
    lead.look_again(ROW[-1:])
    uav = Uav(lead)
    while not uav.asked:
        uav.step()
        assert lead.setpoint_m is None or lead.setpoint_m[0] <= end_m[0] + 1e-9
    assert uav.asked[0].number < 0


def test_where_its_front_must_still_turn_it_waits_at_the_place():
    uav, _ = flown(VIEWS, PASSING)
    assert [task.number for task in uav.asked] == [1, 2, 3]
    turn = math.remainder(uav.yaw_rad - VIEWS[-1].yaw_rad, 2.0 * math.pi)
    assert abs(turn) <= math.radians(QUICK.turned)


@pytest.mark.table(("asked_m_s", "exposure_s", "flown_m_s"), [(0.5, 5e-4, 0.5), (0.5, 2e-3, 0.2)])
def test_it_passes_at_most_as_fast_as_the_blur_allows(asked_m_s, exposure_s, flown_m_s):
    """0.8 of half a pixel of 1 mm may blur."""
    flying = FlightParameters(passing=True, passing_speed=asked_m_s)
    camera = SurveyCamera(exposure=exposure_s)
    plan = SurveyPlan("", (0.0, 0.0, 1.0), camera, SurveyParameters(resolution=1.0), flying, ())
    assert InspectionParameters().for_plan(plan).passing_speed == pytest.approx(flown_m_s)
    assert InspectionParameters(speed=0.1).for_plan(plan).passing_speed == 0.1
    hovering = replace(plan, flying=FlightParameters())
    assert InspectionParameters().for_plan(hovering).passing_speed == 0.0
