"""MAVROS's `fcu_url`: the addresses of the flight controller and of this node."""

from __future__ import annotations

import re
import socket
from dataclasses import dataclass

from simulation_tools.mavlink import Address, LinkError

_URL = re.compile(r"udp://(?P<host>[\w.-]*):(?P<port>\d+)@(?P<remote_host>[\w.-]+):(?P<remote_port>\d+)/?")
_FIND_A_ROUTE = 9  # any port, because nothing is sent


@dataclass(frozen=True)
class Endpoints:
    """The two ends of a link: (IPv4 address, UDP port). local: to bind. remote: the flight controller's."""

    local: Address
    remote: Address


def parse_fcu_url(url: str) -> Endpoints:
    """Read MAVROS's ``udp://[host]:port@remote_host:remote_port``; raises LinkError.

    Without the first host the local address is that of the network that leads to the remote host. For a
    flight controller on this machine it is the loopback, which no other machine can reach. ``0.0.0.0``
    listens on every network.
    """
    match = _URL.fullmatch(url)
    if match is None or int(match["port"]) > 65535 or not 0 < int(match["remote_port"]) <= 65535:
        raise LinkError(
            f"Cannot read the fcu_url {url!r}; write udp://:LOCAL_PORT@REMOTE_HOST:REMOTE_PORT, "
            "such as udp://:14540@127.0.0.1:14580."
        )
    remote_host = _resolve(match["remote_host"], url)
    host = _resolve(match["host"], url) if match["host"] else _address_towards(remote_host, url)
    return Endpoints((host, int(match["port"])), (remote_host, int(match["remote_port"])))


def _resolve(host: str, url: str) -> str:
    try:
        return socket.gethostbyname(host)
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise LinkError(
            f"Cannot find the host {host!r} of the fcu_url {url!r}: {reason}; check its name."
        ) from None


def _address_towards(remote_host: str, url: str) -> str:
    """Return this machine's address on the network on which the remote host is."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((remote_host, _FIND_A_ROUTE))
        except OSError as error:
            raise LinkError(
                f"No network leads to {remote_host} of the fcu_url {url!r}: {error.strerror}; "
                "connect this machine to it."
            ) from None
        return probe.getsockname()[0]
