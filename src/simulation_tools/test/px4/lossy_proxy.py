"""A UDP network that loses and reorders, between one client and the flight controller's link."""

from __future__ import annotations

import socket

import numpy as np

from simulation_tools.mavlink import receive_all, send


class LossyProxy:
    """Forwards both ways when `pump` is called; `port` is what the client sends to.

    Of all datagrams a share `loss` is dropped, and a share `reordered` waits for one to four later ones.
    """

    def __init__(self, link_port, loss=0.2, reordered=0.2, seed=1):
        self._inside, self._outside = (self._socket() for _ in range(2))
        self._link = ("127.0.0.1", link_port)
        self._client = None
        self._loss, self._reordered = loss, reordered
        self._rng = np.random.default_rng(seed)
        self._held = {True: [], False: []}
        self.port = self._outside.getsockname()[1]
        self.passed = self.lost = self.late = 0

    @staticmethod
    def _socket():
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        udp.bind(("127.0.0.1", 0))
        udp.setblocking(False)
        return udp

    def pump(self):
        for data, address in receive_all(self._outside):
            self._client = address
            self._pass_on(data, inwards=True)
        for data, _ in receive_all(self._inside):
            self._pass_on(data, inwards=False)

    def _pass_on(self, data, inwards):
        draw = self._rng.random()
        if draw < self._loss:
            self.lost += 1
            return
        held = self._held[inwards]
        if draw < self._loss + self._reordered:
            self.late += 1
            held.append([data, int(self._rng.integers(1, 5))])
            return
        self._send(data, inwards)
        for entry in held:
            entry[1] -= 1
        for entry in [entry for entry in held if entry[1] <= 0]:
            held.remove(entry)
            self._send(entry[0], inwards)

    def _send(self, data, inwards):
        self.passed += 1
        if inwards:
            send(self._inside, data, self._link)
        elif self._client is not None:
            send(self._outside, data, self._client)

    def close(self):
        self._inside.close()
        self._outside.close()
