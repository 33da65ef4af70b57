"""Reads parameters of this package's nodes. A wrong one gives an error of one sentence."""

from __future__ import annotations

from contextlib import contextmanager
from typing import Iterator

from simulation_tools.values import ParameterError


@contextmanager
def reading_parameters(node: str) -> Iterator[None]:
    """Turn a conversion error of a parameter into a ParameterError."""
    try:
        yield
    except (TypeError, ValueError) as error:
        raise ParameterError(f"A parameter of {node} is of the wrong type: {error}.") from None
