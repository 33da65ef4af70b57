"""Calls of services end: with the answer, or with a sentence when the time is over."""

import json
import sys
from pathlib import Path

import pytest

pytest.importorskip("rosgraph", reason="needs ROS")
pytestmark = pytest.mark.ros

PATIENCE_S, SLACK_S = 0.5, 10.0
"""Of the probe; and what a busy machine may add."""


@pytest.fixture(scope="module")
def heard(master_of_module):
    probe = Path(__file__).with_name("service_probe.py")
    done = master_of_module.run(sys.executable, str(probe), timeout_s=90.0)
    assert done.returncode == 0, done.stdout
    return json.loads(next(line for line in done.stdout.splitlines() if line.startswith("{")))


def test_an_answer_is_returned(heard):
    assert heard["told"]["answers"][0] == "here"


def test_a_service_that_comes_in_time_is_waited_for(heard):
    assert heard["told"]["late"][0] == "at last"


@pytest.mark.table(
    ("name", "words"),
    [
        ("fails", "it is broken"),
        ("absent", "/absent failed: there is no such service"),
        ("hangs", "/hangs failed: it gave no answer within 0.5 s"),
        ("stopped", "/stopped failed: it gave no answer within 0.5 s"),
    ],
)
def test_a_call_that_gets_no_answer_ends_with_a_sentence(heard, name, words):
    told, took_s = heard["told"][name]
    assert words in told
    assert took_s < PATIENCE_S + SLACK_S


def test_no_thread_stays_behind(heard):
    assert heard["left"] == []
