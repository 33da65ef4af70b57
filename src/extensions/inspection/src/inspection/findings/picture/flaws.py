"""What is wrong with a picture as a whole: nothing to see, motion blur, writing burnt into it."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import NamedTuple, Sequence

import numpy as np
from scipy import ndimage

from inspection.findings.picture.stamps import writing_in
from inspection.photographs.exposure import exposed_blocks
from inspection.photographs.listing import is_converted
from inspection.photographs.record import PhotographError

BLURRED = "It is blurred, so thin cracks may be missed."
WRITTEN = "Writing is burnt into it, such as a time. Nothing is looked for there."
CONVERTED = (
    "Its colours are stored as inks, a palette or 16 bits. They were converted, so rust may be missed."
)
LEAST_SIDE_PX = 32
"""A picture that is narrower shows neither a crack nor the texture of rust."""
LEAST_SHOWN = 0.02
"""Share of a picture that must be neither white nor black."""
WINDOW_PX = 1500
"""Side of the middle of a picture in which blur is measured: it is the same all over."""
SMOOTH_PX, DARK = 1.0, 8.0
"""Of what is compared: logarithms of sRGB values, to which DARK is added, for noise."""
LAGS_PX = {(0, 1): (3, 12), (1, 0): (3, 12), (1, 1): (2, 8), (1, -1): (2, 8)}
"""For each direction, y and x: the two distances of pixels that are compared."""
LEAST_DIFFERENT, FLAT = 0.1, 1e-6
"""A direction counts if the mean square along it is such a share of the greatest, and so great at all."""
MOST_BLURRED = 0.12
"""Of the ratio of both. It is 0.14 for sharp edges far apart, and 1/16 for what is smooth over 12 px."""


def check_shows(picture: np.ndarray, name: str) -> None:
    """Raise PhotographError if a picture, uint8 (height, width, 3), is tiny, or black or white all over."""
    height, width = picture.shape[:2]
    if min(height, width) < LEAST_SIDE_PX:
        raise PhotographError(
            f"{name}: it has {width} x {height} px. It needs {LEAST_SIDE_PX} x {LEAST_SIDE_PX} px at least."
        )
    if exposed_blocks(picture).mean() < LEAST_SHOWN:
        tone = "black" if picture.mean() < 128 else "white"
        raise PhotographError(f"{name}: it is {tone} all over. Shoot it again with another exposure.")


def flaws_in(picture: np.ndarray, path: Path | None = None) -> tuple[str, ...]:
    """Return a sentence for each flaw of a picture, uint8 (height, width, 3). path: of its file, if any."""
    has = {
        BLURRED: blur_ratio(picture) < MOST_BLURRED,
        WRITTEN: bool(writing_in(picture)),
        CONVERTED: path is not None and is_converted(path),
    }
    return tuple(why for why, it_has in has.items() if it_has)


def blur_ratio(picture: np.ndarray) -> float:
    """Return how much pixels differ at a short distance, as a share of that at a four times longer one.

    It is the mean square of the difference, in the direction in which this share is least. A line of the
    length L, drawn by motion, makes the light change evenly over L: the mean square grows by the distance's
    square there. At sharp edges it grows by the distance.
    """
    rows, columns = (
        slice(max(0, (size - WINDOW_PX) // 2), (size + WINDOW_PX) // 2) for size in picture.shape[:2]
    )
    values = picture[rows, columns, 1].astype(np.float32)
    light = np.log(ndimage.gaussian_filter(values, SMOOTH_PX) + np.float32(DARK))
    if min(light.shape) <= 12:
        return 1.0
    squares = [[_mean_square(light, y * lag, x * lag) for lag in lags] for (y, x), lags in LAGS_PX.items()]
    least = max(LEAST_DIFFERENT * max(far for _, far in squares), FLAT)
    return min((near / far for near, far in squares if far >= least), default=1.0)


def _mean_square(light: np.ndarray, y: int, x: int) -> float:
    """Return the mean square of the difference between pixels that are (y, x) apart; y is 0 or more."""
    height, width = light.shape
    first, second = light[: height - y], light[y:]
    if x >= 0:
        first, second = first[:, : width - x], second[:, x:]
    else:
        first, second = first[:, -x:], second[:, :x]
    return float(np.mean((first - second) ** 2))


def counted(flaws: Sequence[tuple[str, str]]) -> list[str]:
    """Return a line for each flaw: how many photographs have it, and which. flaws: name and sentence."""
    lines = []
    for why in sorted({why for _, why in flaws}):
        names = [name for name, said in flaws if said == why]
        lines.append(f"{len(names)} photographs: {', '.join(names)}: {why}")
    return lines


class FlawReport(NamedTuple):
    """What is told of a picture. shows: whether it shows anything. sentences: one for each flaw."""

    shows: bool
    sentences: tuple[str, ...]


class FlawCounter:
    """Tells the flaws of pictures that come one by one, and how many so far have each."""

    def __init__(self) -> None:
        self._so_far: Counter[str] = Counter()

    def report_on(self, name: str, picture: np.ndarray) -> FlawReport:
        """Return what is told of a picture, uint8 (height, width, 3)."""
        try:
            check_shows(picture, name)
        except PhotographError as error:
            return FlawReport(False, (self._counted("nothing", str(error)),))
        return FlawReport(True, tuple(self._counted(why, f"{name}: {why}") for why in flaws_in(picture)))

    def _counted(self, flaw: str, sentence: str) -> str:
        self._so_far[flaw] += 1
        return f"{sentence} Such photographs so far: {self._so_far[flaw]}."
