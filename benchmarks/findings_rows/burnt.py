"""Flaws that are put into pictures: a date and time burnt in, and motion. So one knows which must be told."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from scipy.signal import oaconvolve

TEXTS = ("2021-07-14 12:33:08", "'98 10 24", "14/07/2021 12:33", "2020.01.05 08:15 AM", "12-03-2019")
COLOURS = ((255, 140, 0), (255, 255, 255), (255, 220, 40), (255, 60, 20), (0, 0, 0))
HEIGHTS, LEAST_HEIGHT_PX = (0.03, 0.06), 14
"""Of the writing, as shares of the picture's height, and at least."""
BORDER = 0.02
"""From the picture's border, of its height."""
JPEG_QUALITY = 90
NOISE = 1.0
"""Standard deviation of a sensor's noise, of 255, which comes after the motion."""


@dataclass(frozen=True)
class Burnt:
    """Flaws that each picture gets. seed: of writing; None: none. motion_px: its length; 0: no motion."""

    seed: int | None = None
    motion_px: float = 0.0

    def into(self, picture: np.ndarray, number: int) -> np.ndarray:
        """Return a picture, uint8 (height, width, 3), with the flaws. number: of it; each has others."""
        rng = np.random.default_rng((self.seed or 0, number))
        if self.motion_px:
            picture = moved(picture, self.motion_px, rng.uniform(0.0, np.pi), rng)
        return picture if self.seed is None else stamped(picture, rng)


def stamped(picture: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a picture with a date at its upper or lower border, compressed as JPEG."""
    image = Image.fromarray(picture)
    draw, (height, width) = ImageDraw.Draw(image), picture.shape[:2]
    text, colour = TEXTS[rng.integers(len(TEXTS))], COLOURS[rng.integers(len(COLOURS))]
    size = max(LEAST_HEIGHT_PX, height * rng.uniform(*HEIGHTS))
    right, bottom = draw.textbbox((0, 0), text, font=ImageFont.load_default(size))[2:]
    size *= min(1.0, 0.9 * width / right)
    font = ImageFont.load_default(size)
    right, bottom = draw.textbbox((0, 0), text, font=font)[2:]
    border = BORDER * height
    place = (
        width - right - border if rng.random() < 0.6 else border,
        height - bottom - border if rng.random() < 0.7 else border,
    )
    draw.text(place, text, fill=colour, font=font)
    file = io.BytesIO()
    image.save(file, "JPEG", quality=JPEG_QUALITY)
    return np.array(Image.open(file).convert("RGB"))


def moved(picture: np.ndarray, length_px: float, angle: float, rng: np.random.Generator) -> np.ndarray:
    """Return a picture that a motion along a line has blurred, with noise. angle: of the line, rad."""
    reach = max(1, round(length_px))
    places = np.linspace(-0.5 * length_px, 0.5 * length_px, 8 * reach + 1)
    kernel = np.zeros((2 * reach + 1, 2 * reach + 1))
    rows, columns = (np.rint(reach + places * part).astype(int) for part in (np.sin(angle), np.cos(angle)))
    np.add.at(kernel, (rows, columns), 1.0 / len(places))
    padded = np.pad(picture.astype(float), ((reach, reach), (reach, reach), (0, 0)), mode="edge")
    blurred = oaconvolve(padded, kernel[..., None], mode="valid", axes=(0, 1))
    noisy: np.ndarray = np.clip(np.rint(blurred + rng.normal(0.0, NOISE, blurred.shape)), 0, 255)
    return noisy.astype(np.uint8)
