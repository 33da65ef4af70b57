"""Given lines in a picture of anything, only those that lie in one surface may be cracks."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage

from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import candidates_in
from inspection.findings.picture.cracks import Marked, unlike_marked
from inspection.findings.picture.kernels import block_means
from inspection.findings.picture.one_surface import may_be_crack, straight_part, surroundings

SIDE = 320
PARAMETERS = FindingParameters().for_pictures()
ANYWHERE = replace(PARAMETERS, crack_surface=False)


def grain(seed):
    """A rough grey surface: sRGB values (SIDE, SIDE)."""
    stones = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=(SIDE, SIDE)), 1.2)
    return 110.0 * np.exp(0.15 * stones / stones.std())


def winding(seed, turn=4.0):
    """A line (n, 2), x, y, from one border to the other."""
    x = np.linspace(0, SIDE - 1, 60)
    return np.column_stack((x, 160 + np.cumsum(np.random.default_rng(seed).normal(0.0, turn, 60))))


def with_lines(light, lines, depth=0.6):
    light = light.copy()
    steps = np.linspace(0, SIDE - 1, 2000)
    for line in lines:
        near = np.zeros(light.shape, bool)
        y = np.clip(np.rint(np.interp(steps, *line.T)), 0, SIDE - 1).astype(int)
        near[y, np.rint(steps).astype(int)] = True
        light[ndimage.binary_dilation(near)] *= 1.0 - depth
    return light


def picture(light, shares=(1.0, 1.0, 1.0), where=None):
    """sRGB, uint8: the light, and of another colour at some places."""
    colours = np.ones((SIDE, SIDE, 3))
    if where is not None:
        colours[where] = shares
    return np.clip(light[..., None] * colours, 0, 255).astype(np.uint8)


def count(shot, parameters=PARAMETERS):
    return sum(each.kind == "crack" for each in candidates_in(shot, parameters))


@pytest.mark.table("seed", range(2))
def test_a_crack_in_one_surface_is_found(seed):
    assert count(picture(with_lines(grain(seed), [winding(seed)]))) >= 1


def rows(seed, step, turn):
    """Lines one below another."""
    tops = range(step // 2, SIDE, step)
    return [winding(100 * seed + k, turn) + np.array((0, top - 160)) for k, top in enumerate(tops)]


@pytest.mark.table("seed", range(2))
def test_joints_between_stone_and_moss_are_none(seed):
    joints = rows(seed, 80, 4.0)
    y, x = np.mgrid[:SIDE, :SIDE]
    moss = sum(y > np.interp(x, *line.T) for line in joints) % 2 == 1
    light = with_lines(np.where(moss, 0.9, 1.0) * grain(seed), joints)
    shot = picture(light, (0.9, 1.0, 0.3), moss)
    assert count(shot) == 0
    assert count(shot, ANYWHERE) > 0


@pytest.mark.table("seed", range(2))
def test_stalks_in_light_and_shade_are_none(seed):
    shade = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=(SIDE, SIDE)), 20)
    light = grain(seed) * np.exp(0.5 * shade / shade.std())
    shot = picture(with_lines(light, rows(seed, 24, 1.5)))
    assert count(shot) == 0
    assert count(shot, ANYWHERE) > 0


def test_surroundings_by_closed_form():
    """Beside a dark column the shares of red, green and blue are 1/3 each, and 1/2, 1/4, 1/4."""
    colours = np.full((100, 100, 3), 92.0)
    colours[:, 50:] = (192.0, 92.0, 92.0)  # 8 is added to each value
    light = np.full((100, 100), 0.5)
    light[:, 50] = 0.1
    column = np.column_stack((np.full(60, 50), np.arange(20, 80)))
    around = surroundings(column, light, colours)
    assert around.colour == pytest.approx(1 / 6 + 2 / 12)
    assert around.straight == 1.0
    even = np.full(100, 0.5)
    even[46:55] = (8 * 0.5 + 0.1) / 9
    assert around.varying == pytest.approx(np.log(even[20:80] + 0.01).std())


def test_the_longest_straight_part_is_between_two_turns():
    """The turns are at 81 and 163 of 245 px, and the course is known every 8 px."""
    x = np.arange(245)
    bent = np.interp(x, (0, 81, 163, 245), (0, 40, -40, 0))
    assert straight_part(np.column_stack((x, bent))) == pytest.approx(1 / 3, abs=0.05)
    assert straight_part(np.column_stack((x, 0.3 * x))) == 1.0


def test_each_sign_of_another_thing_speaks_against_a_crack():
    crack = surroundings(*_on_a_plain_wall())
    assert may_be_crack(crack, 45)
    assert not may_be_crack(crack, 1000)
    for name, value in (("colour", 0.119), ("straight", 1.0), ("varying", 2.0)):
        assert not may_be_crack(crack._replace(**{name: value}), 45), name
    assert may_be_crack(crack._replace(colour=0.119), 1)
    assert not may_be_crack(crack._replace(colour=0.121), 1)


def _on_a_plain_wall():
    line = winding(1)
    light = with_lines(np.full((SIDE, SIDE), 0.4), [line])
    x = np.arange(SIDE)
    return np.column_stack((x, np.interp(x, *line.T))), light, np.full((SIDE, SIDE, 3), 120.0)


def test_a_crack_of_20_px_is_found_in_a_large_picture_once():
    times = 5
    line = winding(1)
    small = with_lines(np.exp(0.3 * np.log(grain(1) / 110.0)) * 110.0, [line])
    large = ndimage.zoom(small, times, order=1) + np.random.default_rng(2).normal(
        0.0, 3.0, (5 * SIDE, 5 * SIDE)
    )
    shot = np.clip(large, 0, 255).astype(np.uint8)[..., None].repeat(3, axis=2)
    places = [each.pixels / times for each in candidates_in(shot, PARAMETERS) if each.kind == "crack"]
    assert len(places) == 1
    off = np.abs(places[0][:, 1] - np.interp(places[0][:, 0], *line.T))
    assert np.mean(off < 5.0) > 0.9
    assert np.ptp(places[0][:, 0]) > 0.7 * SIDE


def test_a_line_along_a_marked_one_is_the_same():
    x = np.arange(100.0)
    first, near, far = (Marked(np.column_stack((x, np.full(100, y))), 100) for y in (10.0, 14.0, 16.0))
    half_away = Marked(np.column_stack((x, np.where(x < 49, 10.0, 90.0))), 100)
    assert unlike_marked([near, far, half_away], [first], 5.0) == [far, half_away]
    assert unlike_marked([near], [], 5.0) == [near]


@pytest.mark.table("times", [2, 3, 5, 7])
def test_means_of_squares_have_the_last_bit_of_numpy(times):
    light = np.random.default_rng(3).random((45, 62), np.float32)
    rows, columns = 45 // times, 62 // times
    cut = light[: rows * times, : columns * times].reshape(rows, times, columns, times)
    np.testing.assert_array_equal(block_means(light, times), cut.mean(axis=(1, 3)))
