"""A MAVLink client of one flight controller, as MAVROS is one: messages in and out, commands, parameters.

Time-outs of answers are wall time, because they must not depend on the speed of simulated time. `connection`
says whether the flight controller is there, in the flight controller's time.
"""

from __future__ import annotations

import math
import threading
from typing import Callable

from pymavlink.dialects.v20 import common

from simulation_tools.bounds import fit_float32
from simulation_tools.mavlink import (
    Address,
    Codec,
    decode_text,
    open_udp,
    receive_all,
    send,
    wait_readable,
)
from simulation_tools.mavros.connection import Connection
from simulation_tools.mavros.conversions import DEFAULT_TARGET, Target
from simulation_tools.mavros.fcu_url import parse_fcu_url
from simulation_tools.mavros.stacks import Stack, stack_of

_PARAMETER_TRIES, _LIST_REQUESTS, _LIST_ROUNDS = 10, 4, 12  # over a network that loses messages
_PARAMETER_PATIENCE_S = 3.0  # for all tries, as in MAVROS: three tries of 1 s
_SET_TRIES = 3  # another value than the one sent: a refusal, or a late answer to an earlier question

_NUMBERS = {message.msgname: number for number, message in common.mavlink_map.items()}
_OWN = ("HEARTBEAT", "PING", "COMMAND_ACK", "PARAM_VALUE")
"""What a client heeds without a handler."""

Handler = Callable[[common.MAVLink_message], None]


class FcuClient:
    """One connection. Only one thread may call `poll`; any thread may call the other methods."""

    def __init__(
        self,
        fcu_url: str,
        system_id: int = 1,
        component_id: int = common.MAV_COMP_ID_UDP_BRIDGE,
        target: Target = DEFAULT_TARGET,
        connection_timeout_s: float = 10.0,
        command_timeout_s: float = 5.0,
    ) -> None:
        """Open the local port; raises LinkError.

        connection_timeout_s: of the flight controller's time. command_timeout_s: of wall time.
        """
        endpoints = parse_fcu_url(fcu_url)
        self.target = target
        self.url = fcu_url
        self._handled = 0
        self.stack: Stack = stack_of(None)  # the flight controller's, by its heartbeats
        self._codec = Codec(system_id, component_id)
        self._codec.wanted = {_NUMBERS[name] for name in _OWN}
        self._remote: Address = endpoints.remote
        self._socket = open_udp(*endpoints.local, "MAVROS")
        self._connection = Connection(connection_timeout_s)
        self._command_timeout_s = command_timeout_s
        self._parameter_timeout_s = min(_PARAMETER_PATIENCE_S, command_timeout_s) / _PARAMETER_TRIES
        self._send_lock = threading.Lock()
        self._handlers: dict[str, list[Handler]] = {}
        self._of_any_component: set[str] = set()
        self._answers = threading.Condition()
        self._acks: dict[int, int] = {}
        self._parameters: dict[str, float] = {}
        self._fresh: set[str] = set()
        self._indices: set[int] = set()  # of the parameters received since the last request for the list
        self._count = 0
        self._command_lock = threading.Lock()

    def on(self, name: str, handler: Handler, any_component: bool = False) -> None:
        """Call a handler for each message of a MAVLink name from the target, after earlier handlers.

        any_component: also for those of the vehicle's other components, such as a camera, which the flight
        controller forwards. Messages without a handler are not unpacked.
        """
        assert self._codec.wanted is not None
        self._codec.wanted.add(_NUMBERS[name])
        if any_component:
            self._of_any_component.add(name)
        self._handlers.setdefault(name, []).append(handler)

    @property
    def local_address(self) -> Address:
        """Where it listens."""
        return self._socket.getsockname()

    @property
    def port(self) -> int:
        """The local port."""
        return self.local_address[1]

    @property
    def connected(self) -> bool:
        """Whether the flight controller's heartbeats arrive."""
        return self._connection.alive

    @property
    def packets(self) -> int:
        """Return how many whole messages have come from anybody."""
        return self._handled + self._codec.unwanted

    @property
    def bad_packets(self) -> int:
        """Return how many packets were no valid message."""
        return self._codec.bad

    def wait(self, timeout_s: float) -> bool:
        """Wait until there is something to `poll`."""
        return wait_readable([self._socket], timeout_s)

    def poll(self) -> None:
        """Handle every message that is there."""
        for datagram, address in receive_all(self._socket):
            for message in self._codec.decode(datagram):
                self._handled += 1
                if self._is_from_target(message, address):
                    self._handle(message)

    def _is_from_target(self, message: common.MAVLink_message, address: Address) -> bool:
        """Whether the flight controller sent it.

        An autopilot's heartbeat from the URL's host tells the port. System id 1 proves nothing, because
        nearly every script uses it, too.
        """
        if address[0] != self._remote[0] or message.get_srcSystem() != self.target.system_id:
            return False
        if message.get_type() in self._of_any_component:
            return address == self._remote
        if message.get_srcComponent() != self.target.component_id:
            return False
        if message.get_type() == "HEARTBEAT":
            if message.type == common.MAV_TYPE_GCS or message.autopilot == common.MAV_AUTOPILOT_INVALID:
                return False
            self._remote = address
            self.stack = stack_of(message.autopilot)
        return address == self._remote

    def send(self, message: common.MAVLink_message) -> bool:
        """Send a message to the flight controller. Return False if the system refuses it."""
        with self._send_lock:
            return send(self._socket, self._codec.pack(message), self._remote)

    def send_heartbeat(self) -> None:
        """Send the heartbeat of this onboard computer."""
        self.send(
            common.MAVLink_heartbeat_message(
                common.MAV_TYPE_ONBOARD_CONTROLLER,
                common.MAV_AUTOPILOT_INVALID,
                0,
                0,
                common.MAV_STATE_ACTIVE,
                3,
            )
        )

    def command(self, command: int, *params: float) -> int | None:
        """Send COMMAND_LONG and return the answer, a MAV_RESULT; None without an answer in time.

        NaN means "not given" to many commands. Raises ValueError for a number too large for MAVLink.
        """
        padded = (*params, *(0.0 for _ in range(7 - len(params))))
        if not fit_float32(filter(math.isfinite, padded)):
            raise ValueError(f"a parameter of command {command} is beyond 3.4e38")
        with self._command_lock:
            with self._answers:
                self._acks.pop(command, None)
            self.send(
                common.MAVLink_command_long_message(
                    self.target.system_id, self.target.component_id, command, 0, *padded
                )
            )
            with self._answers:
                self._answers.wait_for(lambda: command in self._acks, self._command_timeout_s)
                return self._acks.pop(command, None)

    def set_mode(self, base_mode: int, custom: int) -> None:
        """Send SET_MODE. As in MAVROS, do not wait for the answer."""
        flags = base_mode or common.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        self.send(common.MAVLink_set_mode_message(self.target.system_id, flags, custom))

    def get_parameter(self, name: str) -> float | None:
        """Return a parameter's value; None without an answer, for example for an unknown name."""
        request = common.MAVLink_param_request_read_message(
            self.target.system_id, self.target.component_id, name.encode("ascii", "replace"), -1
        )
        return self._exchange_parameter(name, request)

    def set_parameter(self, name: str, value: float) -> float | None:
        """Change a parameter. Return its value afterwards; None without an answer.

        An int goes out as INT32, a float as REAL32. Raises ValueError for a value that does not fit.
        """
        is_integer = isinstance(value, int)
        request = common.MAVLink_param_set_message(
            self.target.system_id,
            self.target.component_id,
            name.encode("ascii", "replace"),
            self.stack.to_wire(value, is_integer),
            common.MAV_PARAM_TYPE_INT32 if is_integer else common.MAV_PARAM_TYPE_REAL32,
        )
        now = None
        for _ in range(_SET_TRIES):
            now = self._exchange_parameter(name, request)
            if now is None or math.isclose(now, value, rel_tol=1e-6):
                break
        return now

    def pull_parameters(self) -> dict[str, float]:
        """Ask for all parameters, then for those that were lost on the way. Return those received."""
        with self._answers:
            self._parameters.clear()
            self._indices.clear()
            self._count = 0
        target = (self.target.system_id, self.target.component_id)
        missing: list[int] = []
        for attempt in range(_LIST_ROUNDS):
            if not self._count and attempt < _LIST_REQUESTS:
                self.send(common.MAVLink_param_request_list_message(*target))
            for index in missing:
                self.send(common.MAVLink_param_request_read_message(*target, b"", index))
            missing = self._wait_for_list(0.15 if missing else 0.5)
            if (self._count and not missing) or (not self._count and attempt + 1 == _LIST_REQUESTS):
                break
        with self._answers:
            return dict(self._parameters)

    def _wait_for_list(self, quiet_s: float) -> list[int]:
        """Wait until the list is complete or no more messages come. Return the missing indices."""
        with self._answers:
            count = -1
            while len(self._indices) != count and (count < 0 or count != self._count):
                count = len(self._indices)
                self._wait_for_more_than(count, quiet_s)
            return sorted(set(range(self._count)) - self._indices)

    def _wait_for_more_than(self, count: int, timeout_s: float) -> None:
        self._answers.wait_for(lambda: len(self._indices) > count, timeout_s)

    def close(self) -> None:
        """Release the port."""
        self._socket.close()

    def _exchange_parameter(self, name: str, request: common.MAVLink_message) -> float | None:
        with self._command_lock:
            with self._answers:
                self._fresh.discard(name)
            for _ in range(_PARAMETER_TRIES):
                self.send(request)
                with self._answers:
                    if self._answers.wait_for(lambda: name in self._fresh, self._parameter_timeout_s):
                        return self._parameters[name]
            return None

    def _handle(self, message: common.MAVLink_message) -> None:
        self._connection.on_message(message)
        kind = message.get_type()
        if kind == "COMMAND_ACK":
            with self._answers:
                self._acks[message.command] = message.result
                self._answers.notify_all()
        elif kind == "PARAM_VALUE":
            self._note_parameter(message)
        for handler in self._handlers.get(kind, ()):
            handler(message)

    def _note_parameter(self, message: common.MAVLink_message) -> None:
        try:
            value = self.stack.from_wire(message.param_value, message.param_type)
        except ValueError:
            return
        name = decode_text(message.param_id)
        with self._answers:
            self._parameters[name] = value
            self._fresh.add(name)
            if message.param_index < message.param_count:
                self._indices.add(message.param_index)
                self._count = message.param_count
            self._answers.notify_all()
