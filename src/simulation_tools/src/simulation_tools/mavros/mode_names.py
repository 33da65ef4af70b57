"""MAVROS's names of PX4's flight modes."""

from __future__ import annotations

# Some of MAVROS's names are not those of the modes' enumeration.
MODES = {
    "MANUAL": (1, 0),
    "ALTCTL": (2, 0),
    "POSCTL": (3, 0),
    "ACRO": (5, 0),
    "OFFBOARD": (6, 0),
    "STABILIZED": (7, 0),
    "RATTITUDE": (8, 0),
    "AUTO.READY": (4, 1),
    "AUTO.TAKEOFF": (4, 2),
    "AUTO.LOITER": (4, 3),
    "AUTO.MISSION": (4, 4),
    "AUTO.RTL": (4, 5),
    "AUTO.LAND": (4, 6),
    "AUTO.RTGS": (4, 7),
    "AUTO.FOLLOW_TARGET": (4, 8),
    "AUTO.PRECLAND": (4, 9),
}
_MODE_NAMES = {main << 16 | sub << 24: name for name, (main, sub) in MODES.items()}


def mode_name(custom_mode: int) -> str:
    """Return MAVROS's name of PX4's custom mode."""
    return _MODE_NAMES.get(custom_mode, f"CMODE({custom_mode})")


def custom_mode(name: str) -> int | None:
    """Return PX4's custom mode for MAVROS's name of it, or for a number as text; None when it is neither."""
    if name in MODES:
        main, sub = MODES[name]
        return main << 16 | sub << 24
    return int(name) if name.isdigit() and int(name) < 2**32 else None
