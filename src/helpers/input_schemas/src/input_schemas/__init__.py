"""Reads what people and other programs wrote into dataclasses. It imports no ROS."""

from input_schemas.files import read_file, read_made, read_without, text_of
from input_schemas.hooks import MaybeInfinite
from input_schemas.structuring import Fault, InputError, leaving_out, structured

__all__ = (
    "Fault",
    "InputError",
    "MaybeInfinite",
    "leaving_out",
    "read_file",
    "read_made",
    "read_without",
    "structured",
    "text_of",
)
