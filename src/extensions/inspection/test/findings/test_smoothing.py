"""Given an image, smoothing by rows answers as scipy's; a large rough picture needs little memory."""

import tracemalloc

import numpy as np
import pytest
from scipy import ndimage

from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import candidates_in
from inspection.findings.picture.kernels import mean_colour
from inspection.findings.picture.ridges import ridges_above_usual
from inspection.findings.picture.smoothing import gaussian_weights, smoothed, smoothed_rows


@pytest.mark.table("shape", [(40, 60), (3, 4), (1, 9), (5, 1)])
@pytest.mark.table("deviation_px", [1.0, 2.83])
def test_smoothing_is_that_of_scipy(shape, deviation_px):
    values = np.random.default_rng(1).random(shape, np.float32)
    expected = ndimage.gaussian_filter(values, deviation_px, truncate=3.0)
    np.testing.assert_allclose(smoothed(values, deviation_px, 3.0), expected, rtol=3e-7)


def test_some_rows_are_those_of_the_whole():
    values = np.random.default_rng(2).random((30, 20), np.float32)
    weights = gaussian_weights(1.5, 3.0)
    np.testing.assert_array_equal(smoothed_rows(values, weights, 7, 19), smoothed(values, 1.5, 3.0)[7:19])


def multiples_by_scipy(light):
    """The strength of ridges as a multiple of what is usual, each step over the whole picture."""
    above = np.zeros(light.shape)
    for scale in (1.5, 2.0, 3.0):
        image = ndimage.gaussian_filter(np.log(light + 0.003), np.sqrt(scale**2 - 1.0), truncate=3.0)
        yy, xx = (ndimage.correlate1d(image, [1, -2, 1], axis) for axis in (0, 1))
        xy = ndimage.correlate1d(ndimage.correlate1d(image, [-0.5, 0, 0.5], 0), [-0.5, 0, 0.5], 1)
        strength = scale**2 * np.maximum(0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), xy), 0.0)
        strength[[0, -1]] = strength[:, [0, -1]] = 0.0
        rows, columns = (size // 32 for size in light.shape)
        blocks = strength[: rows * 32, : columns * 32].reshape(rows, 32, columns, 32)[:, ::2, :, ::2]
        usual = ndimage.median_filter(np.percentile(blocks, 75, axis=(1, 3)), 5, mode="nearest")
        places = np.mgrid[: light.shape[0], : light.shape[1]]
        around = ndimage.map_coordinates(usual, (places + 0.5) / 32 - 0.5, order=1, mode="nearest")
        above = np.maximum(above, strength / np.maximum(around, 0.004))
    return above


def test_ridges_are_those_of_a_picture_that_is_taken_as_a_whole():
    light = ndimage.gaussian_filter(np.random.default_rng(3).random((200, 150), np.float32), 1.0)
    found = ridges_above_usual(light, 1.0)
    np.testing.assert_allclose(found, multiples_by_scipy(light), rtol=2e-3, atol=2e-3)


def test_a_rough_picture_needs_24_bytes_a_pixel():
    # 500 MB for 12 MP, of which 210 MB are the program itself
    grey = np.random.default_rng(4).integers(60, 200, (700, 1000, 1)).astype(np.uint8)
    picture = np.repeat(grey, 3, axis=2)
    candidates_in(picture[:64, :64], FindingParameters().for_pictures())
    tracemalloc.start()
    try:
        candidates_in(picture, FindingParameters().for_pictures())
        assert tracemalloc.get_traced_memory()[1] < 24 * grey.size
    finally:
        tracemalloc.stop()


def test_the_mean_of_three_colours_has_the_last_bit_of_numpy():
    light = np.random.default_rng(5).random((40, 30, 3), np.float32)
    np.testing.assert_array_equal(mean_colour(light), light.mean(axis=2))
