"""Ways to plan which photographs are taken: an interface, and the ways that there are.

A way of one's own is one class and one entry of `PHOTOGRAPH_PLANNINGS`: CONTRIBUTING.md, "How to add".
"""

from __future__ import annotations

from typing import Callable, Mapping, Protocol

import numpy as np

from flight_basics.errors import ParameterError
from inspection.survey.views.cover import Cover


class PhotographPlanning(Protocol):
    """Chooses photographs from the places that a cover may take them from."""

    def fill(self, cover: Cover, most: int | None = None) -> None:
        """Add photographs until the cover is enough. most: so many at most, for a first short flight."""

    def improve(self, cover: Cover, rng: np.random.Generator, goes_on: Callable[[], bool]) -> None:
        """Make a cover that is enough cost less, while `goes_on` says so. It stays enough."""


class GreedyPlanning:
    """Lazy greedy, without what is idle after it; then a local search (`Cover`)."""

    def fill(self, cover: Cover, most: int | None = None) -> None:
        """Add the photograph that shows most for its cost, again and again."""
        cover.fill(most=most)
        if most is None and cover.shots:
            cover.drop_idle()

    def improve(self, cover: Cover, rng: np.random.Generator, goes_on: Callable[[], bool]) -> None:
        """Choose photographs near each other anew, and keep what costs less or shows more."""
        cover.improve(rng, goes_on)


PHOTOGRAPH_PLANNINGS: Mapping[str, Callable[[], PhotographPlanning]] = {"greedy": GreedyPlanning}


def photograph_planning(name: str) -> PhotographPlanning:
    """Return a way to plan photographs by its name.

    Raises:
        ParameterError: there is none of that name.
    """
    make = PHOTOGRAPH_PLANNINGS.get(name)
    if make is None:
        names = ", ".join(sorted(PHOTOGRAPH_PLANNINGS))
        raise ParameterError(f"planning is '{name}'; it must be one of {names}.")
    return make()
