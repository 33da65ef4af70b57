"""Lets the tests of this folder import their helper, and gives them run loops."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))


@pytest.fixture
def rig():
    """Build a run loop with all around it; see `Rig`."""
    from run_loop_rig import Rig

    rigs = []

    def build(**pacing):
        rigs.append(Rig(**pacing))
        return rigs[-1]

    yield build
    for made in rigs:
        made.close()
