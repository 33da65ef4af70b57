"""The filter's kernels beside slow references: matrix exponentials, dense algebra, finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from simulation_tools.px4.estimation.kernels.correction import (
    correct,
    forget,
    fuse_components,
    fuse_yaw,
    inject,
    limit_biases,
    reset_yaw,
    yaw_row,
)
from simulation_tools.px4.estimation.kernels.prediction import integrate, propagate
from simulation_tools.px4.estimation.kernels.rotations import matrix, yaw_of
from simulation_tools.px4.estimation.kernels.states import ATTITUDE, ERROR_SIZE

DT = 0.008
GRAVITY = np.array([0.0, 0.0, 9.80665])


def skew(v):
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def rotation(x):
    turned = np.empty((3, 3))
    matrix(x[ATTITUDE : ATTITUDE + 4], turned)
    return turned


def a_state(rng):
    x = rng.standard_normal(16)
    x[ATTITUDE : ATTITUDE + 4] /= np.linalg.norm(x[ATTITUDE : ATTITUDE + 4])
    return x


def a_covariance(rng):
    root = rng.standard_normal((ERROR_SIZE, ERROR_SIZE))
    return root @ root.T + 0.1 * np.eye(ERROR_SIZE)


def stepped(x, rates, force):
    x, turned = x.copy(), np.empty((3, 3))
    integrate(x, rates, force, DT, turned)
    return x


@pytest.mark.table("seed", range(5))
def test_the_nominal_state_follows_the_equations_of_motion(seed):
    rng = np.random.default_rng(seed)
    x, rates, force = a_state(rng), rng.standard_normal(3), 10.0 * rng.standard_normal(3)
    found = stepped(x, rates, force)
    turned = rotation(x) @ expm(skew((rates - x[13:16]) * DT))
    velocity = x[3:6] + (turned @ (force - x[10:13]) + GRAVITY) * DT
    assert rotation(found) == pytest.approx(turned, abs=1e-12)
    assert found[3:6] == pytest.approx(velocity, abs=1e-12)
    assert found[:3] == pytest.approx(x[:3] + 0.5 * (x[3:6] + velocity) * DT, abs=1e-12)
    assert found[10:].tolist() == x[10:].tolist()


def transition(x, force):
    """F of Sola's section 7.2.2, dense."""
    turned, f = rotation(x), np.eye(ERROR_SIZE)
    f[0:3, 3:6] = DT * np.eye(3)
    f[3:6, 6:9] = -DT * skew(turned @ (force - x[10:13]))
    f[3:6, 9:12] = f[6:9, 12:15] = -DT * turned
    return f


@pytest.mark.table("seed", range(5))
def test_the_covariance_is_propagated_as_by_dense_matrices(seed):
    rng = np.random.default_rng(seed)
    x, p, force = a_state(rng), a_covariance(rng), 10.0 * rng.standard_normal(3)
    noise = np.array([0.35, 0.015, 0.003, 0.001])
    f = transition(x, force)
    # Rows one after the other: position takes the old velocity, velocity the old rotation and biases.
    expected = f @ p @ f.T
    expected += np.diag(np.repeat([0.0, noise[0], noise[1], noise[2], noise[3]], 3) * DT) ** 2
    propagate(p, x, rotation(x), force, DT, noise)
    assert p == pytest.approx(expected, rel=1e-10, abs=1e-10)


@pytest.mark.table("seed", range(3))
def test_the_transition_is_the_derivative_of_the_motion(seed):
    """Errors put in before a step, and found after it; F is exact to first order in dt."""
    rng = np.random.default_rng(seed)
    x, rates, force = a_state(rng), rng.standard_normal(3), 10.0 * rng.standard_normal(3)
    small, found = 1e-6, np.empty((ERROR_SIZE, ERROR_SIZE))
    for i in range(ERROR_SIZE):
        disturbed = x.copy()
        inject(disturbed, small * np.eye(ERROR_SIZE)[i])
        found[:, i] = error(stepped(disturbed, rates, force), stepped(x, rates, force)) / small
    assert found == pytest.approx(transition(x, force), abs=20.0 * DT**2)


def error(true, known):
    """The error state between two nominal states."""
    between = rotation(true) @ rotation(known).T
    turn = 0.5 * np.array(
        [between[2, 1] - between[1, 2], between[0, 2] - between[2, 0], between[1, 0] - between[0, 1]]
    )
    return np.concatenate((true[:6] - known[:6], turn, true[10:] - known[10:]))


@pytest.mark.table("seed", range(5))
def test_a_correction_is_the_textbooks(seed):
    rng = np.random.default_rng(seed)
    x, p, row = a_state(rng), a_covariance(rng), rng.standard_normal(ERROR_SIZE)
    before, innovation, variance = x.copy(), 0.01, 0.3
    total = row @ p @ row + variance
    gain = p @ row / total
    expected = (np.eye(ERROR_SIZE) - np.outer(gain, row)) @ p
    correct(x, p, row, innovation, total)
    assert p == pytest.approx(expected, abs=1e-9)
    assert error(x, before) == pytest.approx(gain * innovation, abs=1e-4)


@pytest.mark.table("seed", range(5))
def test_the_row_of_a_heading_is_its_derivative(seed):
    x, row, small = a_state(np.random.default_rng(seed)), np.empty(ERROR_SIZE), 1e-7
    yaw_row(x, row)
    for i in range(ERROR_SIZE):
        disturbed = x.copy()
        inject(disturbed, small * np.eye(ERROR_SIZE)[i])
        slope = (yaw_of(disturbed[ATTITUDE:10]) - yaw_of(x[ATTITUDE:10])) / small
        assert row[i] == pytest.approx(slope, abs=1e-5)


def test_components_are_taken_all_or_none():
    x, p = np.zeros(16), np.eye(ERROR_SIZE)
    x[ATTITUDE] = 1.0
    # Innovations of 1 and 4 standard deviations of the innovation, sqrt(1 + 3) = 2 m; the gate is 5.
    assert fuse_components(x, p, 0, np.array([2.0, 8.0]), np.full(2, 3.0), 5.0) == pytest.approx(0.64)
    assert x[:2] == pytest.approx([0.5, 2.0])  # a gain of 1 / 4
    assert np.diag(p)[:3] == pytest.approx([0.75, 0.75, 1.0])
    held = x.copy()
    assert fuse_components(x, p, 0, np.array([0.5, 99.0]), np.full(2, 3.0), 5.0) > 1.0
    assert not fuse_components(x, p, 0, np.array([np.nan, 2.0]), np.full(2, 3.0), 5.0) <= 1.0
    assert x.tolist() == held.tolist()


def test_a_heading_beyond_the_gate_is_rejected_or_clipped():
    x, p = np.zeros(16), 0.01 * np.eye(ERROR_SIZE)
    x[ATTITUDE] = 1.0
    assert fuse_yaw(x, p, 2.0, 0.03, 2.5, False) == pytest.approx((2.0 / 0.5) ** 2)
    assert yaw_of(x[ATTITUDE:10]) == 0.0
    fuse_yaw(x, p, 2.0, 0.03, 2.5, True)
    assert yaw_of(x[ATTITUDE:10]) == pytest.approx(0.5 / 4.0)  # 2.5 * 0.2 rad, at a gain of 1 / 4
    fuse_yaw(x, p, np.nan, 0.03, 2.5, True)
    assert np.isfinite(x).all()


def test_biases_and_their_variances_keep_within_limits():
    x, p = np.arange(16.0), np.diag(np.arange(15.0))
    before_x, before_p = x.copy(), p.copy()
    limit_biases(x, p, 11.5, 10.5)
    assert x[10:13].tolist() == [10.0, 11.0, 11.5]
    assert np.diag(p)[9:12].tolist() == [10.5, 10.5, 11.0]
    x[10:13], p[9:12] = before_x[10:13], before_p[9:12]
    assert x.tolist() == before_x.tolist()
    assert p.tolist() == before_p.tolist()
    x *= -1.0
    limit_biases(x, p, 10.5, 0.0)
    assert x[10:13].tolist() == [-10.0, -10.5, -10.5]


def test_a_reset_forgets_correlations():
    rng = np.random.default_rng(1)
    x, p, turn = a_state(rng), a_covariance(rng), np.empty(4)
    before = rotation(x)
    forget(p, 3, np.array([4.0, 5.0]))
    assert np.diag(p)[3:5].tolist() == [4.0, 5.0]
    assert np.abs(p[3:5]).sum() == np.abs(p[:, 3:5]).sum() == 9.0
    reset_yaw(x, p, 1.0, 0.04, turn)
    assert yaw_of(x[ATTITUDE:10]) == pytest.approx(1.0)
    assert rotation(x)[2] == pytest.approx(before[2])  # the tilt stays
    assert p[8, 8] == 0.04


numbers = st.floats(-20.0, 20.0)


@given(st.lists(st.tuples(st.integers(0, 3), numbers, numbers, numbers), min_size=1, max_size=40))
def test_the_covariance_stays_symmetric_and_positive(steps):
    x, p = np.zeros(16), np.diag(np.repeat([0.25, 0.25, 0.01, 0.04, 0.01], 3))
    x[ATTITUDE] = 1.0
    noise, turned = np.array([0.35, 0.015, 0.003, 0.001]), np.empty((3, 3))
    for kind, a, b, c in steps:
        if kind == 0:
            integrate(x, np.array([a, b, c]), np.array([c, a, -9.8]), DT, turned)
            propagate(p, x, turned, np.array([c, a, -9.8]), DT, noise)
        elif kind == 1:
            fuse_components(x, p, 0, np.array([a, b, c]), np.full(3, 1e-4), 5.0)
        elif kind == 2:
            fuse_yaw(x, p, a, 1e-4, 2.6, True)
        else:
            fuse_components(x, p, 3, np.array([a]), np.full(1, 1e-4), 3.0)
    assert np.isfinite(x).all()
    assert p == pytest.approx(p.T, abs=1e-9)
    assert np.linalg.eigvalsh(p).min() > -1e-9
    assert np.linalg.norm(x[ATTITUDE : ATTITUDE + 4]) == pytest.approx(1.0)
