"""Reads a bag for the doctor."""

from __future__ import annotations

import math
from pathlib import Path

import rosbag

from doctor.snapshot import Parameter, Recording
from doctor_ros.recorder import NOT_NEEDED, Recorder
from flights.errors import FlightsError
from node_tools.bags import DAMAGE


class BagError(FlightsError):
    """A bag that cannot be read."""


def read(path: Path) -> tuple[Recording, tuple[Parameter, ...]]:
    """Return a bag's recording, and the parameters that its nodes describe; raises BagError."""
    recorder, end_s = Recorder(), math.nan
    try:
        with rosbag.Bag(str(path)) as bag:
            if bag.version < 200:
                raise BagError(f"{path} is of bag format 1.2 (before 2010), which does not tell its nodes.")
            topics = [
                name
                for name, about in bag.get_type_and_topic_info().topics.items()
                if about.msg_type not in NOT_NEEDED
            ]
            for message in bag.read_messages(topics=topics, return_connection_header=True) if topics else ():
                header = message.connection_header
                caller, latched = _text(header.get("callerid", "")), _text(header.get("latching", "")) == "1"
                end_s = message.timestamp.to_sec()
                kind = message.message._type
                recorder.hear(message.topic, kind, caller, message.message, end_s, latched)
    except rosbag.ROSBagUnindexedException:
        raise BagError(f"{path} was not closed; mend it: rosbag reindex {path}") from None
    except FileNotFoundError:
        raise BagError(f"There is no bag {path}.") from None
    except DAMAGE as error:
        reason = getattr(error, "strerror", None) or error
        raise BagError(f"{path} cannot be read: {reason}.") from None
    return recorder.recording(end_s), recorder.parameters()


def _text(value: bytes | str) -> str:
    return value.decode() if isinstance(value, bytes) else value
