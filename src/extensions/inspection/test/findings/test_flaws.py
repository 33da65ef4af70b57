"""Given a picture that is black, white, blurred or written upon, it is told; writing is no finding."""

import json
import math
import struct
import zlib

import numpy as np
import pytest
from PIL import Image, ImageDraw, ImageFont
from scipy import ndimage

from inspection.findings.command import main
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import candidates_in
from inspection.findings.picture.flaws import (
    BLURRED,
    CONVERTED,
    WRITTEN,
    FlawCounter,
    blur_ratio,
    check_shows,
    flaws_in,
)
from inspection.findings.picture.stamps import writing_in
from inspection.photographs.listing import read_picture
from inspection.photographs.record import PhotographError

TEXTURE = ndimage.gaussian_filter(np.random.default_rng(1).normal(size=(480, 640)), 0.8)
PLATE = np.clip(120 + 60 * TEXTURE, 0, 255).astype(np.uint8)[..., None].repeat(3, axis=2)


def stamped(picture, colour, text="2021-07-14 12:33", place=(300, 440)):
    image = Image.fromarray(picture)
    ImageDraw.Draw(image).text(place, text, fill=colour, font=ImageFont.load_default(28))
    return np.array(image)


@pytest.mark.table("colour", [(255, 140, 0), (255, 255, 255), (255, 60, 20), (0, 0, 0)])
@pytest.mark.table("place", [(300, 440), (10, 5)])
def test_a_stamp_is_told_and_its_digits_are_nothing(colour, place):
    even = np.full((480, 640, 3), 120, np.uint8)
    picture = stamped(even, colour, place=place)
    left = (picture != even).any(axis=2)
    for box in writing_in(picture):
        left[box.top : box.bottom, box.left : box.right] = False
    assert not left.any()
    assert WRITTEN in flaws_in(picture)
    assert candidates_in(picture, FindingParameters()) == []


def test_other_things_are_no_writing():
    assert writing_in(PLATE) == []
    rust = PLATE.copy()
    rust[450:470, 100:500:40] = (140, 60, 20)
    assert writing_in(rust) == []  # spots without strokes


def moved(picture, length, axis):
    return ndimage.uniform_filter1d(picture.astype(float), length, axis=axis).astype(np.uint8)


@pytest.mark.table("axis", [0, 1])
def test_motion_blur_is_told(axis):
    rng = np.random.default_rng(2)
    blocks = np.kron(rng.integers(60, 200, (12, 16)), np.ones((40, 40))).astype(np.uint8)
    sharp = blocks[..., None].repeat(3, axis=2)
    assert BLURRED not in flaws_in(sharp)
    assert BLURRED in flaws_in(moved(sharp, 21, axis))


@pytest.mark.table("axis", [0, 1])
def test_edges_that_lie_far_apart_differ_by_the_distance(axis):
    stripes = np.where(np.arange(1200) // 50 % 2, 60, 180)[:, None, None] * np.ones((1, 1200, 3))
    # Across an edge F that a Gaussian smoothed, the integral of (F(x + l) - F(x))^2 is
    # E|l + X - Y| - E|X - Y|.
    near, far = (
        2.0 / math.sqrt(math.pi) * (math.exp(-(lag**2) / 4.0) - 1.0) + lag * math.erf(lag / 2.0)
        for lag in (2, 8)
    )
    assert blur_ratio(np.moveaxis(stripes, 0, axis).astype(np.uint8)) == pytest.approx(near / far, rel=0.03)
    assert blur_ratio(np.full((100, 100, 3), 90, np.uint8)) == 1.0  # nothing to judge by


@pytest.mark.table("value", [0, 255])
def test_black_and_white_pictures_are_left_out(tmp_path, value, capsys):
    Image.fromarray(PLATE).save(tmp_path / "plate.png")
    Image.fromarray(np.full_like(PLATE, value)).save(tmp_path / "lost.png")
    Image.fromarray(PLATE).convert("CMYK").save(tmp_path / "inks.jpg")
    assert main([str(tmp_path)]) == 0
    content = json.loads((tmp_path / "findings.json").read_text())
    assert [each["photograph"] for each in content["left_out"]] == ["lost.png"]
    assert ("black" if value == 0 else "white") in content["left_out"][0]["why"]
    assert content["flawed"] == [{"photograph": "inks.jpg", "why": CONVERTED}]
    assert f"1 photographs: inks.jpg: {CONVERTED}" in capsys.readouterr().err


@pytest.mark.table("size", [(1, 1), (3, 200), (31, 640)])
def test_a_picture_that_is_too_small_to_show_anything_is_told(tmp_path, size, capsys):
    Image.new("RGB", size, (140, 60, 30)).save(tmp_path / "ä 1.png")
    assert main([str(tmp_path)]) == 1
    assert f"It has {size[0]} x {size[1]} px" in capsys.readouterr().err
    with pytest.raises(PhotographError, match="needs 32 x 32 px at least"):
        check_shows(np.full((size[1], size[0], 3), 120, np.uint8), "ä 1.png")


def test_sixteen_bits_for_each_colour_are_told(tmp_path):
    """A PNG by hand, because Pillow writes none: of each value the upper byte counts."""
    rows = b"".join(
        b"\0" + np.repeat(row[:, 1], 3).astype(">u2").tobytes() for row in PLATE.astype(int) * 257
    )
    parts = {
        b"IHDR": struct.pack(">IIBBBBB", 640, 480, 16, 2, 0, 0, 0),
        b"IDAT": zlib.compress(rows),
        b"IEND": b"",
    }
    chunks = (
        struct.pack(">I", len(c)) + k + c + struct.pack(">I", zlib.crc32(k + c)) for k, c in parts.items()
    )
    (tmp_path / "deep.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))
    picture = read_picture(tmp_path / "deep.png")
    np.testing.assert_array_equal(picture, PLATE)
    assert flaws_in(picture, tmp_path / "deep.png") == (CONVERTED,)


def test_the_detector_tells_each_flaw_with_the_number_of_pictures_that_have_it():
    """As the node `detector` warns: picture by picture, and none that shows nothing is marked."""
    counter = FlawCounter()
    assert counter.report_on("plate.jpg", PLATE) == (True, ())
    written = stamped(np.full((480, 640, 3), 120, np.uint8), (255, 140, 0))
    for number in (1, 2):
        said = f"{number}.jpg: {WRITTEN} Such photographs so far: {number}."
        assert counter.report_on(f"{number}.jpg", written) == (True, (said,))
    black, white = (np.full_like(PLATE, value) for value in (0, 255))
    for number, (picture, tone) in enumerate(((black, "black"), (white, "white")), 1):
        shows, (said,) = counter.report_on("lost.jpg", picture)
        assert not shows
        assert said.startswith(f"lost.jpg: it is {tone} all over.")
        assert said.endswith(f"Such photographs so far: {number}.")
