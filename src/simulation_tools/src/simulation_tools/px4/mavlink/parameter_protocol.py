"""MAVLink's parameter protocol: list, read and set, with types. A write is answered with the new value."""

from __future__ import annotations

import struct
import zlib
from typing import Iterator

from pymavlink.dialects.v20 import common

from simulation_tools.autopilot import Px4Error
from simulation_tools.mavlink import decode_text, parameter_from_wire, parameter_to_wire
from simulation_tools.px4.failsafe import Say
from simulation_tools.px4.modes import Severity
from simulation_tools.px4.parameters import Px4Parameters

HASH_NAME = "_HASH_CHECK"  # PX4 answers this name with a checksum of all values, for clients' caches
_NO_INDEX = 65535


class ParameterProtocol:
    """Answers the messages of the protocol. `say` is called with the reason when a value is refused."""

    def __init__(self, parameters: Px4Parameters, say: Say) -> None:
        self._parameters = parameters
        self._say = say

    def list(self) -> Iterator[common.MAVLink_message]:
        """Yield the answers to PARAM_REQUEST_LIST."""
        return map(self.value, self._parameters)

    def read(self, m: common.MAVLink_param_request_read_message) -> common.MAVLink_message | None:
        """Answer PARAM_REQUEST_READ, by index or name; None for an unknown one, as in PX4."""
        name = self._parameters.name_at(m.param_index) if m.param_index >= 0 else decode_text(m.param_id)
        if name == HASH_NAME:
            return self._hash()
        return self.value(name) if name is not None and name in self._parameters else None

    def set(self, m: common.MAVLink_param_set_message) -> common.MAVLink_message | None:
        """Answer PARAM_SET with the value afterwards. An unknown name gets a text only, as from PX4."""
        name = decode_text(m.param_id)
        if name not in self._parameters:
            self._say(Severity.INFO, f"[pm] unknown param: {name}")
            return None
        try:
            if m.param_type != self._kind(name):
                wanted = "INT32" if self._parameters.spec(name).is_integer else "REAL32"
                raise Px4Error(f"its type is {wanted}")
            self._parameters.set(name, parameter_from_wire(m.param_value, m.param_type))
        except (Px4Error, ValueError) as error:
            self._say(Severity.ERROR, f"parameter {name}: {error}")
        return self.value(name)

    def value(self, name: str) -> common.MAVLink_message:
        """Return a parameter's PARAM_VALUE."""
        parameters, kind = self._parameters, self._kind(name)
        return common.MAVLink_param_value_message(
            name.encode("ascii"),
            parameter_to_wire(parameters[name], kind == common.MAV_PARAM_TYPE_INT32),
            kind,
            len(parameters),
            parameters.index_of(name),
        )

    def _kind(self, name: str) -> int:
        is_integer = self._parameters.spec(name).is_integer
        return common.MAV_PARAM_TYPE_INT32 if is_integer else common.MAV_PARAM_TYPE_REAL32

    def _hash(self) -> common.MAVLink_message:
        """Return the CRC-32 of all names and values."""
        checksum = 0
        for name in self._parameters:
            value, kind = self._parameters[name], self._kind(name)
            packed = struct.pack("<i" if kind == common.MAV_PARAM_TYPE_INT32 else "<f", value)
            checksum = zlib.crc32(packed, zlib.crc32(name.encode("ascii"), checksum))
        bits = struct.unpack("<f", struct.pack("<I", checksum))[0]
        return common.MAVLink_param_value_message(
            HASH_NAME.encode("ascii"), bits, common.MAV_PARAM_TYPE_UINT32, len(self._parameters), _NO_INDEX
        )
