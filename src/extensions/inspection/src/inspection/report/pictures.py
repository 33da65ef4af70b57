"""Small pictures for the page: thumbnails of photographs and cut-outs of findings, within a budget."""

from __future__ import annotations

import base64
import io
from typing import Mapping, NamedTuple, Sequence

from PIL import Image, ImageDraw, ImageFont

from inspection.photographs.listing import opened
from inspection.report.sources import Shot
from inspection.report.views import Mark

BUDGET_BYTES = 4_500_000
"""Of the thumbnails, and of the cut-outs, as JPEG; base64 makes a third more of it."""
LEVELS = ((720, 75), (560, 70), (420, 65), (320, 60), (240, 50), (160, 40))
"""Width, px, and JPEG quality, finest first."""
CUT_OUT_PX = 360
LEAST_CUT_PX, AROUND = 240, 1.8
"""A cut-out shows at least so many pixels of the photograph, and so many radii of the finding."""


class Sheet:
    """Small pictures within a budget, as JPEG at one level: the finest at which all that were added fit.

    Pictures that come when the coarsest level is full are left out.

    Attributes:
        pictures: JPEGs by number. is_full: whether one was left out.
    """

    def __init__(self, levels: Sequence[tuple[int, int]], budget_bytes: int = BUDGET_BYTES) -> None:
        self._levels, self._budget_bytes = levels, budget_bytes
        self._level, self._total = 0, 0
        self.pictures: dict[int, bytes] = {}
        self.is_full = False

    def add(self, number: int, picture: Image.Image) -> None:
        """Take a picture, if it fits."""
        encoded = _jpeg(picture, *self._levels[self._level])
        while self._total + len(encoded) > self._budget_bytes:
            if self._level == len(self._levels) - 1:
                self.is_full = True
                return
            self._level += 1
            self.pictures = {k: self._coarser(each) for k, each in self.pictures.items()}
            self._total = sum(map(len, self.pictures.values()))
            encoded = _jpeg(picture, *self._levels[self._level])
        self.pictures[number] = encoded
        self._total += len(encoded)

    def _coarser(self, encoded: bytes) -> bytes:
        with Image.open(io.BytesIO(encoded)) as image:
            return _jpeg(image.convert("RGB"), *self._levels[self._level])


class SmallPictures(NamedTuple):
    """JPEGs of the photographs and of the findings, by number, and the names of damaged files."""

    thumbs: dict[int, bytes]
    cuts: dict[int, bytes]
    damaged: list[str]


def small_pictures(shots: Sequence[Shot], best: Mapping[int, Mark]) -> SmallPictures:
    """Return small pictures; if not all fit, those with findings come first. One photograph is held."""
    own: dict[int, list[Mark]] = {}
    for mark in best.values():
        own.setdefault(mark.photograph, []).append(mark)
    thumbs, damaged = Sheet(LEVELS), list[str]()
    cuts = Sheet(tuple((min(width, CUT_OUT_PX), quality) for width, quality in LEVELS))
    for number in sorted(range(len(shots)), key=lambda k: (k not in own, k)):
        marks = own.get(number, [])
        if thumbs.is_full and (cuts.is_full or not marks):
            continue
        try:
            with opened(shots[number].path) as image:
                if not marks:
                    image.draft("RGB", (LEVELS[0][0], LEVELS[0][0]))  # decodes an eighth: fast
                whole = image.convert("RGB")
        except (OSError, SyntaxError):
            damaged.append(shots[number].path.name)
            continue
        for mark in marks:
            cuts.add(mark.finding, _cut_out(whole, mark))
        whole.thumbnail((LEVELS[0][0], 4 * LEVELS[0][0]), Image.Resampling.BICUBIC, reducing_gap=2.0)
        thumbs.add(number, whole)
    in_order = {number: thumbs.pictures[number] for number in sorted(thumbs.pictures)}
    return SmallPictures(in_order, cuts.pictures, damaged)


def _cut_out(whole: Image.Image, mark: Mark) -> Image.Image:
    x, y = mark.centre[0] * whole.width, mark.centre[1] * whole.height
    radius = mark.radius * whole.width
    half = max(AROUND * radius, 0.5 * LEAST_CUT_PX)
    cut = whole.crop((round(x - half), round(y - half), round(x + half), round(y + half)))
    cut = cut.resize((CUT_OUT_PX, CUT_OUT_PX), Image.Resampling.BICUBIC)
    scale = 0.5 * CUT_OUT_PX / half
    _draw_corners(cut, min(1.2 * radius * scale, 0.47 * CUT_OUT_PX))
    _draw_scale(cut, mark.per_m * whole.width * scale)
    return cut


def bar_of(per_m: float, most_px: float) -> tuple[float, str]:
    """Return the longest of the usual lengths, m, that takes at most so many px, and what it is called."""
    lengths_mm = [step * 10**power for power in range(4) for step in (1, 2, 5)]
    fitting = [each for each in lengths_mm if 1e-3 * each * per_m <= most_px] or lengths_mm[:1]
    longest = fitting[-1]
    return 1e-3 * longest, f"{longest / 1000:g} m" if longest >= 1000 else f"{longest} mm"


def _draw_scale(cut: Image.Image, per_m: float) -> None:
    """Draw a bar of a known length at the lower left. per_m: px of a metre across the line of sight."""
    length_m, told = bar_of(per_m, 0.4 * CUT_OUT_PX)
    draw, x, y = ImageDraw.Draw(cut), 14.0, CUT_OUT_PX - 14.0
    line = [(x, y), (x + length_m * per_m, y)]
    draw.line(line, fill=(0, 0, 0), width=7)
    draw.line(line, fill=(255, 255, 255), width=3)
    font = ImageFont.load_default(18)
    draw.text((x, y - 26.0), told, fill=(255, 255, 255), font=font, stroke_width=2, stroke_fill=(0, 0, 0))


def _draw_corners(cut: Image.Image, reach: float) -> None:
    """Draw the corners of a square around the middle; they hide nothing of the finding."""
    draw, middle = ImageDraw.Draw(cut), 0.5 * CUT_OUT_PX
    for right in (-1.0, 1.0):
        for down in (-1.0, 1.0):
            x, y, arm = middle + right * reach, middle + down * reach, 0.3 * reach
            line = [(x - right * arm, y), (x, y), (x, y - down * arm)]
            draw.line(line, fill=(0, 0, 0), width=5)
            draw.line(line, fill=(255, 255, 255), width=2)


def _jpeg(picture: Image.Image, width: int, quality: int) -> bytes:
    size = (min(width, picture.width), round(picture.height * min(width, picture.width) / picture.width))
    out = io.BytesIO()
    picture.resize(size, Image.Resampling.BICUBIC).save(out, "JPEG", quality=quality, optimize=True)
    return out.getvalue()


def data_uri(content: bytes, kind: str = "image/jpeg") -> str:
    """Return content as an address that needs no file."""
    return f"data:{kind};base64," + base64.b64encode(content).decode("ascii")
