"""Graphs beside each other never get a port that another one's flight controller is about to bind."""

import socket

import pytest

from flights.graph.free_ports import CANDIDATES, free_ports
from simulation_tools.px4_ports import own_ports


def test_what_a_flight_controller_binds_itself_is_nobodys_candidate():
    candidates = set(CANDIDATES)
    for port in CANDIDATES:
        assert not candidates & set(own_ports(port, port))


def test_ports_are_different_and_free():
    ports = free_ports(5)
    assert len(set(ports)) == 5
    for port in ports:
        with socket.socket() as sock:
            sock.bind(("127.0.0.1", port))


def test_a_port_in_use_is_not_given(monkeypatch):
    with socket.socket(type=socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        monkeypatch.setattr("flights.graph.free_ports.CANDIDATES", (sock.getsockname()[1],))
        with pytest.raises(OSError, match="Fewer than 1 ports"):
            free_ports(1)
