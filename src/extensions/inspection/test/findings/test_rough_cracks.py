"""Given a rough surface (grain as dark as a crack), long winding ridges are cracks; else none."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from scipy.spatial import cKDTree

from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import candidates_in
from inspection.findings.picture.kernels import ridge_strength
from inspection.findings.picture.ridges import STRONG, ridges_above_usual
from inspection.findings.picture.rough_cracks import ridge_of, two_sided

PARAMETERS = FindingParameters()
SIDE = 320


def grain(seed, side=SIDE):
    """A picture of stones of some 3 px."""
    rng = np.random.default_rng(seed)
    stones = ndimage.gaussian_filter(rng.normal(size=(side, side)), 1.2)
    return 110.0 * np.exp(0.22 * stones / stones.std())


def shot(light, lines=(), depth=0.6):
    """The picture with dark lines through places (n, 2), x, y."""
    light = light.copy()
    for line in lines:
        steps = np.linspace(0, len(line) - 1, 2000)
        x, y = (np.interp(steps, np.arange(len(line)), np.array(line)[:, k]) for k in range(2))
        near = np.zeros(light.shape, bool)
        near[np.rint(y).astype(int), np.rint(x).astype(int)] = True
        light[ndimage.binary_dilation(near)] *= 1.0 - depth
    return np.clip(light, 0, 255).astype(np.uint8)[..., None].repeat(3, axis=2)


def winding(seed=4):
    rng = np.random.default_rng(seed)
    x = np.linspace(30, 290, 40)
    return np.column_stack((x, 160 + np.cumsum(rng.normal(0.0, 4.0, 40))))


def by_hand(values, factor):
    out = np.zeros(values.shape)
    for y in range(1, values.shape[0] - 1):
        for x in range(1, values.shape[1] - 1):
            v = values[y - 1 : y + 2, x - 1 : x + 2].astype(float)
            xy = (v[0, 0] + v[2, 2] - v[0, 2] - v[2, 0]) / 4.0
            matrix = [[v[1, 0] - 2 * v[1, 1] + v[1, 2], xy], [xy, v[0, 1] - 2 * v[1, 1] + v[2, 1]]]
            out[y, x] = factor * max(np.linalg.eigvalsh(matrix).max(), 0.0)
    return out


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1))
def test_strength_is_the_largest_eigenvalue(seed):
    values = np.random.default_rng(seed).normal(size=(12, 9)).astype(np.float32)
    np.testing.assert_allclose(ridge_strength(values, 4.0), by_hand(values, 4.0), rtol=1e-4, atol=1e-5)


def test_a_ridge_of_gauss_answers_as_closed_form_has_it():
    x = np.mgrid[-30.0:31.0, -30.0:31.0][1]
    values = -np.exp(-0.5 * (x / 3.0) ** 2).astype(np.float32)  # at its middle the second derivative is 1 / 9
    assert ridge_strength(values, 9.0)[30, 30] == pytest.approx(1.0, rel=0.06)


@pytest.mark.table("seed", range(6))
def test_grain_alone_is_no_crack(seed):
    assert [each for each in candidates_in(shot(grain(seed)), PARAMETERS) if each.kind == "crack"] == []


def share_found(line, places):
    """The share of a line, (n, 2) x, y, that has a marked place nearby."""
    steps = np.linspace(0, len(line) - 1, 100)
    on_line = np.column_stack([np.interp(steps, np.arange(len(line)), line[:, k]) for k in range(2)])
    return np.mean(cKDTree(places).query(on_line)[0] < 6.0)


@pytest.mark.table("seed", range(3))
def test_a_winding_crack_is_found_all_along(seed):
    line = winding(seed + 10)
    found = [each for each in candidates_in(shot(grain(seed), [line]), PARAMETERS) if each.kind == "crack"]
    places = np.concatenate([each.pixels for each in found])
    off = np.abs(places[:, 1] - np.interp(places[:, 0], line[:, 0], line[:, 1]))
    assert np.mean(off < 5.0) > 0.9
    assert share_found(line, places) > 0.7


def test_a_net_of_cracks_is_found():
    across = winding(3)
    lines = [winding(1), winding(2) + np.array((0, 60)), across[:, ::-1]]
    places = np.concatenate([each.pixels for each in candidates_in(shot(grain(7), lines), PARAMETERS)])
    assert min(share_found(line, places) for line in lines) > 0.5


def test_a_joint_is_none():
    joint = np.array([(20, 40.0), (300, 150.0)])
    assert candidates_in(shot(grain(3), [joint]), PARAMETERS) == []


def test_a_plain_surface_has_no_ridge():
    light = np.full((100, 120), 0.4, np.float32) * (1.0 + np.linspace(0.0, 0.2, 120, dtype=np.float32))
    assert ridges_above_usual(light, 1.0).max() < STRONG


@pytest.mark.table(("left", "right", "share"), [(1.0, 1.0, 1.0), (0.6, 1.0, 1 / 3), (0.4, 1.0, 0.0)])
def test_both_sides_of_a_line_are_alike_and_those_of_a_step_are_not(left, right, share):
    """The line has the light 0.4, so the share is (left - 0.4) / (right - 0.4)."""
    light = np.tile(np.where(np.arange(60) < 30, left, right), (60, 1))
    light[:, 30] = 0.4
    column = np.column_stack((np.full(20, 30), np.arange(20, 40)))
    assert two_sided(column, light) == pytest.approx(share)


def test_salience_is_length_times_the_strongest_place_of_each_part():
    column = np.column_stack((np.full(32, 7), np.arange(32)))
    above = np.full((40, 40), 2.0)
    above[[1, 9, 17, 25], 7] = 6.0
    ridge = ridge_of(column, above)
    assert ridge == pytest.approx((31.0, 0.0, 31.0 * 6.0), abs=1e-9)


def paving(seed, stones=5, joint_px=14):
    """A rough pavement of stones, with wide dark joints that wind a little."""
    light = grain(seed, 480)
    y, x = np.mgrid[:480, :480].astype(float)
    rng = np.random.default_rng(seed)
    sway = [ndimage.gaussian_filter(rng.normal(size=(480, 480)), 25) for _ in range(2)]
    side = 480.0 / stones
    off = [np.abs((each + 250.0 * sway[k]) % side - side / 2) for k, each in enumerate((x, y))]
    light[np.minimum(*off) < joint_px / 2] *= 0.35
    return light


@pytest.mark.table("seed", range(3))
def test_a_pavement_has_edges_of_joints_and_no_crack(seed):
    found = [each for each in candidates_in(shot(paving(seed)), PARAMETERS) if each.kind == "crack"]
    assert len(found) == 0
