"""A UAV finds its place in space by clouds, wherever it flies, and says when it cannot."""

import math

import numpy as np
import pytest
from puck_in_a_room import DOWN, LEVEL, LIMITS_M, cloud, errors, fly, heading, place_at, yaw_at

from gridslam.cloud_odometry import CloudOdometry, CloudOdometryParameters
from gridslam.errors import ScanError
from gridslam.odometry.inertial import GRAVITY_MPS2, InertialReading

START = place_at(0.0)


def odometry(**options):
    return CloudOdometry(start=(*START[:2], yaw_at(0.0)), **options)


def rng():
    return np.random.default_rng(5)


def test_it_follows_a_loop_with_a_climb_of_3_m_to_centimetres():
    flown = fly(odometry(), 32.0, rng())
    off = errors(flown)
    assert np.abs(off).max() < 0.05
    assert np.sqrt((off**2).sum(axis=1).mean()) < 0.02
    for time_s, estimate, _ in flown:
        assert estimate.roll_pitch_yaw[2] == pytest.approx(yaw_at(time_s), abs=0.01)
        assert estimate.roll_pitch_yaw[:2] == pytest.approx((0.0, 0.0), abs=0.01)
    assert not any(estimate.remark for _, estimate, _ in flown)


def test_a_map_that_began_with_a_wrong_pitch_is_levelled():
    """On the ground a bias of the accelerometer looks like a lean. When it is known, the map is put right."""
    flown = fly(odometry(), 21.0, rng(), pitch_told=lambda time_s: 0.02 if time_s < 2.0 else 0.0)
    assert flown[10][1].roll_pitch_yaw[1] == pytest.approx(0.02, abs=0.004)
    late = flown[-50:]
    assert max(abs(estimate.roll_pitch_yaw[1]) for _, estimate, _ in late) < 0.004
    assert np.abs(errors(late)).max() < 0.05


def test_the_velocity_is_that_of_the_base_along_its_own_axes():
    flown = fly(odometry(), 12.0, rng())
    for time_s, estimate, _ in flown[20:]:
        true = (place_at(time_s + 0.01) - place_at(time_s - 0.01)) / 0.02
        assert estimate.velocity_xyz == pytest.approx(heading(yaw_at(time_s)).T @ true, abs=0.2)


def test_clouds_find_out_a_floor_that_sinks_under_the_range_finder_as_if_in_a_climb():
    """The readings grow by 1.5 cm each to 15 cm, as at an edge in the cone. Floor and walls stay in sight."""
    o, generator, end_s = odometry(), rng(), 31.5
    fly(o, end_s, generator)
    place, rotation, off = place_at(end_s), heading(yaw_at(end_s)), []
    for tick in range(1, 100):
        time_s = end_s + 0.05 * tick
        for earlier_s in (0.03, 0.01):
            o.on_imu(InertialReading(time_s - earlier_s, LEVEL[1], (0.0, 0.0, 0.0), (0.0, 0.0, GRAVITY_MPS2)))
        sunk_m = min(max(0.015 * (tick - 10), 0.0), 0.15)
        o.on_range(time_s - 0.01, place[2] + sunk_m, LIMITS_M, DOWN)
        off.append(o.on_cloud(time_s, cloud(place, rotation, generator), LEVEL).position_xyz[2] - place[2])
    assert max(off) > 0.1  # it was misled
    assert np.abs(off[-20:]).max() < 0.05


def test_without_a_range_finder_it_still_knows_x_y_and_yaw():
    off = errors(fly(odometry(), 20.0, rng(), has_range=False))
    assert np.abs(off[:, :2]).max() < 0.05


def test_the_covariance_is_not_smaller_than_the_error_allows():
    """Of a hundred matches nearly all lie within four standard deviations of the truth."""
    flown = fly(odometry(), 12.0, rng())
    off = errors(flown)[10:]
    sigmas = np.sqrt([np.diag(estimate.matched_covariance)[:3] for _, estimate, _ in flown[10:]])
    assert (np.abs(off) <= 4.0 * sigmas + 0.005).mean() > 0.95


def test_what_it_tells_slam_of_a_metre_of_way_does_not_grow_with_the_way():
    """The place in `odom` walks at random: each metre adds the same variance, the first one and the last."""
    flown = fly(odometry(), 32.0, rng())
    added = np.array([each.pose_covariance[0, 0] - each.matched_covariance[0, 0] for _, each, _ in flown])
    places = np.array([estimate.position_xyz for _, estimate, _ in flown])
    ways_m = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))))
    assert ways_m[-1] > 10.0
    told = CloudOdometryParameters().drift ** 2 * ways_m
    np.testing.assert_allclose(added - added[0], told, atol=0.03 * told[-1])


def test_another_start_only_moves_the_frame():
    """The same readings, begun at another place and heading."""
    turned = CloudOdometry(start=(10.0, -4.0, 1.0))
    plain = odometry()
    there, here = fly(turned, 4.0, rng()), fly(plain, 4.0, rng())
    for (_, a, _), (_, b, _) in zip(there, here):
        offset = np.array(b.position_xyz) - (*START[:2], 0.0)
        expected = heading(1.0) @ offset + (10.0, -4.0, 0.0)
        assert a.position_xyz == pytest.approx(expected, abs=0.02)  # the voxels lie otherwise


def test_the_same_readings_give_the_same_poses():
    first, second = (fly(odometry(), 3.0, rng()) for _ in range(2))
    assert [e.position_xyz for _, e, _ in first] == [e.position_xyz for _, e, _ in second]


def test_a_person_who_walks_by_does_not_pull_the_pose():
    def with_person(place, rotation, generator):
        points = cloud(place, rotation, generator)
        azimuths = np.arctan2(points[:, 1], points[:, 0])
        points[np.abs(azimuths) < 0.25] *= (1.5 / np.linalg.norm(points[np.abs(azimuths) < 0.25], axis=1))[
            :, None
        ]
        return points

    o, generator = odometry(), rng()
    fly(o, 3.0, generator)
    for tick in range(31, 50):
        time_s = tick / 10
        points = with_person(place_at(time_s), heading(yaw_at(time_s)), generator)
        estimate = o.on_cloud(time_s, points, LEVEL)
    assert estimate.position_xyz == pytest.approx(place_at(4.9), abs=0.05)


def test_a_cloud_of_another_room_does_not_count_and_that_is_said():
    o, generator = odometry(), rng()
    fly(o, 2.0, generator)
    before = o.on_cloud(2.1, cloud(place_at(2.1), heading(yaw_at(2.1)), generator), LEVEL)
    elsewhere = generator.uniform(-40.0, 40.0, (5000, 3))
    estimate = o.on_cloud(2.2, elsewhere, LEVEL)
    assert "does not match" in estimate.remark
    assert estimate.position_xyz == pytest.approx(before.position_xyz, abs=0.1)


def test_without_points_it_goes_on_by_prediction_and_says_so():
    o = odometry()
    fly(o, 2.0, rng())
    estimate = o.on_cloud(2.1, np.empty((0, 3)), LEVEL)
    assert "does not match: 0 of" in estimate.remark
    assert np.isfinite(estimate.position_xyz).all()
    assert estimate.pose_covariance[0, 0] > 0.0


def test_the_map_begins_at_the_height_of_the_first_range():
    """A map that began at 0 would contradict the range finder for ever."""
    o, generator = odometry(), rng()
    points = [cloud(START, heading(yaw_at(0.0)), generator) for _ in range(2)]
    o.on_cloud(0.0, points[0], LEVEL)
    assert o.planes.is_empty
    o.on_range(0.01, START[2], LIMITS_M, DOWN)
    o.on_range(0.06, START[2], LIMITS_M, DOWN)
    o.on_cloud(0.1, points[1], LEVEL)
    assert not o.planes.is_empty
    estimate = o.on_cloud(0.2, points[0], LEVEL)
    assert estimate.position_xyz == pytest.approx(START, abs=0.01)


def test_before_range_finder_or_map_tell_a_height_it_is_unknown():
    """A height of 0 that seems sure to 1 mm contradicts the range finder, which soon tells another one."""
    o, generator = odometry(), rng()
    points = [cloud(START, heading(yaw_at(0.0)), generator) for _ in range(2)]
    before = o.on_cloud(0.0, points[0], LEVEL)
    o.on_range(0.01, START[2], LIMITS_M, DOWN)
    after = o.on_cloud(0.1, points[1], LEVEL)
    assert before.height_uncertain_m >= 1.0
    assert before.matched_covariance[2, 2] >= 1.0
    assert after.height_uncertain_m < 0.05


def test_few_rings_carry_a_climb_into_what_no_plane_knows_yet():
    """Of a lidar with 8 rings that stands on the floor, few points find a plane. But they agree with it."""

    def few(place, rotation, generator):
        points = cloud(place, rotation, generator)
        return points.reshape(16, -1, 3)[:8].reshape(-1, 3)

    o, generator = odometry(), rng()
    for tick in range(60):
        time_s = tick / 10
        place = (START[0], START[1], 0.2 + 0.5 * max(time_s - 1.0, 0.0))
        o.on_range(time_s - 0.01, place[2], LIMITS_M, DOWN)
        estimate = o.on_cloud(time_s, few(np.array(place), heading(yaw_at(0.0)), generator), LEVEL)
    assert estimate.position_xyz == pytest.approx(place, abs=0.05)


def test_nothing_in_range_from_the_start_is_said():
    estimate = odometry().on_cloud(0.0, np.full((100, 3), math.nan), LEVEL)
    assert "nothing has been in range yet" in estimate.remark


def test_points_that_are_not_finite_do_not_count():
    o, generator = odometry(), rng()
    fly(o, 2.0, generator)
    points = cloud(place_at(2.1), heading(yaw_at(2.1)), generator)
    points[::3] = math.nan
    points[1::7] = math.inf
    assert o.on_cloud(2.1, points, LEVEL).position_xyz == pytest.approx(place_at(2.1), abs=0.05)


def test_a_clock_that_jumps_back_begins_anew_at_the_start():
    said = []
    o = odometry(say=said.append)
    fly(o, 4.0, rng())
    estimate = o.on_cloud(0.0, cloud(START, heading(0.0), rng()), LEVEL)
    assert ["jumped back" in words for words in said] == [True]
    assert estimate.position_xyz[:2] == pytest.approx(START[:2], abs=1e-6)


@pytest.mark.table(
    ("stamp_s", "points", "complaint"),
    [
        (math.nan, np.zeros((5, 3)), "stamp must be finite"),
        (9.0, np.zeros((5, 4)), r"must be \(n, 3\)"),
        (1.0, np.zeros((5, 3)), "not newer"),
    ],
)
def test_a_cloud_that_makes_no_sense_gets_a_sentence(stamp_s, points, complaint):
    o = odometry()
    fly(o, 1.0, rng())
    with pytest.raises(ScanError, match=complaint):
        o.on_cloud(stamp_s, points, LEVEL)


def test_a_full_map_takes_no_more_and_says_so():
    o = odometry(parameters=CloudOdometryParameters(voxels_max=30_000))
    flown = fly(o, 8.0, rng())
    assert "voxels_max" in flown[-1][1].remark or len(o.planes) < 30_000
    assert np.abs(errors(flown)).max() < 0.3


def test_a_range_beyond_the_limits_does_not_count():
    o = odometry()
    for range_m in (0.01, 30.0, math.nan):
        o.on_range(0.0, range_m, LIMITS_M, DOWN)
    assert not o.height.is_known_at(0.0)


def turning_yaw_at(time_s):
    """From rest, when the map has begun, to turns of up to 2.2 rad/s."""
    return 2.0 * (1.0 - math.cos(1.1 * max(time_s - 1.5, 0.0)))


def test_without_an_imu_the_turn_goes_on_as_before():
    o, generator, off = CloudOdometry(start=(*START[:2], 0.0)), rng(), []
    for tick in range(40):
        time_s = 0.1 * tick
        place, yaw = place_at(time_s - 0.5), turning_yaw_at(time_s)
        estimate = o.on_cloud(time_s, cloud(place, heading(yaw), generator), LEVEL)
        error_m = np.abs(np.array(estimate.position_xyz[:2]) - place[:2]).max()
        turned = math.remainder(estimate.roll_pitch_yaw[2] - yaw, 2.0 * math.pi)
        off.append((error_m, abs(turned)))
        assert "IMU is silent" in estimate.remark
    assert np.max(off, axis=0)[0] < 0.03
    assert np.max(off, axis=0)[1] < 0.01
