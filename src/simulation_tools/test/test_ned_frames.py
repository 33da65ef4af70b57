"""Frames: NED and FRD against ENU and FLU, by matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.geometry import quaternion_from_rpy, rotation_matrix
from simulation_tools.ned_frames import (
    attitude_to_enu,
    attitude_to_ned,
    covariance_to_frd,
    covariance_to_ned,
    enu_to_ned,
    flu_to_frd,
    yaw_to_ned,
)

angles = st.floats(-3.1, 3.1)
TO_NED = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
TO_FRD = np.diag([1, -1, -1])


def matrix(q_wxyz):
    w, x, y, z = q_wxyz
    return rotation_matrix((x, y, z, w))


@given(angles, st.floats(-1.5, 1.5), angles)
def test_attitudes_turn_between_the_frames_as_matrices_do(roll, pitch, yaw):
    enu = quaternion_from_rpy(roll, pitch, yaw)
    ned = attitude_to_ned(enu)
    assert np.allclose(matrix(ned), TO_NED @ rotation_matrix(enu) @ TO_FRD, atol=1e-9)
    assert attitude_to_enu(ned) == pytest.approx(enu, abs=1e-12)


def test_east_is_a_heading_of_ninety_degrees():
    assert yaw_to_ned(0.0) == pytest.approx(math.pi / 2)
    assert yaw_to_ned(math.pi / 2) == pytest.approx(0.0)
    assert yaw_to_ned(-math.pi / 2) == pytest.approx(math.pi)
    assert enu_to_ned((1, 2, 3)) == (2, 1, -3)
    assert flu_to_frd((1, 2, 3)) == (1, -2, -3)


@pytest.mark.table("size", [3, 6])
@pytest.mark.table(("turn", "rotation"), [(covariance_to_ned, TO_NED), (covariance_to_frd, TO_FRD)])
def test_covariances_are_rotated_as_matrices_are(size, turn, rotation):
    root = np.random.default_rng(4).normal(size=(size, size))
    covariance = root @ root.T
    both = np.kron(np.eye(size // 3), rotation)
    there = turn(covariance.ravel().tolist())
    assert np.allclose(np.reshape(there, (size, size)), both @ covariance @ both.T)
    assert turn(there) == pytest.approx(covariance.ravel())  # and back
    covariance[1, 0] = math.nan
    assert np.isnan(turn(covariance.ravel().tolist())).all()
