"""Small pictures for the page: thumbnails of photographs and cut-outs of findings, within a budget."""

from __future__ import annotations

import base64
import io
from typing import Mapping, Sequence

from PIL import Image, ImageDraw

from inspection_tools.report.sources import Shot
from inspection_tools.report.views import Mark

BUDGET_BYTES = 4_500_000
"""Of the thumbnails, and of the cut-outs, as JPEG; base64 makes a third more of it."""
LEVELS = ((720, 75), (560, 70), (420, 65), (320, 60), (240, 50), (160, 40))
"""Width, px, and JPEG quality, finest first."""
CUT_OUT_PX = 360
LEAST_CUT_PX, AROUND = 240, 1.8
"""A cut-out shows at least so many pixels of the photograph, and so many radii of the finding."""


def small_pictures(
    shots: Sequence[Shot], best: Mapping[int, Mark]
) -> tuple[dict[int, bytes], dict[int, bytes], list[str]]:
    """Return JPEGs of the photographs and of the findings, by number, and the names of damaged files."""
    thumbs: dict[int, Image.Image] = {}
    cuts: dict[int, Image.Image] = {}
    damaged = []
    for number, shot in enumerate(shots):
        own = [mark for mark in best.values() if mark.photograph == number]
        try:
            with Image.open(shot.path) as image:
                if not own:
                    image.draft("RGB", (LEVELS[0][0], LEVELS[0][0]))  # decodes an eighth: fast
                whole = image.convert("RGB")
        except (OSError, SyntaxError):
            damaged.append(shot.path.name)
            continue
        cuts |= {mark.finding: _cut_out(whole, mark) for mark in own}
        whole.thumbnail((LEVELS[0][0], 4 * LEVELS[0][0]), Image.Resampling.BICUBIC, reducing_gap=2.0)
        thumbs[number] = whole
    cut_levels = tuple((min(width, CUT_OUT_PX), quality) for width, quality in LEVELS)
    return _within(thumbs, LEVELS), _within(cuts, cut_levels), damaged


def _cut_out(whole: Image.Image, mark: Mark) -> Image.Image:
    x, y = mark.centre[0] * whole.width, mark.centre[1] * whole.height
    radius = mark.radius * whole.width
    half = max(AROUND * radius, 0.5 * LEAST_CUT_PX)
    cut = whole.crop((round(x - half), round(y - half), round(x + half), round(y + half)))
    cut = cut.resize((CUT_OUT_PX, CUT_OUT_PX), Image.Resampling.BICUBIC)
    scale = 0.5 * CUT_OUT_PX / half
    _draw_corners(cut, min(1.2 * radius * scale, 0.47 * CUT_OUT_PX))
    return cut


def _draw_corners(cut: Image.Image, reach: float) -> None:
    """Draw the corners of a square around the middle; they hide nothing of the finding."""
    draw, middle = ImageDraw.Draw(cut), 0.5 * CUT_OUT_PX
    for right in (-1.0, 1.0):
        for down in (-1.0, 1.0):
            x, y, arm = middle + right * reach, middle + down * reach, 0.3 * reach
            line = [(x - right * arm, y), (x, y), (x, y - down * arm)]
            draw.line(line, fill=(0, 0, 0), width=5)
            draw.line(line, fill=(255, 255, 255), width=2)


def _within(pictures: Mapping[int, Image.Image], levels: Sequence[tuple[int, int]]) -> dict[int, bytes]:
    """Return the pictures as JPEG, at the finest level at which all are within the budget."""
    encoded: dict[int, bytes] = {}
    for width, quality in levels:
        encoded, total = {}, 0
        for number, picture in pictures.items():
            encoded[number] = _jpeg(picture, width, quality)
            total += len(encoded[number])
            if total > BUDGET_BYTES:
                break
        if total <= BUDGET_BYTES:
            break
    return encoded


def _jpeg(picture: Image.Image, width: int, quality: int) -> bytes:
    size = (min(width, picture.width), round(picture.height * min(width, picture.width) / picture.width))
    out = io.BytesIO()
    picture.resize(size, Image.Resampling.BICUBIC).save(out, "JPEG", quality=quality, optimize=True)
    return out.getvalue()


def data_uri(content: bytes, kind: str = "image/jpeg") -> str:
    """Return content as an address that needs no file."""
    return f"data:{kind};base64," + base64.b64encode(content).decode("ascii")
