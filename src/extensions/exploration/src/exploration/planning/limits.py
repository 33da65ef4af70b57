"""Where the UAV may not go, from a YAML file, with this package's errors."""

from __future__ import annotations

from pathlib import Path

import flight_limits
from flight_basics.errors import ParameterError
from flight_limits import Limits, LimitsError


def read_limits(path: str | Path) -> Limits:
    """Return the limits in a YAML file; see `flight_limits.parse_limits` for its form.

    Raises:
        ParameterError: it cannot be read or makes no sense. The sentence names the file.
    """
    try:
        return flight_limits.read_limits(path)
    except LimitsError as error:
        raise ParameterError(str(error)) from None
