"""Fixtures that several of this package's tests share."""

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def worlds_folder() -> Path:
    return Path(__file__).resolve().parents[1] / "worlds"
