"""A launch whose ports are taken is refused, with the port and what it was for."""

from __future__ import annotations

import errno
import socket
import threading
from contextlib import closing

import pytest

from simulation_tools.launch_check.launch_ports import check_ports_are_free
from simulation_tools.mavlink import LinkError

HOST = "127.0.0.1"


def taken(kind=socket.SOCK_DGRAM, host=HOST):
    """A socket on a port of its own, and the port."""
    one = socket.socket(socket.AF_INET, kind)
    one.bind((host, 0))
    if kind == socket.SOCK_STREAM:
        one.listen(1)
    return closing(one), one.getsockname()[1]


def is_free(port):
    with closing(socket.socket()) as one:
        return one.connect_ex((HOST, port)) == errno.ECONNREFUSED


def ask(autopilot="standin", mavros="sim", offboard_port=0, gcs_port=0, simulator_port=0):
    check_ports_are_free(autopilot, mavros, offboard_port, gcs_port, simulator_port)


@pytest.mark.table(
    ("asked", "purpose"),
    [
        (lambda port: {"offboard_port": port}, "MAVROS"),
        (lambda port: {"offboard_port": port, "mavros": "real"}, "MAVROS"),
        (lambda port: {"offboard_port": port - 40, "mavros": "none"}, "the offboard API"),
        (lambda port: {"gcs_port": port - 4020}, "ground stations"),
    ],
)
@pytest.mark.table("host", [HOST, "0.0.0.0"])
def test_a_udp_port_that_is_taken_is_named(asked, purpose, host):
    """14580 and 18570 are PX4's for 14540 and 14550."""
    user, port = taken(host=host)
    with user, pytest.raises(LinkError) as caught:
        ask(**asked(port))
    assert str(caught.value) == (
        f"Cannot bind UDP 127.0.0.1:{port} for {purpose}: Address already in use; "
        "stop the program that uses the port (another simulator?) or choose another port."
    )
    ask(**asked(port))


def test_the_port_of_real_px4s_simulator_counts_only_with_real_px4():
    user, port = taken(socket.SOCK_STREAM)
    with user:
        ask(simulator_port=port)
        with pytest.raises(LinkError, match=f"Cannot listen on TCP 127.0.0.1:{port} for PX4"):
            ask("px4", simulator_port=port)
    ask("px4", simulator_port=port)


def test_a_px4_that_waits_for_its_simulator_does_not_connect_to_the_check():
    """It was started before the launch. It would never connect again."""
    port = next(port for port in range(20_000, 32_000) if is_free(port))  # others may connect to themselves
    outcomes, done = set(), threading.Event()

    def wait_for_the_simulator():
        while not done.is_set():
            with closing(socket.socket()) as px4:
                outcomes.add(px4.connect_ex((HOST, port)))

    px4 = threading.Thread(target=wait_for_the_simulator)
    px4.start()
    try:
        for _ in range(300):
            ask("px4", simulator_port=port)
    finally:
        done.set()
        px4.join()
    assert outcomes == {errno.ECONNREFUSED}


def test_without_mavros_its_port_is_the_users_own():
    user, port = taken()
    with user:
        ask(mavros="none", offboard_port=port)


def test_ports_of_real_px4_are_not_ours_to_check():
    user, port = taken()
    with user:
        ask("px4", mavros="none", offboard_port=port - 40, gcs_port=port - 4020)
