"""The exposure meter: what a photograph is to show becomes a middle grey, hardly any of it white or black.

What is asked for is what a pixel draws finely enough. It counts by its area, not by its pixels. So a near
stanchion does not make the plate behind it dark. A dark room behind a plate does not make the plate white.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

MIDDLE = 0.18
"""What the median becomes, as a share of white."""
BASE_ISO, MOST_ISO = 100.0, 25_600.0
SATURATION_LX_S = 0.78
"""Exposure that saturates a sensor at ISO 100 (ISO 12232: 78 / speed)."""
PASSED = 0.65
"""Of the light, through the lens (ISO 12232)."""
WHITE_FROM, BLACK_TO = 0.91, 0.0014
"""Shares of white from which, and up to which, a point tells nothing. They are those of sRGB 250 and 4, with
5 % and 15 % in reserve for the coating's grain and the noise."""
BIASES_EV = np.arange(-24, 25) / 3.0
"""That are tried: thirds of a stop, as cameras have them."""
AS_GOOD = 0.002
"""An exposure that loses so much more of the area than the best one is as good."""


class Seen(NamedTuple):
    """Points of a picture.

    middle, darkest, brightest: (n,) light that the lens passes, lux times albedo: as the eye weighs the
    colours, of the darkest channel and of the brightest. areas_m2: (n,) that stand for what is asked for,
    each as large as the surface behind it; 0: not asked for.
    """

    middle: np.ndarray
    darkest: np.ndarray
    brightest: np.ndarray
    areas_m2: np.ndarray


class Metered(NamedTuple):
    """An exposure.

    gain: from lux times albedo to a share of white. iso: that has it. lost: share of what is asked for, 0..1,
    that is white or black.
    """

    gain: float
    iso: float
    lost: float


def asked_m2(
    depths_m: np.ndarray, slants: np.ndarray, facing: np.ndarray, focal_px: float, detail_m: float
) -> np.ndarray:
    """Return the surface behind a pixel (n,), m2; 0 where a pixel covers more than the detail.

    depths_m: (n,) along the optical axis. slants: (n,) lengths of the lines of sight up to depth 1. facing:
    (n,) cosines of the incidence. detail_m: of what is asked for; 0: each point counts alike.
    """
    if detail_m <= 0.0:
        return np.ones(len(depths_m))
    facing = np.maximum(facing, 1e-3)
    across_m = depths_m / focal_px
    areas_m2: np.ndarray = np.where(across_m / facing <= detail_m, across_m**2 / (slants * facing), 0.0)
    return areas_m2


def meter(
    seen: Seen, exposure_s: float, f_number: float, bias_ev: float = 0.0, protects: bool = True
) -> Metered:
    """Return the exposure of points by the median of what is asked for; of all points if none is.

    bias_ev: exposure compensation; each step of 1 doubles the light. protects: before that, the exposure is
    changed by the least that keeps as much as possible of what is asked for from being white or black.
    """
    if not len(seen.middle):
        return Metered(0.0, MOST_ISO, 0.0)
    areas = seen.areas_m2 if seen.areas_m2.any() else np.ones(len(seen.areas_m2))
    base = PASSED * exposure_s / (np.pi * f_number**2 * SATURATION_LX_S)  # of ISO 100
    level = MIDDLE / max(_median(seen.middle, areas) * base, 1e-12)
    if protects:
        isos = np.clip(BASE_ISO * level * 2.0**BIASES_EV, BASE_ISO, MOST_ISO)
        losses = np.array([_lost(seen, areas, base * each / BASE_ISO) for each in isos])
        good = BIASES_EV[losses <= losses.min() + AS_GOOD]
        level *= 2.0 ** float(good[np.argmin(np.abs(good))])
    iso = float(np.clip(BASE_ISO * level * 2.0**bias_ev, BASE_ISO, MOST_ISO))
    gain = base * iso / BASE_ISO
    return Metered(gain, iso, _lost(seen, areas, gain))


def _median(values: np.ndarray, weights: np.ndarray) -> float:
    """Return the weighted median."""
    order = np.argsort(values)
    summed = np.cumsum(weights[order])
    half = 0.5 * summed[-1]
    low = int(np.searchsorted(summed, half, side="left"))
    high = int(np.searchsorted(summed, half, side="right"))
    high = min(high, len(order) - 1)
    return float(0.5 * (values[order[low]] + values[order[high]]))


def _lost(seen: Seen, areas: np.ndarray, gain: float) -> float:
    """Return the share of the areas that is white or black."""
    lost = (gain * seen.darkest >= WHITE_FROM) | (gain * seen.brightest <= BLACK_TO)
    return float(areas[lost].sum() / areas.sum())
