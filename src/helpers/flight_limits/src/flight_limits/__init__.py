"""Where a UAV may not fly: keep-out boxes, all but a box, and above a greatest height, from a YAML file."""

from flight_limits.limits import KeepOutBox, Limits, LimitsError, parse_limits, read_limits

__all__ = ["KeepOutBox", "Limits", "LimitsError", "parse_limits", "read_limits"]
