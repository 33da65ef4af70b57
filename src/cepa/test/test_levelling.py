"""Floor and ceiling in a leaning lidar's scan: closed-form geometry, and a slow reference from points."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cepa import AttitudeError, CepaParameters, Improved, LaserScan2D, LidarAttitude, levelled
from cepa.levelling import needed_sight

TURN = 2.0 * math.pi
BEAMS = 360
ANGLES = -math.pi + np.arange(BEAMS) * TURN / BEAMS
HEIGHT_M = 2.0
P = CepaParameters(levelling=True, ceiling_height=5.0)
NO_MARGIN = CepaParameters(levelling=True, ceiling_height=5.0, floor_margin=0.0)


def rotation(roll, pitch, yaw):
    """R = Rz(yaw) Ry(pitch) Rx(roll), as ROS has it."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return z @ y @ x


def quaternion(roll, pitch, yaw):
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in (roll, pitch, yaw))
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def directions(turned):
    """The beams' directions in the world, (n, 3)."""
    return np.stack([np.cos(ANGLES), np.sin(ANGLES), np.zeros(BEAMS)], axis=1) @ turned.T


def hall(turned, height=HEIGHT_M, ceiling=5.0, reach=30.0):
    """Ranges to an endless floor at 0 and a ceiling."""
    climb = directions(turned)[:, 2]
    with np.errstate(divide="ignore", over="ignore"):
        ranges = np.where(climb < 0.0, -height / climb, (ceiling - height) / climb)
    return np.where(np.isfinite(ranges) & (ranges <= reach), ranges, np.inf)


def scan_of(ranges, seen=None):
    return LaserScan2D(ranges, -math.pi, TURN / BEAMS, 0.05, 30.0, seen)


def attitude(roll=0.0, pitch=0.0, yaw=0.0, height=HEIGHT_M):
    return LidarAttitude.of_mounted(height, quaternion(roll, pitch, yaw))


def test_a_level_scan_is_left_alone():
    scan = scan_of(np.linspace(0.5, 20.0, BEAMS))
    assert levelled(scan, attitude(yaw=1.0), P, 2.0) is scan


@pytest.mark.table(("height", "dropped"), [(0.20, False), (0.16, False), (0.14, True), (-0.1, True)])
def test_what_ends_within_the_margin_of_the_floor_is_floor(height, dropped):
    pitch = math.radians(30.0)
    ranges = np.full(BEAMS, np.inf)
    ranges[180] = (HEIGHT_M - height) / math.sin(pitch)  # ends at this height, straight ahead
    result = levelled(scan_of(ranges), attitude(pitch=pitch), P, 0.0)
    assert bool(np.isinf(result.ranges[180])) == dropped


@pytest.mark.table(("height", "dropped"), [(4.8, False), (4.9, True), (5.1, True)])
def test_what_ends_within_the_margin_of_the_ceiling_is_ceiling(height, dropped):
    pitch = math.radians(-30.0)
    ranges = np.full(BEAMS, np.inf)
    ranges[180] = (height - HEIGHT_M) / math.sin(-pitch)
    result = levelled(scan_of(ranges), attitude(pitch=pitch), P, 0.0)
    assert bool(np.isinf(result.ranges[180])) == dropped


@pytest.mark.table(("speed", "seen"), [(0.0, True), (2.0, True), (4.0, False)])
def test_a_direction_is_free_if_the_uav_can_stop_within_what_was_seen(speed, seen):
    # 45 degrees down from 2 m: the floor is 2 m ahead. To stop takes 0, 1 and 3 m; r_lb is 0.5 m.
    pitch = math.radians(45.0)
    scan = scan_of(hall(rotation(0.0, pitch, 0.0)))
    result = levelled(scan, attitude(pitch=pitch), P, speed)
    assert np.isinf(result.ranges[180])
    assert bool(result.seen[180]) == seen


def test_a_direction_must_be_seen_as_far_as_an_emergency_looks():
    assert needed_sight(P, 0.0) == pytest.approx(1.2 + 0.35)
    pitch = math.radians(45.0)
    low = scan_of(hall(rotation(0.0, pitch, 0.0), height=1.5))  # the floor is 1.5 m ahead
    assert not levelled(low, attitude(pitch=pitch, height=1.5), P, 0.0).seen[180]


def test_beams_that_were_unseen_and_invalid_stay_so():
    pitch = math.radians(20.0)
    ranges = hall(rotation(0.0, pitch, 0.0))
    ranges[170], ranges[175], ranges[176] = math.nan, -math.inf, 0.01
    seen = np.ones(BEAMS, bool)
    seen[180] = False
    result = levelled(scan_of(ranges, seen), attitude(pitch=pitch), P, 0.0)
    assert math.isnan(result.ranges[170])
    assert result.ranges[[175, 176]].tolist() == [-math.inf, 0.01]
    assert np.flatnonzero(~result.seen).tolist() == [180]


def test_on_the_ground_nothing_is_taken_for_floor():
    pitch = math.radians(5.0)
    ranges = np.full(BEAMS, 1.0)
    result = levelled(scan_of(ranges), attitude(pitch=pitch, height=0.1), P, 0.0)
    assert (result.ranges == 1.0).all()


angles_of_lean = st.floats(-0.6, 0.6)


@given(
    st.integers(0, 2**32 - 1),
    st.tuples(angles_of_lean, angles_of_lean, st.floats(-math.pi, math.pi)),
    st.tuples(st.floats(-0.3, 0.3), st.sampled_from([0.0, math.pi]), st.floats(-math.pi, math.pi)),
    st.floats(0.5, 4.5),
    st.floats(0.0, 4.0),
)
def test_exactly_the_points_at_floor_and_ceiling_are_dropped(seed, body, mount, height, speed):
    # Given any body attitude, and a lidar mounted anyhow, upside down too, off the middle
    offset = np.array([0.1, -0.05, 0.08])
    turned = rotation(*body) @ rotation(mount[0], 0.0, mount[2]) @ rotation(mount[1], 0.0, 0.0)
    mounted = quaternion_of(rotation(mount[0], 0.0, mount[2]) @ rotation(mount[1], 0.0, 0.0))
    lidar_m = height + float((rotation(*body) @ offset)[2])
    rng = np.random.default_rng(seed)
    ranges = np.minimum(hall(turned, lidar_m), rng.uniform(0.3, 25.0, BEAMS))
    # When it is levelled
    lean = LidarAttitude.of_mounted(height, quaternion(*body), offset, mounted)
    result = levelled(scan_of(ranges), lean, NO_MARGIN, speed)
    # Then what a point-by-point computation says is gone, and nothing else
    points = ranges[:, None] * directions(turned)
    ends = lidar_m + points[:, 2]
    gone = np.isinf(result.ranges) & np.isfinite(ranges)
    certain = np.isfinite(ranges) & (np.minimum(np.abs(ends), np.abs(ends - 5.0)) > 1e-6)
    assert not gone[certain].any()
    expected = np.isfinite(ranges) & ((ends < -1e-6) | (ends > 5.0 + 1e-6))
    assert gone[expected].all()
    assert (result.ranges[~gone] == ranges[~gone]).all()
    enough = np.hypot(points[:, 0], points[:, 1]) >= needed_sight(NO_MARGIN, speed) + 1e-6
    assert result.seen[gone & enough].all()
    assert result.seen[~gone].all()


def quaternion_of(matrix):
    """x, y, z, w of a rotation matrix: the eigenvector of the symmetric 4 x 4 form (Bar-Itzhack 2000)."""
    m = matrix
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], m[1, 0] + m[0, 1], m[2, 0] + m[0, 2], m[2, 1] - m[1, 2]],
            [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
            [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m[0, 0] + m[1, 1] + m[2, 2]],
        ]
    )
    values, vectors = np.linalg.eigh(k)
    return tuple(vectors[:, np.argmax(values)].tolist())


def test_cepa_flies_on_over_a_floor_that_would_stop_it():
    # Given a UAV that leans 30 degrees into its acceleration, 1.2 m over the floor, which it sees 2.4 m ahead
    pitch = math.radians(30.0)
    scan = scan_of(hall(rotation(0.0, pitch, 0.0), height=1.2))
    lean = attitude(pitch=pitch, height=1.2)
    # Then it is held back without levelling, and goes on with it
    held = Improved(P).steer(scan, (2.0, 0.0), (0.5, 0.0))
    assert held.velocity_xy != (2.0, 0.0)
    assert Improved(P).steer(levelled(scan, lean, P, 0.5), (2.0, 0.0), (0.5, 0.0)).velocity_xy == (2.0, 0.0)


@pytest.mark.table(
    ("height", "orientation", "sentence"),
    [
        (math.nan, (0, 0, 0, 1), "height finite"),
        (math.inf, (0, 0, 0, 1), "height finite"),
        (1.0, (math.nan, 0, 0, 1), "unit quaternion"),
        (1.0, (2.0, 0, 0, 1), "unit quaternion"),
        (1.0, (0, 0, 0, 0), "unit quaternion"),
    ],
)
def test_an_attitude_that_is_none_is_refused_in_a_sentence(height, orientation, sentence):
    with pytest.raises(AttitudeError, match=sentence) as refusal:
        LidarAttitude.of_mounted(height, orientation)
    assert "\n" not in str(refusal.value)
