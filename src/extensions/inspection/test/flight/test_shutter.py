"""The shutter opens where the camera is still enough, and a photograph that its motion blurs is refused."""

import math
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

from inspection.camera.survey_camera import SurveyCamera
from inspection.flight import InspectionParameters, PhotographQuality, Task
from inspection.flight.legs.leg import PhotographLeg
from inspection.flight.motion import Motion
from inspection.flight.places import body_place_m
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan import SurveyPlan

SLOW = InspectionParameters(exposure=0.002)
STILL_M_S = 0.2
"""0.8 of the blur that is allowed, 0.5 mm in 2 ms."""


def test_the_shutter_opens_where_the_camera_is_at_its_place_and_at_rest():
    lead = inspection(VIEWS[1:2])
    uav = Uav(lead)
    while not uav.asked:
        uav.step()
    offset = np.array((QUICK.camera_x, QUICK.camera_y, QUICK.camera_z))
    assert np.linalg.norm(uav.place_m - body_place_m(VIEWS[1], offset)) <= QUICK.near
    assert abs(math.remainder(uav.yaw_rad - VIEWS[1].yaw_rad, math.tau)) <= math.radians(QUICK.turned)
    assert lead.tilt_rad == VIEWS[1].tilt_rad
    # When the UAV is there, the camera is: its offset turned by a quarter points along y
    np.testing.assert_allclose(body_place_m(VIEWS[1], np.array((0.1, 0.0, -0.05))), (5.0, 0.9, 2.05))


@pytest.mark.table(
    ("shift_mm", "turn_mrad", "is_closer", "is_good"),
    [
        (0.49, 0.0, False, True),
        (0.51, 0.0, False, False),
        (0.0, 0.124, False, True),
        (0.0, 0.126, False, False),
        (0.3, 0.06, False, False),
        (0.14, 0.0, True, True),
        (0.16, 0.0, True, False),
        (0.0, 0.124, True, True),
        (math.nan, 0.0, False, False),
    ],
)
def test_blur_counts_on_the_surface_as_far_away_as_the_detail_is_drawn(
    shift_mm, turn_mrad, is_closer, is_good
):
    """1 mm per pixel is drawn up to 4 m, 0.3 mm up to 1.2 m; half of it may blur, however many px that is."""
    asked = InspectionParameters(blur_max=0.5, closer=0.3, detail=1.0, reach=4.0)
    shot = PhotographQuality(9.0, 100.0, 800.0, 0.0, 1e-3 * shift_mm, 1e-3 * turn_mrad)
    assert (shot.fault(asked, is_closer) == "") == is_good


def test_after_a_failure_the_uav_rests_more_before_the_shutter_opens():
    task, p = Task(1, VIEWS[0]), SLOW
    place_m = np.array((1.0, 2.0, 3.0))

    def shoots(failures, speed):
        leg = PhotographLeg(task, place_m, 0.0, 0.0, 0.0, p, failures)
        for stamp_s in np.arange(0.0, p.settle + 0.5, 0.1):
            motion = Motion(stamp_s, place_m, VIEWS[0].yaw_rad, speed)
            leg.follow(motion)
            if leg.opens_shutter(motion):
                return True
        return False

    assert shoots(0, 0.9 * STILL_M_S)
    assert not shoots(1, 0.9 * STILL_M_S)
    assert shoots(1, 0.6 * STILL_M_S)
    assert not shoots(2, 0.6 * STILL_M_S)


def test_motion_and_turn_add_up_before_the_shutter_opens():
    p = SLOW

    def shoots(speed, turn):
        leg = PhotographLeg(Task(1, VIEWS[0]), HOME_M, 0.0, 0.0, 0.0, p)
        motions = [
            Motion(0.1 * k, HOME_M, VIEWS[0].yaw_rad, speed * STILL_M_S, turn * STILL_M_S / p.reach)
            for k in range(9)
        ]
        return any(leg.follow(each) == "" and leg.opens_shutter(each) for each in motions)

    assert shoots(0.95, 0.0)
    assert shoots(0.0, -0.95)
    assert shoots(0.45, 0.45)
    assert not shoots(0.6, 0.6)


def test_where_rest_comes_and_goes_the_shutter_opens_at_the_first_of_it():
    lead = inspection(VIEWS[:1], parameters=SLOW)
    p = SLOW
    motion = Motion(0.0, body_place_m(VIEWS[0], np.array((p.camera_x, 0.0, 0.15))), 0.0)  # 0.2 m too low
    lead.look(0.0, HOME_M)
    shots_s = []
    for step in range(80):
        moved = replace(motion, time_s=0.1 * step, speed=0.05 if step % 12 == 0 else 0.4)
        lead.follow(moved)
        if lead.shutter(moved) is not None:
            shots_s.append(0.1 * step)
    assert shots_s == [pytest.approx(3.6)]  # at rest at 0, 1.2, 2.4, 3.6 s ..., and calm is 2.5 s


def test_a_uav_that_is_kept_off_a_little_shoots_where_it_comes_to_rest():
    lead = inspection(VIEWS[:1], parameters=SLOW)
    motion = Motion(0.0, body_place_m(VIEWS[0], np.array((0.1, 0.0, 0.25))), 0.0)  # 0.3 m too low
    lead.look(0.0, HOME_M)
    shots_s = []
    for step in range(40):
        lead.follow(replace(motion, time_s=0.1 * step, speed=0.5 if step < 10 else 0.0))
        if lead.shutter(replace(motion, time_s=0.1 * step)) is not None:
            shots_s.append(0.1 * step)
    assert shots_s == [pytest.approx(1.0 + QUICK.rest, abs=0.11)]


def test_a_uav_that_does_not_come_to_rest_takes_no_photograph():
    lead = inspection(VIEWS[:1])
    uav = Uav(lead)
    while lead.task is None:
        uav.step()
    there_m = body_place_m(VIEWS[0], np.array((QUICK.camera_x, QUICK.camera_y, QUICK.camera_z)))

    def shoots(speed):
        leg = PhotographLeg(lead.task, there_m, 0.0, 1.0, 0.0, QUICK)
        motions = [Motion(0.1 * k, there_m, 0.0, speed, 0.0) for k in range(int(20 * QUICK.patience))]
        return any(leg.follow(motion) == "" and leg.opens_shutter(motion) for motion in motions)

    assert shoots(1.9 * STILL_M_S)
    assert not shoots(2.1 * STILL_M_S)


@pytest.mark.table("number", [1, -1])
@pytest.mark.table("detail_mm", [0.3, 0.7, 3.0])
@pytest.mark.table("exposure_s", [0.0005, 0.002])
def test_whatever_the_detail_and_the_exposure_the_shutter_opens_where_the_picture_is_sharp(
    number, detail_mm, exposure_s
):
    p = InspectionParameters(detail=detail_mm, exposure=exposure_s)
    most_m_s = (
        5e-4 * (detail_mm if number > 0 else p.closer) / exposure_s
    )  # half of the detail, while it is open

    def shoots(speed):
        leg = PhotographLeg(Task(number, VIEWS[0]), HOME_M, 0.0, 0.0, 0.0, p)
        motions = [Motion(0.1 * k, HOME_M, VIEWS[0].yaw_rad, speed) for k in range(9)]
        return any(leg.follow(each) == "" and leg.opens_shutter(each) for each in motions)

    assert shoots(0.79 * most_m_s)
    assert not shoots(0.81 * most_m_s)
    assert (
        PhotographQuality(0.0, 100.0, 800.0, 0.0, exposure_s * 0.79 * most_m_s, 0.0).fault(p, number < 0)
        == ""
    )


def test_parameters_for_a_plan_are_those_of_its_detail_and_its_camera():
    """A pixel of a camera of 1000 px focal length covers 2 mm at 2 m."""
    camera = SurveyCamera(1000, 800, math.degrees(2.0 * math.atan(0.5)), exposure=0.001)
    plan = SurveyPlan("", (0.0, 0.0, 1.0), camera, SurveyParameters(resolution=2.0), FlightParameters(), ())
    p = InspectionParameters().for_plan(plan)
    assert (p.detail, p.reach, p.exposure) == (2.0, pytest.approx(2.0), 0.001)


def test_a_photograph_that_is_white_is_taken_again_at_rest_with_another_exposure_a_few_times():
    lead = inspection(parameters=replace(QUICK, exposures=3, passing_speed=0.5))
    uav, biases = Uav(lead), {1: [], 2: [], 3: []}
    given = {2: [(0.6, -2.0), (0.3, -4.0), (0.2, -6.0)], 3: [(0.01, 0.5)]}
    while not lead.is_home and uav.stamp_s < 120.0:
        before = len(uav.asked)
        uav.step()
        if len(uav.asked) > before:  # its picture comes at once
            task = uav.asked[-1]
            biases[task.number].append(lead.metering(task))
            if given.get(task.number):
                lead.expose_again(task, *given[task.number].pop(0))
    detail_m = 1e-3 * QUICK.detail
    assert biases == {
        1: [(detail_m, 0.0)], 2: [(detail_m, 0.0), (detail_m, -2.0), (detail_m, -4.0)], 3: [(detail_m, 0.0)]
    }  # fmt: skip
    assert lead.queue.done == {1, 2, 3}
    assert not lead.queue.left_out


def test_the_last_photograph_is_taken_again_although_the_uav_is_on_its_way_home():
    lead = inspection(VIEWS[:1])
    uav = Uav(lead)
    while not lead.queue.done:
        uav.step()
    lead.look(uav.stamp_s, uav.place_m)
    assert lead.end is not None
    assert lead.expose_again(lead.queue.tasks[0], 0.5, 2.0)
    uav.fly()
    assert len(uav.asked) == 2
    assert lead.is_home
