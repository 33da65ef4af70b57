"""Ports for a graph that runs beside others on one machine."""

from __future__ import annotations

import contextlib
import random
import socket

# Linux uses ports from 32768 on for connections. Such a port may be taken again before our program has
# started. A flight controller binds ports 40 and 4020 above those of its clients, but later than these are
# chosen. So none of these is a candidate.
CANDIDATES = tuple(port for port in range(15000, 32768) if port // 20 % 4 == 0)


def free_ports(count: int) -> list[int]:
    """Return ports of 127.0.0.1 that are free at this moment, for TCP and UDP.

    Raises:
        OSError: there are not so many.
    """
    with contextlib.ExitStack() as held:
        found: list[int] = []
        for port in random.Random().sample(CANDIDATES, len(CANDIDATES)):
            if len(found) == count:
                return found
            if _take(port, held):
                found.append(port)
    raise OSError(f"Fewer than {count} ports from {CANDIDATES[0]} to {CANDIDATES[-1]} are free.")


def _take(port: int, held: contextlib.ExitStack) -> bool:
    for kind in (socket.SOCK_STREAM, socket.SOCK_DGRAM):
        sock = held.enter_context(socket.socket(type=kind))
        try:
            sock.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True
