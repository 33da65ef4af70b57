"""Blocking calls outside the callbacks: waited for briefly, in order, and never piling up."""

from __future__ import annotations

import threading
import time

from simulation_tools_ros.mavros_publisher.request_thread import RequestThread


def test_a_call_is_over_when_ask_returns():
    made = []
    requests = RequestThread()
    for number in range(20):
        assert requests.ask(lambda number=number: made.append((number, threading.current_thread())), 1.0)
        assert made[-1][0] == number
    assert threading.main_thread() not in [thread for _, thread in made]


def test_a_call_that_hangs_is_waited_for_once_and_nothing_queues_up():
    release = threading.Event()
    made = []
    requests = RequestThread()
    began = time.monotonic()
    assert not requests.ask(release.wait, 0.2)
    assert time.monotonic() - began >= 0.2
    began = time.monotonic()
    for _ in range(100):
        assert not requests.ask(lambda: made.append(1), 0.2)
    assert time.monotonic() - began < 10.0  # not 100 times 0.2 s
    release.set()
    end = time.monotonic() + 60.0
    while not requests.ask(lambda: made.append(2), 0.2) and time.monotonic() < end:
        time.sleep(0.01)
    assert made == [2]
