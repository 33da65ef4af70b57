"""Given red things that are no rust, hue, texture and surroundings tell them apart from rust."""

import numpy as np
import pytest
from scipy import ndimage

from inspection.findings.parameters import FindingParameters
from inspection.findings.picture import rust_texture
from inspection.findings.picture.candidates import candidates_in
from inspection.findings.picture.kernels import block_texture

GREY, RUST, RED, OCHRE = (150, 152, 150), (150, 85, 50), (170, 25, 25), (150, 95, 30)
HEIGHT, WIDTH = 240, 320


def drawn(colour, size_px, mottled=0.0, lines=0, wall=GREY, uneven=0.0, times=1):
    """A square of a colour on a wall. mottled, uneven: share by which their light varies, pixel by pixel and
    in patches of 20 px. lines: px between dark level and upright ones in it. times: enlarges the picture."""
    rng = np.random.default_rng(3)
    patches = ndimage.zoom(rng.normal(size=(HEIGHT // 20, WIDTH // 20)), 20, order=0)
    picture = np.array(wall) * np.exp(uneven * patches)[..., None]
    top, left = (HEIGHT - size_px) // 2, (WIDTH - size_px) // 2
    inside = np.s_[top : top + size_px, left : left + size_px]
    light = np.exp(mottled * ndimage.gaussian_filter(rng.normal(size=(size_px, size_px)), 0.7) * 2.0)
    if lines:
        light[::lines] *= 0.5
        light[:, ::lines] *= 0.5
    picture[inside] = np.array(colour) * light[..., None]
    picture = np.clip(picture + rng.normal(0.0, 1.5, picture.shape), 0, 255).astype(np.uint8)
    return np.kron(picture, np.ones((times, times, 1), np.uint8))


def rust_px(picture, **parameters):
    found = candidates_in(picture, FindingParameters(**parameters).for_pictures())
    return sum(each.size_px for each in found if each.kind == "rust")


@pytest.mark.table("times", [1, 2])
def test_mottled_brown_is_rust_and_even_red_paint_is_not_in_any_size(times, monkeypatch):
    monkeypatch.setattr(rust_texture, "COPY_PIXELS", HEIGHT * WIDTH)
    rust = drawn(RUST, 120, 0.15, uneven=0.4, times=times)
    assert rust_px(rust) == pytest.approx((120 * times) ** 2, rel=0.1)
    assert rust_px(drawn(RED, 120, times=times)) == 0


def test_what_has_the_texture_but_is_as_red_as_paint_is_not():
    assert rust_px(drawn(RED, 120, 0.15)) == 0


def test_even_brown_on_an_uneven_wall_with_a_pattern_of_lines_is_not():
    assert rust_px(drawn(RUST, 120, 0.02, lines=16, uneven=0.4)) == 0


def test_a_small_spot_is_rust_on_an_even_surface_only():
    assert rust_px(drawn(RUST, 20, 0.15)) == pytest.approx(20**2, rel=0.5)
    assert rust_px(drawn(RUST, 20, 0.15, uneven=0.6)) == 0


def test_a_picture_that_is_all_even_red_tells_nothing_of_rust():
    assert rust_px(drawn(RED, 120, wall=RED)) == 0
    found = candidates_in(drawn(RED, 120, wall=RED), FindingParameters().for_pictures())
    assert [each.kind for each in found if each.kind != "crack"] == []


def test_photographs_of_a_mesh_are_judged_by_colour():
    """There the surface is known, and a smooth drawn spot stays rust."""
    found = candidates_in(drawn(RUST, 120, lines=16, uneven=0.4), FindingParameters())
    assert sum(each.size_px for each in found if each.kind == "rust") == pytest.approx(120**2, rel=0.1)


def test_the_texture_of_blocks_is_that_of_numpy():
    values = np.random.default_rng(1).normal(size=(24, 36)).astype(np.float32)
    spread, edges, along = block_texture(values, 4)

    def mean(each):
        return each.reshape(6, 4, 9, 4).mean(axis=(1, 3))

    gy, gx = (ndimage.sobel(values.astype(float), axis, mode="nearest") / 8.0 for axis in (0, 1))
    square = gx**2 + gy**2
    np.testing.assert_allclose(spread**2, mean(values.astype(float) ** 2) - mean(values) ** 2, atol=1e-5)
    np.testing.assert_allclose(edges, mean(square), rtol=1e-4)
    np.testing.assert_allclose(along, mean(square * np.cos(4.0 * np.arctan2(gy, gx))), atol=1e-5)
