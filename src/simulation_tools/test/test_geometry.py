"""Geometry against scipy's Rotation, an independent implementation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from simulation_tools import geometry
from simulation_tools.geometry import Pose

ANGLE = st.floats(-math.pi, math.pi)
COORDINATE = st.floats(-1e3, 1e3)
VECTOR = st.tuples(COORDINATE, COORDINATE, COORDINATE)
QUATERNION = (
    st.tuples(*[st.floats(-1.0, 1.0)] * 4)
    .filter(lambda q: sum(c * c for c in q) > 1e-3)
    .map(geometry.quaternion_normalised)
)
POSE = st.builds(Pose, VECTOR, QUATERNION)


def same_rotation(a, b, tolerance=1e-12):
    return abs(abs(float(np.dot(a, b))) - 1.0) < tolerance


@given(ANGLE, ANGLE, ANGLE)
def test_roll_pitch_yaw_turn_about_fixed_axes_in_this_order(roll, pitch, yaw):
    expected = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_quat()
    assert same_rotation(geometry.quaternion_from_rpy(roll, pitch, yaw), expected)


@given(QUATERNION)
def test_rpy_describes_the_same_rotation_as_the_quaternion(q):
    roll, pitch, yaw = geometry.rpy_from_quaternion(q)
    assert -math.pi / 2 <= pitch <= math.pi / 2
    assert same_rotation(Rotation.from_euler("xyz", [roll, pitch, yaw]).as_quat(), q, 1e-9)


@pytest.mark.table("sign", [1.0, -1.0])
def test_rpy_at_gimbal_lock_still_gives_the_same_rotation(sign):
    q = geometry.quaternion_from_rpy(0.3, sign * math.pi / 2, 0.8)
    roll, pitch, yaw = geometry.rpy_from_quaternion(q)
    assert roll == 0.0
    assert pitch == pytest.approx(sign * math.pi / 2)
    assert same_rotation(geometry.quaternion_from_rpy(roll, pitch, yaw), q)


@given(QUATERNION, QUATERNION)
def test_product_is_the_second_rotation_followed_by_the_first(a, b):
    expected = (Rotation.from_quat(a) * Rotation.from_quat(b)).as_quat()
    assert same_rotation(geometry.quaternion_multiply(a, b), expected)


@given(QUATERNION, VECTOR)
def test_rotating_a_vector(q, v):
    np.testing.assert_allclose(geometry.rotate(q, v), Rotation.from_quat(q).apply(v), atol=1e-9)
    np.testing.assert_allclose(geometry.rotate_inverse(q, v), Rotation.from_quat(q).inv().apply(v), atol=1e-9)


@given(QUATERNION)
def test_rotation_matrix_and_back(q):
    np.testing.assert_allclose(geometry.rotation_matrix(q), Rotation.from_quat(q).as_matrix(), atol=1e-12)
    assert same_rotation(geometry.quaternion_from_matrix(geometry.rotation_matrix(q)), q)


@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3))
def test_rotation_vector(v):
    assert same_rotation(geometry.quaternion_from_rotation_vector(v), Rotation.from_rotvec(v).as_quat())


@given(QUATERNION)
def test_yaw_is_the_heading_of_the_x_axis(q):
    x, y, _ = Rotation.from_quat(q).apply((1.0, 0.0, 0.0))
    if math.hypot(x, y) > 1e-3:
        assert geometry.wrap_angle(geometry.yaw_from_quaternion(q) - math.atan2(y, x)) == pytest.approx(
            0, abs=1e-9
        )


@given(POSE, POSE, VECTOR)
def test_composed_poses_transform_as_one_after_the_other(a, b, point):
    points = np.array([point])
    np.testing.assert_allclose((a @ b).transform(points), a.transform(b.transform(points)), atol=1e-8)


@given(POSE, VECTOR)
def test_a_pose_times_its_inverse_changes_nothing(pose, point):
    np.testing.assert_allclose((pose.inverse() @ pose).transform(np.array(point)), point, atol=1e-8)


@given(st.floats(-1e4, 1e4))
def test_wrapped_angles_lie_in_the_half_open_circle(angle):
    wrapped = geometry.wrap_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@pytest.mark.table("q", [(0, 0, 0, 0), (math.nan, 0, 0, 1), (math.inf, 0, 0, 1)])
def test_what_is_no_rotation_is_refused(q):
    with pytest.raises(ValueError, match="not a rotation"):
        Pose.checked((0, 0, 0), q)


def test_a_position_that_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="not finite"):
        Pose.checked((0, math.nan, 0), (0, 0, 0, 1))


def test_a_position_beyond_any_world_is_refused():
    assert Pose.checked((1e6, -1e6, 0), (0, 0, 0, 1)).position_m == (1e6, -1e6, 0)
    with pytest.raises(ValueError, match="beyond 1e"):
        Pose.checked((0, -1e35, 0), (0, 0, 0, 1))
