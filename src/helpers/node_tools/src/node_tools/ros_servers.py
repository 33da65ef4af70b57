"""Calls XML-RPC servers of masters, nodes and roslaunch with a time-out."""

from __future__ import annotations

from http.client import HTTPConnection
from typing import Any
from xmlrpc.client import Fault, ProtocolError, ServerProxy, Transport

import rosgraph

PATIENCE_S = 3.0
UNREACHABLE = (OSError, Fault, ProtocolError, rosgraph.MasterException)
"""Exceptions of a call without an answer."""


def server(uri: str) -> Any:
    """Return a proxy of an XML-RPC server.

    It has a time-out, because a hung server accepts calls and never answers.
    """
    return ServerProxy(uri, transport=_ImpatientTransport())


class _ImpatientTransport(Transport):
    def make_connection(self, host: tuple[str, dict[str, str]] | str) -> HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = PATIENCE_S
        return connection
