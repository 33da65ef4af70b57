"""Fixtures that several of this package's tests share."""

from pathlib import Path

import pytest

from flights.results import picture_files


@pytest.fixture(scope="session")
def worlds_folder() -> Path:
    return Path(__file__).resolve().parents[1] / "worlds"


@pytest.fixture
def png_only(monkeypatch):
    """Leave the PDF and SVG of each picture empty: `test_pictures` looks at them."""
    for ending in ("pdf", "svg"):
        monkeypatch.setattr(picture_files, ending, lambda *_: b"")
