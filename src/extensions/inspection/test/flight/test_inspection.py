"""An inspection leads a UAV without dynamics through a room, with a camera that can fail."""

import math
from dataclasses import replace

import numpy as np
import pytest
from inspecting_uav import (
    BLURRED,
    HOME_M,
    QUICK,
    STEP_S,
    VIEWS,
    Uav,
    inspection,
    planner,
    room,
)
from scipy.spatial.transform import Rotation
from voxel_room import PLANNER, SIDE_M

from exploration.energy import EnergyParameters, EnergyWatch
from exploration.planning import FREE, OCCUPIED, UNKNOWN
from flight_basics.errors import ParameterError
from flight_basics.pose.trust import Trust
from inspection.camera.survey_camera import SurveyCamera, optical_axes
from inspection.flight import (
    End,
    Inspection,
    InspectionParameters,
    PhotographQuality,
    PhotographQueue,
    PriorMap,
    Task,
)
from inspection.flight.photograph_records import (
    RecentPoses,
    ShutterAnswer,
    StampedPose,
    done_in,
    quality_of,
    record_of,
)
from inspection.flight.places import body_place_m
from inspection.photographs.folder import PhotographFolder
from inspection.photographs.record import PhotographRecord, read_record
from inspection.survey.surface.room import room_of
from inspection.survey.views.candidates import View


def test_it_takes_all_photographs_in_their_order_and_comes_home():
    lead = inspection()
    uav = Uav(lead).fly()
    assert [task.number for task in uav.asked] == [1, 2, 3]
    assert (lead.end, lead.is_home, lead.queue.done) == (End.DONE, True, {1, 2, 3})
    assert np.linalg.norm(uav.place_m - HOME_M) < 2 * QUICK.arrived


def test_it_comes_home_to_the_place_above_which_it_took_off_even_from_nearby():
    # Given a photograph from 0.6 m beside its home, which is within the reach of its corners
    lead = inspection([View((1.7, 1.0, 1.0), 0.0, 0.0)])
    uav = Uav(lead).fly()
    assert (lead.end, lead.is_home, len(uav.asked)) == (End.DONE, True, 1)
    assert np.linalg.norm(uav.place_m - HOME_M) < 0.15


def test_a_uav_that_is_held_off_its_home_lands_near_it_after_some_seconds():
    lead = inspection(VIEWS[:1])
    uav = Uav(lead)
    while lead.end is None:
        uav.step()
    began_s = None
    while not lead.is_home and uav.stamp_s < 120.0:
        uav.step()
        off_m = uav.place_m - HOME_M
        if np.linalg.norm(off_m) < 0.5:  # it gets no nearer
            uav.place_m = HOME_M + 0.5 * off_m / np.linalg.norm(off_m)
            began_s = uav.stamp_s if began_s is None else began_s
    assert lead.is_home
    assert 5.0 < uav.stamp_s - began_s < 9.0


def test_pushed_about_before_a_door_it_gives_up_and_takes_the_other_one():
    # Given a wall with two doors, before the nearer of which CEPA pushes the UAV about
    walls = [((3.2, y, 0.0), (3.4, y + w, 3.0)) for y, w in ((0.0, 0.4), (1.6, 0.8), (3.6, 0.4))]
    walls.append(((3.2, 0.0, 1.8), (3.4, 4.0, 3.0)))
    lead = inspection((View((5.4, 1.0, 1.0), 0.0, 0.0),), walls)
    uav, track_m, rng = Uav(lead), [], np.random.default_rng(1)
    while not lead.is_home and uav.stamp_s < 200.0:
        uav.step()
        if uav.place_m[1] < 2.0 and 2.6 < uav.place_m[0] < 3.5:
            uav.place_m = np.array((2.6, uav.place_m[1] + rng.uniform(-0.3, 0.3), uav.place_m[2]))
        track_m.append(uav.place_m)
    # Then it does not stay there for ever, but flies through the other one
    assert lead.queue.done == {1}
    assert min(y for x, y, _ in track_m if abs(x - 3.3) < 0.1) > 2.0


@pytest.mark.table("climbs_first", [True, False])
def test_before_a_manhole_at_another_height_it_climbs_first_if_it_shall(climbs_first):
    # Given a UAV near a wall that is open from z = 1.8 m on, and a photograph behind it
    walls = [((3.0, 0.0, 0.0), (3.4, 4.0, 1.8))]
    beyond = View((5.0, 1.0, 1.0), 0.0, 0.0)
    lead = inspection((beyond,), walls, replace(QUICK, climbs_first=climbs_first))
    uav, track_m = Uav(lead, (2.45, 1.0, 1.7)), []
    while not uav.asked:
        uav.step()
        track_m.append(uav.place_m)
    # Then it climbs on the spot if it shall
    steps_m = np.diff(track_m, axis=0)
    upright_m = steps_m[np.linalg.norm(steps_m[:, :2], axis=1) < 1e-6, 2].sum()
    assert (upright_m > 0.15) == climbs_first


@pytest.mark.table(
    ("shot", "word"),
    [
        (BLURRED, "blurred"),
        (PhotographQuality(0.1, 1.0, 800.0), "dark"),
        (PhotographQuality(0.1, 9.0, 5e4), "dark"),
        (PhotographQuality(math.nan, 9.0, 100.0), "blurred"),
    ],
)
def test_a_bad_photograph_is_shot_again_and_then_left_out(shot, word):
    lead = inspection()
    uav = Uav(lead)
    uav.faults[2] = shot
    uav.fly()
    assert [task.number for task in uav.asked] == [1, 2, 2, 3]
    assert lead.queue.done == {1, 3}
    assert word in lead.queue.left_out[2]
    assert lead.is_home


def test_a_photograph_that_failed_twice_waits_for_the_others():
    lead = inspection(parameters=replace(QUICK, tries=3))
    uav = Uav(lead)
    uav.faults[2] = BLURRED
    uav.fly()
    assert [task.number for task in uav.asked] == [1, 2, 2, 3, 2]
    assert set(lead.queue.left_out) == {2}


def test_what_cannot_be_reached_is_left_out_with_the_reason():
    # Given a wall with something behind it, which the plan did not know
    lead = inspection(walls=[((4.0, 0.0, 0.0), (4.4, 4.0, 3.2))])
    uav = Uav(lead).fly()
    assert lead.queue.done == {1}
    assert set(lead.queue.left_out) == {2, 3}
    assert all(why.endswith(".") for why in lead.queue.left_out.values())
    assert uav.inspection.is_home


def test_a_map_that_lacks_a_part_for_a_moment_costs_no_photograph():
    # Given a map that shows a wall around the UAV for 5 s, as one that has not come whole after a restart
    known = planner([((1.6, 0.2, 0.2), (2.0, 3.8, 2.8))])
    lead = Inspection(known, PhotographQueue(VIEWS, (), QUICK.tries), QUICK)
    lead.begin(0.0, HOME_M)
    uav = Uav(lead)
    while uav.stamp_s < 5.0:
        uav.step()
    # When it comes whole
    known.update_map(SIDE_M, 4, *room())
    uav.fly()
    # Then every photograph is taken
    assert lead.queue.done == {1, 2, 3}
    assert not lead.queue.left_out


def test_beside_something_new_the_photograph_is_taken_from_nearby():
    lead = inspection(VIEWS[:1], walls=[((2.8, 0.8, 0.2), (3.2, 1.2, 1.0))])
    uav = Uav(lead).fly()
    assert lead.queue.done == {1}
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


def test_after_the_last_photograph_a_landing_for_the_battery_has_its_reason():
    watch = EnergyWatch(EnergyParameters(endurance=60.0))
    lead = inspection(VIEWS[:1], energy=watch)
    uav = Uav(lead)
    while not uav.asked:
        watch.offer(uav.stamp_s, uav.charge)
        uav.step()
    uav.charge = 0.02
    while not (lead.is_home or lead.must_land):
        watch.offer(uav.stamp_s, uav.charge)
        uav.step()
    assert lead.end is End.DONE
    assert "land here" in lead.reason


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


def test_while_the_pose_is_not_sure_it_hovers_and_photographs_nothing():
    lead = inspection()
    uav = Uav(lead)
    while len(uav.asked) < 1:
        uav.step()
    lead.trust(Trust.UNSURE, "It is off.", uav.place_m)
    while lead.task is None or not lead.rest_m:
        uav.step()
    lead.trust(Trust.HOVER, "It is off.", uav.place_m)
    here_m = uav.place_m
    for _ in range(100):
        uav.step()
    assert len(uav.asked) == 1
    assert lead.is_in_doubt
    assert math.dist(uav.place_m, here_m) < 0.5
    # When it is sure again, then it goes on, and nothing has failed
    lead.trust(Trust.SURE, "", uav.place_m)
    uav.fly(uav.stamp_s + 120.0)
    assert (lead.end, lead.is_home, lead.queue.left_out) == (End.DONE, True, {})


def test_a_pose_that_stays_unsure_brings_it_home():
    lead = inspection()
    uav = Uav(lead)
    while len(uav.asked) < 1:
        uav.step()
    lead.trust(Trust.HOVER, "SLAM is lost.", uav.place_m)
    uav.step()
    lead.trust(Trust.COME_HOME, "SLAM is lost.", uav.place_m)
    uav.fly(uav.stamp_s + 120.0)
    assert (lead.end, lead.is_home, len(uav.asked)) == (End.ABORTED, True, 1)
    assert lead.reason == "SLAM is lost. That lasted too long."


def test_a_photograph_whose_pose_was_not_sure_is_shot_again():
    """The match tells 0.02 m, but SLAM has just moved the pose by a metre."""
    poses, matched = RecentPoses(), tuple((0.02**2 * np.eye(6)).ravel())
    poses.note(StampedPose(1.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (0.0,) * 36, 1.0))
    poses.note_match(1.0, matched)
    camera = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
    told = record_of(
        Task(1, VIEWS[0]), poses.at(1.0), ShutterAnswer(1.0, *camera, 0.002, 100.0, 90.0, 0.1, 1e-5, 0.0)
    )
    assert quality_of(told).deviation_m == pytest.approx(math.hypot(1.0, 0.02))
    assert "known to 1.00 m only" in quality_of(told).fault(InspectionParameters())


def test_after_a_clock_that_was_set_back_a_photograph_finds_its_own_pose():
    poses = RecentPoses()
    for stamp_s, x_m in ((1.0, 1.0), (1.5, 1.5), (2.0, 2.0), (1.4, 2.1), (1.5, 2.2)):
        poses.note(StampedPose(stamp_s, (x_m, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    assert poses.at(1.5).place_m == (2.2, 0.0, 0.0)
    assert poses.at(1.0).place_m == (1.0, 0.0, 0.0)


def test_a_camera_that_answers_late_gets_the_pose_of_its_shutter_and_a_time_without_poses_gets_none():
    poses = RecentPoses()
    for k in range(1000):  # 20 s of 50 Hz at 1 m/s; its heading turns by 0.1 rad/s
        turn = Rotation.from_euler("z", 0.1 * 0.02 * k).as_quat()
        poses.note(StampedPose(0.02 * k, (0.02 * k, 0.0, 0.0), tuple(turn.tolist())))
    for _ in range(2):  # a pose that comes twice
        poses.note(replace(poses.at(19.98)))
    shot = poses.at(5.013)
    assert shot.place_m == pytest.approx((5.013, 0.0, 0.0), abs=1e-9)
    assert Rotation.from_quat(shot.orientation_xyzw).magnitude() == pytest.approx(0.5013, abs=1e-9)
    answer = ShutterAnswer(
        20.08, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), 0.002, 100.0, 90.0, blur=0.1, shift=1e-5, turn=0.0
    )
    after = record_of(Task(1, VIEWS[0]), poses.at(20.08), answer)  # the last pose is 0.1 s old, at 1 m/s
    assert quality_of(after).deviation_m == pytest.approx(0.1, abs=1e-6)
    for stamp_s in (-1.0, 25.0):
        told = record_of(Task(1, VIEWS[0]), poses.at(stamp_s), replace(answer, stamp_s=stamp_s))
        assert "its place was known to" in quality_of(told).fault(InspectionParameters())


def test_a_picture_that_is_lost_is_taken_again_even_on_the_way_home():
    lead = inspection(VIEWS[:1])
    uav = Uav(lead)
    while lead.end is None:
        uav.step()
    lead.lost(uav.asked[0], "the picture did not come")
    uav.fly()
    assert [task.number for task in uav.asked] == [1, 1]
    assert lead.queue.done == {1}


def test_after_a_restart_the_folder_tells_what_is_done(tmp_path):
    folder = PhotographFolder(tmp_path, SurveyCamera(64, 48))
    body = StampedPose(5.0, (1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0))
    camera = ((0.1, 0.0, -0.05), (-0.5, 0.5, -0.5, 0.5))
    queue = PhotographQueue(VIEWS)
    for task, shift_m in zip(queue.tasks, (0.0003, 0.0007)):
        told = ShutterAnswer(5.0 + task.number, *camera, 0.002, 800.0, 90.0, 1.0, shift_m, 0.0)
        record = record_of(task, body, told)
        np.testing.assert_allclose(record.position_m, (1.1, 2.0, 2.95))
        folder.save(np.zeros((48, 64, 3), np.uint8), record)
    assert done_in(tmp_path, QUICK, VIEWS) == {1}  # the second one is blurred
    uav = Uav(inspection(done=done_in(tmp_path, QUICK, VIEWS))).fly()
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


def test_what_cannot_be_taken_is_told_with_the_reason_of_the_first():
    """Real PX4, real.launch without a drawing: 9 of 11 were left out, and no line said why."""
    queue = PhotographQueue(VIEWS, (), tries=1)
    third, second = queue.tasks[2], queue.tasks[1]
    queue.note_done(queue.tasks[0])
    queue.note_failure(third, "the camera is silent")
    queue.note_failure(second, "The goal (5.5, -1.5, 2.5) is in unknown space.")
    assert queue.summary() == (
        "2 of 3 photographs cannot be taken; all others are. "
        "Photograph 2: The goal (5.5, -1.5, 2.5) is in unknown space."
    )


def test_closer_looks_go_on_counting_from_those_in_the_folder():
    queue = PhotographQueue(VIEWS, {1, -1, -4}, 3)
    assert queue.look_closer(VIEWS[0]).number == -5
    queue.look_again(VIEWS[:2])
    assert [task.number for task in queue.open] == [-5, 2, 3, -6, -7]
    assert queue.done == {1, -1, -4}


def test_each_photograph_is_a_shot_also_one_that_the_folder_held():
    """The others are those that were taken again."""
    queue = PhotographQueue(VIEWS, {1, 2}, 3)
    queue.note_shot()
    queue.note_failure(queue.next, "blurred", at_once=True)
    queue.note_shot()
    queue.note_done(queue.next)
    assert (len(queue.done), queue.shots) == (3, 4)


NONE = (math.nan, math.inf, -math.inf, 1e308)


@pytest.mark.table("number", [*NONE, -1.0])
@pytest.mark.table("place", [0, 7, 14, 35])
@pytest.mark.table("by_match", [True, False])
def test_a_covariance_that_is_none_says_that_nobody_knows_the_place(tmp_path, number, place, by_match):
    good = (0.02**2 * np.eye(6)).ravel()
    bad = good.copy()
    bad[place] = number
    poses = RecentPoses()
    told = tuple(good) if by_match else tuple(bad)
    poses.note(StampedPose(1.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), told))
    if by_match:
        poses.note_match(1.0, tuple(bad))
    covariance = poses.at(1.0).covariance
    record = PhotographRecord(1.0, (0.0,) * 3, (0.0, 0.0, 0.0, 1.0), 0.002, 100.0, 90.0, 0.1, covariance)
    assert "its place was known to 1000.00 m only" in quality_of(record).fault(InspectionParameters())
    path = PhotographFolder(tmp_path, SurveyCamera(64, 48)).save(np.zeros((48, 64, 3), np.uint8), record)
    assert read_record(path.with_suffix(".json")).covariance == covariance  # a reader that is strict, too


@pytest.mark.table("number", NONE[:3])
@pytest.mark.table("name", ["blur_px", "lux", "iso", "deviation_m", "shift_m", "turn_rad"])
def test_a_photograph_of_which_a_number_is_none_is_taken_again(number, name):
    good = PhotographQuality(0.1, 90.0, 100.0, 0.02, 0.0001, 0.00001)
    assert not good.fault(InspectionParameters())
    assert replace(good, **{name: number}).fault(InspectionParameters())


def test_the_drift_of_odometry_does_not_count_where_slam_corrects_it():
    drifted, matched = (tuple((v * np.eye(6)).ravel()) for v in (0.6**2, 0.02**2))
    poses = RecentPoses()
    for stamp_s in (1.0, 2.0, 9.0):
        poses.note(StampedPose(stamp_s, (stamp_s, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), drifted))
    poses.note_match(0.9, drifted)
    poses.note_match(1.9, matched)
    assert poses.at(2.0).place_m == (2.0, 0.0, 0.0)
    assert poses.at(2.0).covariance == matched
    assert poses.at(9.0).covariance == drifted  # no match is as new
    for covariance, kept in ((matched, True), (drifted, False)):
        place, turn = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
        shot = quality_of(PhotographRecord(1.0, place, turn, 0.002, 100.0, 90.0, 0.1, covariance))
        assert (shot.fault(InspectionParameters()) == "") == kept


def test_each_goal_has_its_own_time():
    lead = inspection(VIEWS[:1])
    for begin_s, given_s, wanted_s in ((100.0, 20.0, 20.0), (500.0, 40.0, 40.0), (900.0, None, 3600.0)):
        lead.begin(begin_s, HOME_M, time_max_s=given_s)
        lead.look(begin_s + wanted_s, HOME_M)
        assert lead.end is None
        lead.look(begin_s + wanted_s + 1.0, HOME_M)
        assert lead.end is End.TIME
    with pytest.raises(ParameterError, match="time_max"):
        lead.begin(2000.0, HOME_M, time_max_s=math.nan)


def test_a_photograph_that_was_deleted_is_taken_again_and_the_others_are_not():
    lead = inspection()
    uav = Uav(lead).fly()
    lead.note_stored({1, 3})
    lead.begin(uav.stamp_s, uav.place_m)
    uav.fly(uav.stamp_s + 120.0)
    assert [task.number for task in uav.asked] == [1, 2, 3, 2]
    assert lead.queue.done == {1, 2, 3}


def test_a_pane_on_the_way_to_a_photograph_is_pressed_once_and_another_way_is_taken():
    # Given a wall at x = 3 m with a window whose pane no beam meets, and a door beside it
    walls = [((3.0, 0.0, 0.0), (3.2, 0.2, 3.0)), ((3.0, 2.2, 0.0), (3.2, 2.6, 3.0))]
    uav = Uav(inspection((View((5.0, 1.0, 1.2), 0.0, 0.0),), walls))
    pressed_s = 0.0
    while not uav.asked and uav.stamp_s < 60.0:
        before_m = uav.place_m
        uav.step()
        if abs(uav.place_m[0] - 3.1) < PLANNER.radius and uav.place_m[1] < 2.2:
            uav.place_m, pressed_s = before_m, pressed_s + STEP_S
    assert uav.asked
    assert 0.0 < pressed_s < 12.0
