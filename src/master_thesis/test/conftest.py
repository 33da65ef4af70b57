"""Fixtures that several of this package's tests share."""

from pathlib import Path

import pytest

from flights.results import picture_files
from flights.worlds.scenario import WORLDS


@pytest.fixture(scope="session")
def worlds_folder() -> Path:
    return WORLDS


@pytest.fixture
def png_only(monkeypatch):
    """Leave the PDF and SVG of each picture empty: `test_pictures` of flights looks at them."""
    for ending in ("pdf", "svg"):
        monkeypatch.setattr(picture_files, ending, lambda *_: b"")
