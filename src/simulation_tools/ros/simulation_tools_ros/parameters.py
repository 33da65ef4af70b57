"""Parameters of this package's nodes, read so that a wrong one is a sentence."""

from __future__ import annotations

from contextlib import contextmanager
from typing import Iterator

from simulation_tools.values import ParameterError


@contextmanager
def reading_parameters(node: str) -> Iterator[None]:
    """Turn what a conversion of a parameter raises into a sentence."""
    try:
        yield
    except (TypeError, ValueError) as error:
        raise ParameterError(f"A parameter of {node} is of the wrong type: {error}.") from None
