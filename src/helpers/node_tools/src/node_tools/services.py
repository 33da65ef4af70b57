"""Calls services with a time limit. rospy.ServiceProxy waits for ever for a node that hangs.

A node that is stopped, or whose handler waits, keeps its connection open. So the socket is shut down when the
time is over. That ends the call in the thread that made it, and no thread stays behind.
"""

from __future__ import annotations

import socket
import threading
import time
from contextlib import suppress
from typing import Any

import rosgraph
import rospy
from rospy.exceptions import ROSInterruptException, TransportException, TransportInitError
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_service import TCPROSServiceClient

from node_tools.ros_servers import UNREACHABLE, server

PATIENCE_S = 5.0
"""Wall time in which a node answers that only has to note something."""
LOOK_S = 0.1
"""Wall time between two questions whether a service is there."""


class NoServiceError(rospy.ServiceException):
    """Nobody offers the service, or nothing listens at its address any more: its node has ended."""


class ServiceCall:
    """A service that is called like a rospy.ServiceProxy. Several threads may call it.

    Args:
        name: of the service. service_class: of its messages.
        patience_s: wall time in which it must answer.
        wait_s: of this time, for so long it may take until the service is there at all.

    Attributes:
        name: resolved.
    """

    def __init__(
        self, name: str, service_class: Any, patience_s: float = PATIENCE_S, wait_s: float = 0.0
    ) -> None:
        self.name = rospy.resolve_name(name)
        self._class, self._patience_s, self._wait_s = service_class, patience_s, wait_s

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Return the answer to a request, which is given whole or by its fields.

        Raises:
            NoServiceError: there is no such service, or its node has died.
            rospy.ServiceException: it failed, or it did not answer in time.
        """
        end_s = time.monotonic() + self._patience_s
        request = rospy.msg.args_kwds_to_message(self._class._request_class, arguments, named)
        uri = self._uri(min(end_s, time.monotonic() + self._wait_s))
        transport = TCPROSTransport(TCPROSServiceClient(self.name, self._class), self.name)
        is_late = threading.Event()

        def give_up() -> None:
            is_late.set()
            with suppress(OSError, AttributeError):  # not connected yet, or closed meanwhile
                transport.socket.shutdown(socket.SHUT_RDWR)

        left_s = max(end_s - time.monotonic(), LOOK_S)
        timer = threading.Timer(left_s, give_up)
        timer.daemon = True
        timer.start()
        is_connected = False
        try:
            transport.connect(*rospy.core.parse_rosrpc_uri(uri), uri, timeout=left_s)
            is_connected = True
            transport.send_message(request, 1)
            answers = transport.receive_once()
        except (TransportException, TransportInitError, OSError) as error:
            self._raise(is_late.is_set(), str(error), is_absent=not is_connected)
        finally:
            timer.cancel()
            transport.close()
        if not answers:
            self._raise(is_late.is_set(), "it closed the connection")
        return answers[0]

    def wait_for_service(self, timeout_s: float) -> None:
        """Wait until the service is there; raises rospy.ROSException if it is not in this wall time."""
        rospy.wait_for_service(self.name, timeout_s)

    def _raise(self, is_late: bool, why: str, is_absent: bool = False) -> None:
        if rospy.is_shutdown():
            raise ROSInterruptException("The node ends, so the service was not waited for.")
        if is_late:
            why = f"it gave no answer within {self._patience_s:g} s"
        is_absent = is_absent and not is_late
        raise (NoServiceError if is_absent else rospy.ServiceException)(f"{self.name} failed: {why}")

    def _uri(self, until_s: float) -> str:
        """Return where the service is, which may have to come first; raises rospy.ServiceException."""
        while True:
            try:
                code, _, uri = server(rosgraph.get_master_uri()).lookupService(
                    rospy.get_caller_id(), self.name
                )
            except UNREACHABLE as error:
                self._raise(False, f"the ROS master does not answer ({error})")
            if code == 1:
                return uri
            if time.monotonic() >= until_s or rospy.is_shutdown():
                self._raise(False, "there is no such service", is_absent=True)
            time.sleep(LOOK_S)
