"""How much of what a photograph is to show is white or black, and with which exposure less of it would be."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from inspection.photographs.exposure import BLACK, WHITE, at, blocks_of

BIASES_EV = np.arange(-12, 13) / 3.0
"""That are tried for the next photograph: thirds of a stop, as cameras have them."""
BEYOND_EV = 2.0
"""What is white counts as so much brighter than white, and what is black as so much darker than black."""
AS_GOOD = 0.002
"""An exposure that loses so much more than the best one is as good."""


class Metering(NamedTuple):
    """What an exposure has lost.

    lost: share of what is asked for, 0..1, that is white or black. change_ev: of the exposure, with which
    least of it would be; 0: none is better.
    """

    lost: float
    change_ev: float


def metering(picture: np.ndarray, pixels: np.ndarray, areas: np.ndarray) -> Metering:
    """Return it of a picture, uint8 (height, width, 3).

    pixels: (n, 2), x and y, of what is asked for. areas: (n,) that each stands for.
    """
    if not len(pixels) or not areas.sum() > 0.0:
        return Metering(0.0, 0.0)
    blocks = blocks_of(picture)
    darkest, brightest = at(blocks.min(axis=2), pixels), at(blocks.max(axis=2), pixels)
    least = np.where(darkest >= WHITE, 2.0**BEYOND_EV, 1.0) * linear(darkest)
    most = np.where(brightest <= BLACK, 2.0**-BEYOND_EV * linear(np.array(BLACK)), linear(brightest))
    white, black = linear(np.array(WHITE)), linear(np.array(BLACK))

    def lost(change_ev: float) -> float:
        factor = 2.0**change_ev
        is_lost = (factor * least >= white) | (factor * most <= black)
        return float(areas[is_lost].sum() / areas.sum())

    losses = np.array([lost(each) for each in BIASES_EV])
    good = BIASES_EV[losses <= losses.min() + AS_GOOD]
    return Metering(lost(0.0), float(good[np.argmin(np.abs(good))]))


def linear(values: np.ndarray) -> np.ndarray:
    """Return the light, 0..1, of sRGB values 0..255 (IEC 61966-2-1)."""
    share = np.asarray(values, float) / 255.0
    light: np.ndarray = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return light
