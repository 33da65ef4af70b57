"""MAVLink FTP for a flight controller without files: every request is answered, so that no client waits.

The payload of FILE_TRANSFER_PROTOCOL (https://mavlink.io/en/services/ftp.html), little endian:

| bytes | 0, 1 | 2 | 3 | 4 | 5 | 6 | 7 | 8 to 11 | from 12 |
|---|---|---|---|---|---|---|---|---|---|
| field | sequence | session | opcode | size | request's opcode | burst complete | - | offset | data |
"""

from __future__ import annotations

import struct

from pymavlink.dialects.v20 import common

NONE, RESET_SESSIONS = 0, 2
ACK, NAK = 128, 129
UNKNOWN_COMMAND = 7
"""The error in the first byte of a NAK's data."""
_HEADER = struct.Struct("<HBBBBBxI")
_PAYLOAD_BYTES = 251


def refuse_file_transfer(
    m: common.MAVLink_file_transfer_protocol_message,
) -> common.MAVLink_message | None:
    """Return the answer to a request; None if the message is an answer.

    The request to end all sessions succeeds, because there are none. Any other request is an unknown
    command.
    """
    sequence, session, opcode, _, _, _, offset = _HEADER.unpack_from(bytes(m.payload))
    if opcode in (ACK, NAK):
        return None
    done = opcode in (NONE, RESET_SESSIONS)
    data = b"" if done else bytes([UNKNOWN_COMMAND])
    header = _HEADER.pack((sequence + 1) % 65536, session, ACK if done else NAK, len(data), opcode, 0, offset)
    payload = (header + data).ljust(_PAYLOAD_BYTES, b"\0")
    return common.MAVLink_file_transfer_protocol_message(0, m.get_srcSystem(), m.get_srcComponent(), payload)
