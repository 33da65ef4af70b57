"""A picture as files: PNG to look at, PDF and SVG to print and to edit."""

from __future__ import annotations

import io
from typing import Any

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

_DPI = 200
_PAD_IN = 0.05


def files(name: str, figure: Figure) -> dict[str, bytes]:
    """Return a figure as files: NAME.png to look at, NAME.pdf and NAME.svg to print and to edit."""
    inked = _inked(figure)
    drawn = {"png": png(figure, inked), "pdf": pdf(figure, inked), "svg": svg(figure, inked)}
    return {f"{name}.{ending}": content for ending, content in drawn.items()}


def png(figure: Figure, inked: Bbox | None = None) -> bytes:
    """Return a figure as the bytes of a PNG file, fine enough for print. inked: see `_inked`."""
    FigureCanvasAgg(figure)
    return _drawn(figure, "png", inked)


def pdf(figure: Figure, inked: Bbox | None = None) -> bytes:
    """Return a figure as the bytes of a PDF file, the same for the same figure; its text can be searched."""
    with rc_context({"pdf.fonttype": 42}):
        return _drawn(figure, "pdf", inked, metadata={"CreationDate": None})


def svg(figure: Figure, inked: Bbox | None = None) -> bytes:
    """Return a figure as the bytes of an SVG file, the same for the same figure."""
    with rc_context({"svg.fonttype": "path", "svg.hashsalt": "master_thesis"}):
        return _drawn(figure, "svg", inked, metadata={"Date": None})


def _inked(figure: Figure) -> Bbox:
    """Return the part of a figure to write, in inches: all that is drawn, and a margin.

    matplotlib would find it for each file, which takes as long as to draw it.
    """
    canvas, dpi = FigureCanvasAgg(figure), figure.dpi
    figure.dpi = _DPI
    figure.draw_without_rendering()
    figure.set_layout_engine(
        "none"
    )  # each later drawing would lay it out anew, and move labels out of this part
    inked = figure.get_tightbbox(canvas.get_renderer()).padded(_PAD_IN)
    figure.dpi = dpi
    return inked


def _drawn(figure: Figure, ending: str, inked: Bbox | None, **options: Any) -> bytes:
    stream = io.BytesIO()
    shown = inked or "tight"
    figure.savefig(stream, format=ending, dpi=_DPI, bbox_inches=shown, pad_inches=_PAD_IN, **options)
    return stream.getvalue()
