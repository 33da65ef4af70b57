"""Lets the tests of this folder import its helpers, and gives them a flight with MAVLink clients."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))

from mavlink_client import Setup


@pytest.fixture
def setup():
    setup = Setup()
    yield setup
    setup.close()


@pytest.fixture
def ready(setup):
    """A setup after a second, and an onboard client that it knows."""
    client = setup.client()
    client.heartbeat()
    setup.run(1.0)
    client.inbox.clear()
    return setup, client
