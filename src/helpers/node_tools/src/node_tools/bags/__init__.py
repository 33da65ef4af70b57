"""What reading a bag may raise."""

from __future__ import annotations

import struct

import genpy
import rosbag

DAMAGE = (
    rosbag.ROSBagException,
    genpy.DeserializationError,
    OSError,
    EOFError,
    ValueError,
    LookupError,
    struct.error,
)
"""The exceptions of rosbag and message classes for damaged bytes."""
