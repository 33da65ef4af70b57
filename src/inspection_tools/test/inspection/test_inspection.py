"""An inspection leads a UAV without dynamics through a room, with a camera that can fail."""

import math
from dataclasses import replace

import numpy as np
import pytest
from drawn_voxels import tiles_of
from voxel_room import PLANNER, SIDE_M

from inspection_tools.energy import EnergyParameters, EnergyWatch
from inspection_tools.findings.background import Answer
from inspection_tools.inspection import End, Inspection, InspectionParameters, PriorMap, Shot, Task, Todo
from inspection_tools.inspection.leg import Motion, PhotographLeg
from inspection_tools.inspection.places import body_place_m
from inspection_tools.inspection.second_look import SecondLook
from inspection_tools.inspection.taken import RecentPoses, StampedPose, done_in, record_of, shot_of
from inspection_tools.photographs.folder import PhotographFolder, PhotographRecord
from inspection_tools.planning import FREE, OCCUPIED, UNKNOWN, PathPlanner
from inspection_tools.survey.camera import SurveyCamera, optical_axes
from inspection_tools.survey.surface.room import room_of
from inspection_tools.survey.views.candidates import View

HOME_M = np.array((1.0, 1.0, 1.0))
VIEWS = (
    View((3.0, 1.0, 1.0), 0.0, 0.0),
    View((5.0, 1.0, 2.0), math.pi / 2, 0.5),
    View((5.0, 3.0, 1.0), math.pi, -0.5),
)
GOOD, BLURRED = Shot(0.2, 100.0, 800.0), Shot(9.0, 100.0, 800.0)
SPEED, STEP_S, TURN_RAD_S = 1.0, 0.1, 1.0
QUICK = InspectionParameters(patience=2.0, tries=2)


def room(walls=()):
    """The tiles of a room of 6.4 x 4 x 3 m; walls: boxes (low, high) in m that are filled."""
    kinds = np.full((16, 20, 32), FREE, np.uint8)
    kinds[0] = kinds[-1] = kinds[:, 0] = kinds[:, -1] = kinds[:, :, 0] = kinds[:, :, -1] = OCCUPIED
    for low, high in walls:
        a, b = (np.round(np.array(corner[::-1]) / SIDE_M).astype(int) for corner in (low, high))
        kinds[a[0] : b[0], a[1] : b[1], a[2] : b[2]] = OCCUPIED
    return tiles_of(kinds)


def planner(walls=()):
    """A planner that knows the room."""
    known = PathPlanner(PLANNER)
    known.update_map(SIDE_M, 4, *room(walls))
    return known


class Uav:
    """It flies to the setpoint at a constant speed and turns at a constant rate. shots: by the number."""

    def __init__(self, inspection, place_m=HOME_M, yaw_rad=0.0, drain=0.0):
        self.inspection, self.place_m, self.yaw_rad = inspection, np.array(place_m), yaw_rad
        self.stamp_s, self.charge, self.drain = 0.0, 1.0, drain
        self.asked, self.faults = [], {}

    def step(self):
        lead = self.inspection
        self.stamp_s += STEP_S
        self.charge -= self.drain * STEP_S
        way = np.zeros(3) if lead.setpoint_m is None else lead.setpoint_m - self.place_m
        far_m = float(np.linalg.norm(way))
        self.place_m = self.place_m + way * min(1.0, SPEED * STEP_S / max(far_m, 1e-9))
        turn = 0.0 if lead.front_rad is None else math.remainder(lead.front_rad - self.yaw_rad, math.tau)
        rate = float(np.clip(turn / STEP_S, -TURN_RAD_S, TURN_RAD_S))
        self.yaw_rad += rate * STEP_S
        motion = Motion(self.stamp_s, self.place_m, self.yaw_rad, min(SPEED, far_m / STEP_S), rate)
        if lead.follow(motion):
            lead.look(self.stamp_s, self.place_m)
        task = lead.shutter(motion)
        if task is not None:
            self.asked.append(task)
            self.shot_m = self.place_m
            lead.judge(task, self.faults.get(task.number, GOOD))

    def fly(self, longest_s=120.0):
        while not (self.inspection.is_home or self.inspection.must_land) and self.stamp_s < longest_s:
            self.step()
        return self


def inspection(views=VIEWS, walls=(), parameters=QUICK, energy=None, done=()):
    lead = Inspection(planner(walls), Todo(views, done, parameters.tries), parameters, energy)
    lead.begin(0.0, HOME_M)
    return lead


def test_it_takes_all_photographs_in_their_order_and_comes_home():
    lead = inspection()
    uav = Uav(lead).fly()
    assert [task.number for task in uav.asked] == [1, 2, 3]
    assert (lead.end, lead.is_home, lead.todo.done) == (End.DONE, True, {1, 2, 3})
    assert np.linalg.norm(uav.place_m - HOME_M) < 2 * QUICK.arrived


@pytest.mark.parametrize("climbs_first", [True, False])
def test_before_a_manhole_at_another_height_it_climbs_first_if_it_shall(climbs_first):
    # Given a UAV near a wall that is open from z = 1.8 m on, and a photograph behind it
    walls = [((3.0, 0.0, 0.0), (3.4, 4.0, 1.8))]
    beyond = View((5.0, 1.0, 1.0), 0.0, 0.0)
    lead = inspection((beyond,), walls, replace(QUICK, climbs_first=climbs_first))
    uav, track_m = Uav(lead, (2.55, 1.0, 1.7)), []
    while not uav.asked:
        uav.step()
        track_m.append(uav.place_m)
    # Then it climbs on the spot if it shall
    steps_m = np.diff(track_m, axis=0)
    upright_m = steps_m[np.linalg.norm(steps_m[:, :2], axis=1) < 1e-6, 2].sum()
    assert (upright_m > 0.15) == climbs_first


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


@pytest.mark.parametrize(
    ("shot", "word"),
    [
        (BLURRED, "blurred"),
        (Shot(0.1, 1.0, 800.0), "dark"),
        (Shot(0.1, 9.0, 5e4), "dark"),
        (Shot(math.nan, 9.0, 100.0), "blurred"),
    ],
)
def test_a_bad_photograph_is_shot_again_and_then_left_out(shot, word):
    lead = inspection()
    uav = Uav(lead)
    uav.faults[2] = shot
    uav.fly()
    assert [task.number for task in uav.asked] == [1, 2, 2, 3]
    assert lead.todo.done == {1, 3}
    assert word in lead.todo.left_out[2]
    assert lead.is_home


@pytest.mark.parametrize(
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
    asked = InspectionParameters(blur_max=0.5, closer=0.3).for_photographs(1.0, 4000.0)
    shot = Shot(9.0, 100.0, 800.0, 0.0, 1e-3 * shift_mm, 1e-3 * turn_mrad)
    assert (shot.fault(asked, is_closer) == "") == is_good


def test_a_photograph_that_failed_twice_waits_for_the_others():
    lead = inspection(parameters=replace(QUICK, tries=3))
    uav = Uav(lead)
    uav.faults[2] = BLURRED
    uav.fly()
    assert [task.number for task in uav.asked] == [1, 2, 2, 3, 2]
    assert set(lead.todo.left_out) == {2}


def test_after_a_failure_the_uav_rests_more_before_the_shutter_opens():
    task, p = Task(1, VIEWS[0]), InspectionParameters()
    place_m = np.array((1.0, 2.0, 3.0))

    def shoots(failures, speed):
        leg = PhotographLeg(task, place_m, 0.0, 0.0, 0.0, p, failures)
        for stamp_s in np.arange(0.0, p.settle + 0.5, 0.1):
            motion = Motion(stamp_s, place_m, VIEWS[0].yaw_rad, speed)
            leg.follow(motion)
            if leg.opens_shutter(motion):
                return True
        return False

    assert shoots(0, 0.9 * p.still)
    assert not shoots(1, 0.9 * p.still)
    assert shoots(1, 0.6 * p.still)
    assert not shoots(2, 0.6 * p.still)


def test_motion_and_turn_add_up_before_the_shutter_opens():
    p = InspectionParameters()

    def shoots(speed, turn):
        leg = PhotographLeg(Task(1, VIEWS[0]), HOME_M, 0.0, 0.0, 0.0, p)
        motions = [
            Motion(0.1 * k, HOME_M, VIEWS[0].yaw_rad, speed * p.still, turn * p.still_turn) for k in range(9)
        ]
        return any(leg.follow(each) == "" and leg.opens_shutter(each) for each in motions)

    assert shoots(0.95, 0.0)
    assert shoots(0.0, -0.95)
    assert shoots(0.45, 0.45)
    assert not shoots(0.6, 0.6)


def test_where_rest_comes_and_goes_the_shutter_opens_at_the_first_of_it():
    lead = inspection(VIEWS[:1], parameters=InspectionParameters())
    p = InspectionParameters()
    motion = Motion(0.0, body_place_m(VIEWS[0], np.array((p.camera_x, 0.0, 0.15))), 0.0)  # 0.2 m too low
    lead.look(0.0, HOME_M)
    shots_s = []
    for step in range(80):
        moved = replace(motion, stamp_s=0.1 * step, speed=0.05 if step % 12 == 0 else 0.4)
        lead.follow(moved)
        if lead.shutter(moved) is not None:
            shots_s.append(0.1 * step)
    assert shots_s == [pytest.approx(3.6)]  # at rest at 0, 1.2, 2.4, 3.6 s ..., and calm is 2.5 s


def test_a_uav_that_is_kept_off_a_little_shoots_where_it_comes_to_rest():
    lead = inspection(VIEWS[:1], parameters=InspectionParameters())
    motion = Motion(0.0, body_place_m(VIEWS[0], np.array((0.1, 0.0, 0.25))), 0.0)  # 0.3 m too low
    lead.look(0.0, HOME_M)
    shots_s = []
    for step in range(40):
        lead.follow(replace(motion, stamp_s=0.1 * step, speed=0.5 if step < 10 else 0.0))
        if lead.shutter(replace(motion, stamp_s=0.1 * step)) is not None:
            shots_s.append(0.1 * step)
    assert shots_s == [pytest.approx(1.0 + QUICK.rest, abs=0.11)]


def test_what_cannot_be_reached_is_left_out_with_the_reason():
    # Given a wall with something behind it, which the plan did not know
    lead = inspection(walls=[((4.0, 0.0, 0.0), (4.4, 4.0, 3.2))])
    uav = Uav(lead).fly()
    assert lead.todo.done == {1}
    assert set(lead.todo.left_out) == {2, 3}
    assert all(why.endswith(".") for why in lead.todo.left_out.values())
    assert uav.inspection.is_home


def test_a_map_that_lacks_a_part_for_a_moment_costs_no_photograph():
    # Given a map that shows a wall around the UAV for 5 s, as one that has not come whole after a restart
    known = planner([((1.6, 0.2, 0.2), (2.0, 3.8, 2.8))])
    lead = Inspection(known, Todo(VIEWS, (), QUICK.tries), QUICK)
    lead.begin(0.0, HOME_M)
    uav = Uav(lead)
    while uav.stamp_s < 5.0:
        uav.step()
    # When it comes whole
    known.update_map(SIDE_M, 4, *room())
    uav.fly()
    # Then every photograph is taken
    assert lead.todo.done == {1, 2, 3}
    assert not lead.todo.left_out


def test_beside_something_new_the_photograph_is_taken_from_nearby():
    lead = inspection(VIEWS[:1], walls=[((2.8, 0.8, 0.2), (3.2, 1.2, 1.0))])
    uav = Uav(lead).fly()
    assert lead.todo.done == {1}
    off_m = np.linalg.norm(uav.shot_m - body_place_m(VIEWS[0], np.array((0.1, 0.0, -0.05))))
    assert QUICK.near < off_m < QUICK.nearby + QUICK.near


def test_a_battery_that_runs_low_ends_the_flight_and_the_next_one_takes_the_rest():
    watch = EnergyWatch(EnergyParameters(endurance=60.0, landing_time=1.0, reserve=0.5))
    lead = inspection(energy=watch)
    uav = Uav(lead, drain=1.0 / 20.0)
    while not lead.is_home and uav.stamp_s < 60.0:
        watch.offer(uav.stamp_s, uav.charge)
        uav.step()
    assert lead.end is End.BATTERY
    first = [task.number for task in uav.asked]
    assert 0 < len(first) < 3
    # When it takes off again with a full battery, it goes on with the rest
    lead.begin(uav.stamp_s, uav.place_m)
    uav.charge, uav.drain = 1.0, 0.0
    while not lead.is_home and uav.stamp_s < 120.0:
        watch.offer(uav.stamp_s, uav.charge)
        uav.step()
    assert [task.number for task in uav.asked] == [1, 2, 3]
    assert lead.end is End.DONE


def test_it_hovers_in_a_pause_and_an_abort_brings_it_home():
    lead = inspection()
    uav = Uav(lead)
    for _ in range(8):
        uav.step()
    lead.pause(uav.place_m)
    there_m = uav.place_m
    for _ in range(30):
        uav.step()
    np.testing.assert_allclose(uav.place_m, there_m)
    assert not uav.asked
    lead.resume()
    while len(uav.asked) < 1:
        uav.step()
    lead.abort("enough")
    uav.fly()
    assert (lead.end, lead.reason, lead.is_home) == (End.ABORTED, "enough", True)


def test_a_closer_look_comes_first_and_looks_at_the_point():
    lead = inspection()
    uav = Uav(lead)
    uav.step()
    point_m = np.array((3.0, 3.7, 1.5))
    task = lead.look_closer(point_m, uav.place_m, 1.2)
    uav.fly()
    assert [each.number for each in uav.asked] == [-1, 1, 2, 3]
    ahead = optical_axes(task.view.yaw_rad, task.view.tilt_rad)[:, 2]
    np.testing.assert_allclose(np.array(task.view.place_m) + 1.2 * ahead, point_m, atol=1e-9)


def test_a_closer_look_is_taken_squarely_however_flat_the_uav_sees_the_point():
    lead = inspection()
    point_m = np.array((3.0, 3.8, 1.5))  # on the wall y = 3.8
    task = lead.look_closer(point_m, np.array((5.5, 3.2, 1.5)), 1.2)
    back_m = np.array(task.view.place_m) - point_m
    assert -back_m[1] / np.linalg.norm(back_m) > 0.97


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

    assert shoots(1.9 * QUICK.still)
    assert not shoots(2.1 * QUICK.still)


def test_after_the_clock_jumped_back_it_goes_on_and_minds_the_battery():
    energy = EnergyWatch(EnergyParameters(endurance=60.0))
    lead = inspection(energy=energy)
    uav = Uav(lead)
    uav.stamp_s = 500.0
    energy.offer(uav.stamp_s, 0.9)
    while len(uav.asked) < 1:
        uav.step()
    uav.stamp_s -= 400.0
    lead.restart_clock(uav.stamp_s, uav.place_m)
    assert energy.offer(uav.stamp_s, 0.9) == ""
    while len(uav.asked) < 2:
        uav.step()
    assert lead.end is None
    energy.offer(uav.stamp_s, 0.3)
    uav.fly(uav.stamp_s + 60.0)
    assert (lead.end, lead.is_home) == (End.BATTERY, True)


def test_a_picture_that_is_lost_is_taken_again_even_on_the_way_home():
    lead = inspection(VIEWS[:1])
    uav = Uav(lead)
    while lead.end is None:
        uav.step()
    lead.lost(uav.asked[0], "the picture did not come")
    uav.fly()
    assert [task.number for task in uav.asked] == [1, 1]
    assert lead.todo.done == {1}


def test_after_a_restart_the_folder_tells_what_is_done(tmp_path):
    folder = PhotographFolder(tmp_path, SurveyCamera(64, 48))
    body = StampedPose(5.0, (1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0))
    camera = ((0.1, 0.0, -0.05), (-0.5, 0.5, -0.5, 0.5))
    todo = Todo(VIEWS)
    for task, shift_m in zip(todo.tasks, (0.0003, 0.0007)):
        told = type("Told", (), {"exposure": 0.002, "iso": 800.0, "lux": 90.0, "blur": 1.0})
        told.shift, told.turn = shift_m, 0.0
        record = record_of(task, 5.0 + task.number, body, camera, told)
        np.testing.assert_allclose(record.position_m, (1.1, 2.0, 2.95))
        folder.save(np.zeros((48, 64, 3), np.uint8), record)
    assert done_in(tmp_path, QUICK) == {1}  # the second one is blurred
    uav = Uav(inspection(done=done_in(tmp_path, QUICK))).fly()
    assert [task.number for task in uav.asked] == [2, 3]


def test_the_drawing_fills_what_the_lidar_has_not_seen():
    # Given a drawing of a closed room of 4 m with voxels of 0.1 m, its inner air from 0.5 m on
    blocked = np.zeros((40, 40, 40), bool)
    blocked[:5] = blocked[-5:] = blocked[:, :5] = blocked[:, -5:] = True
    blocked[:, :, :5] = blocked[:, :, -5:] = True
    room = room_of(blocked, np.zeros(3), 0.1, 0.3, np.array((2.0, 2.0, 2.0)))
    prior = PriorMap(room)
    # Then it knows the tiles that the room reaches into, and air is free in whole voxels only
    tiles = prior.tiles(0.2, 8)
    assert len(tiles) == 27
    cube = prior.filled(0.2, 8, np.zeros((1, 3), int), np.full((1, 512), UNKNOWN, np.uint8)).reshape(8, 8, 8)
    assert (cube[3:, 3:, 3:] == FREE).all()
    assert (cube[:3] == UNKNOWN).all()
    assert (cube[:, :, :3] == UNKNOWN).all()
    # And what the lidar has seen counts
    seen = np.full((1, 512), OCCUPIED, np.uint8)
    assert (prior.filled(0.2, 8, np.zeros((1, 3), int), seen) == OCCUPIED).all()


def test_without_a_way_home_it_flies_back_the_way_it_came_and_past_where_it_is_stuck():
    # Given a UAV that flew to (5, 1, 1), when something closes the way behind it
    lead = inspection((View((5.0, 1.0, 1.0), 0.0, 0.0),))
    uav = Uav(lead)
    while not uav.asked:
        uav.step()
    closed = planner([((3.0, 0.0, 0.0), (3.4, 4.0, 3.2))])
    lead._planner = lead._homing._planner = closed
    lead.look(uav.stamp_s, uav.place_m)
    assert lead.end is End.DONE
    # Then it takes the way that it came, and keeps to it
    way_m = lead.rest_m
    assert way_m[0][0] > 4.2
    np.testing.assert_allclose(way_m[-1], HOME_M)
    lead.look(uav.stamp_s + 1.0, uav.place_m)
    assert len(lead.rest_m) == len(way_m)
    # When it is stuck there, the nearest places of that way are left out
    lead.look(uav.stamp_s + 12.0, uav.place_m)
    assert lead.rest_m[0][0] < way_m[0][0]
    # When the way is free again, it is planned
    lead._planner = lead._homing._planner = planner()
    lead.look(uav.stamp_s + 13.0, uav.place_m)
    assert len(lead.rest_m) <= 2
    assert not lead._homing.is_by_track


def test_a_uav_that_comes_home_by_a_place_where_cepa_does_not_fly_takes_another_way():
    lead = inspection((View((5.0, 1.0, 1.0), 0.0, 0.0),))
    uav = Uav(lead)
    while not uav.asked:
        uav.step()
    lead.abort("home")
    lead.look(uav.stamp_s, uav.place_m)
    assert len(lead.rest_m) == 1  # straight
    for wait_s in (1.0, 10.0):  # it is kept where it is
        lead.look(uav.stamp_s + wait_s, uav.place_m)
    assert len(lead.rest_m) > 1
    np.testing.assert_allclose(lead.rest_m[-1], HOME_M)


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
    lead = inspection(VIEWS[:2])
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
    assert (lead.end, lead.is_home, lead.todo.done) == (End.DONE, True, {1, 2, -1, -2})
    assert (search.asked, search.closed, at_home) == (1, 1, 0)
    assert lead.reason == "Every photograph of the plan is taken. 2 more are taken from nearer."


def test_what_stays_open_is_photographed_before_the_nearer_ones_and_the_search_is_asked_again():
    search = Search((VIEWS[0],), patience=3, open_=[(VIEWS[2],), (VIEWS[1],)])
    lead, numbers, _ = fly_second_look(search)
    assert numbers == [1, 2, 3, 4, -1]
    assert [task.view for task in lead.todo.tasks] == [*VIEWS[:2], VIEWS[2], VIEWS[1]]
    assert (search.asked, search.closed, lead.end) == (3, 1, End.DONE)
    assert lead.todo.done == {1, 2, 3, 4, -1}


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


def test_an_abort_while_the_search_is_awaited_ends_at_home():
    lead = inspection(VIEWS[:1])
    second, uav = SecondLook(lead, Search((), patience=10**6)), Uav(lead)
    while not lead.is_waiting:
        second.look(waits=False)
        uav.step()
    lead.abort("It was aborted.")
    uav.fly()
    assert (lead.end, lead.is_home) == (End.ABORTED, True)


def test_photographs_are_searched_until_the_search_has_answered_for_the_last_time():
    lead = inspection(VIEWS[:1])
    search = Search((), patience=10**6)
    second = SecondLook(lead, search)
    second.stored("one")
    Uav(lead).fly(5.0)
    second.look(waits=True)
    assert search.asked == 0  # a picture is still to come
    lead.todo.note_done(lead.todo.tasks[0])
    second.look(waits=False)
    second.stored("late")
    assert (search.asked, search.added) == (1, ["one", "late"])
    search.patient = 0
    second.look(waits=False)
    second.stored("later")
    assert (search.closed, search.added) == (1, ["one", "late"])


def test_closer_looks_go_on_counting_from_those_in_the_folder():
    todo = Todo(VIEWS, {1, -1, -4}, 3)
    assert todo.look_closer(VIEWS[0]).number == -5
    todo.look_again(VIEWS[:2])
    assert [task.number for task in todo.open] == [-5, 2, 3, -6, -7]
    assert todo.done == {1, -1, -4}


def test_the_drift_of_odometry_does_not_count_where_slam_corrects_it():
    drifted, matched = (tuple((v * np.eye(6)).ravel()) for v in (0.6**2, 0.02**2))
    poses = RecentPoses()
    for stamp_s in (1.0, 2.0, 9.0):
        poses.note(StampedPose(stamp_s, (stamp_s, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), drifted))
    poses.note_match(0.9, drifted)
    poses.note_match(1.9, matched)
    assert poses.at(2.1).place_m == (2.0, 0.0, 0.0)
    assert poses.at(2.1).covariance == matched
    assert poses.at(9.0).covariance == drifted  # no match is as new
    for covariance, kept in ((matched, True), (drifted, False)):
        place, turn = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
        shot = shot_of(PhotographRecord(1.0, place, turn, 0.002, 100.0, 90.0, 0.1, covariance))
        assert (shot.fault(InspectionParameters()) == "") == kept
