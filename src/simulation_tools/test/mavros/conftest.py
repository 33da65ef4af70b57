"""Lets the tests of this folder import helpers, and gives them the plugins' surroundings."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "px4")]


@pytest.fixture
def uas(monkeypatch):
    from fake_uas import make_uas

    return make_uas(monkeypatch)
