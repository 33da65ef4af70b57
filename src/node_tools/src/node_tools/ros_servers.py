"""The XML-RPC servers of masters, nodes and roslaunch: asked with patience, but not for ever."""

from __future__ import annotations

from http.client import HTTPConnection
from typing import Any
from xmlrpc.client import Fault, ProtocolError, ServerProxy, Transport

import rosgraph

PATIENCE_S = 3.0
UNREACHABLE = (OSError, Fault, ProtocolError, rosgraph.MasterException)
"""What a call raises when nobody answers, or no longer."""


def server(uri: str) -> Any:
    """Return what calls the methods of an XML-RPC server; a hung one accepts calls and never answers."""
    return ServerProxy(uri, transport=_ImpatientTransport())


class _ImpatientTransport(Transport):
    def make_connection(self, host: tuple[str, dict[str, str]] | str) -> HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = PATIENCE_S
        return connection
