"""A picture as files: PNG to look at, PDF and SVG to print and to edit."""

from __future__ import annotations

import io
from typing import Any

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

_DPI = 200


def files(name: str, figure: Figure) -> dict[str, bytes]:
    """Return a figure as files: NAME.png to look at, NAME.pdf and NAME.svg to print and to edit."""
    return {f"{name}.{ending}": draw(figure) for ending, draw in (("png", png), ("pdf", pdf), ("svg", svg))}


def png(figure: Figure) -> bytes:
    """Return a figure as the bytes of a PNG file, fine enough for print."""
    FigureCanvasAgg(figure)
    return _drawn(figure, "png")


def pdf(figure: Figure) -> bytes:
    """Return a figure as the bytes of a PDF file, the same for the same figure; its text can be searched."""
    with rc_context({"pdf.fonttype": 42}):
        return _drawn(figure, "pdf", metadata={"CreationDate": None})


def svg(figure: Figure) -> bytes:
    """Return a figure as the bytes of an SVG file, the same for the same figure."""
    with rc_context({"svg.fonttype": "path", "svg.hashsalt": "master_thesis"}):
        return _drawn(figure, "svg", metadata={"Date": None})


def _drawn(figure: Figure, ending: str, **options: Any) -> bytes:
    stream = io.BytesIO()
    figure.savefig(stream, format=ending, dpi=_DPI, bbox_inches="tight", pad_inches=0.05, **options)
    return stream.getvalue()
