"""A value is told only with what it rests on: its source, and how far it may be off."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from typing import Callable, Generic, Iterable, NamedTuple, Protocol, Sequence, TypeVar

SURE = 3.0
"""Two values contradict each other if they differ by more standard deviations of their difference.

99.7 % of normally distributed ones are within.
"""


class Told(Protocol):
    """What a source tells. deviation: standard deviation, in the unit in which two values are apart."""

    @property
    def source(self) -> str:
        """In words."""
        ...

    @property
    def deviation(self) -> float:
        """See the class."""
        ...


V = TypeVar("V")
T = TypeVar("T", bound=Told)


@dataclass(frozen=True)
class Sourced(Generic[V]):
    """A value, its source in words, and its standard deviation; see `Told`."""

    value: V
    source: str
    deviation: float


class Doubt(NamedTuple):
    """What makes one doubt a value. what: the same for all photographs of which it holds. why: a sentence."""

    what: str
    why: str


def best_of(
    candidates: Sequence[T],
    apart: Callable[[T, T], float],
    what: str,
    in_words: Callable[[T], str],
) -> tuple[T | None, tuple[Doubt, ...]]:
    """Return the surest of the candidates that agree, and a doubt for each that contradicts them.

    Those count with which most others agree; of two that contradict each other it is the first one. So list
    the candidates in the order in which you trust them. None: there is no candidate.
    """
    if not candidates:
        return None, ()

    def agreeing(one: T) -> list[T]:
        reach = [(each, SURE * math.hypot(one.deviation, each.deviation)) for each in candidates]
        return [each for each, most in reach if each is one or apart(one, each) <= most]

    kept = max(map(agreeing, candidates), key=len)
    best = min(kept, key=lambda each: each.deviation)
    others = [each for each in candidates if all(each is not one for one in kept)]
    return best, tuple(
        Doubt(
            f"{what}, {best.source}, {each.source}",
            f"{best.source} tells {what} as {in_words(best)}, but {each.source} as {in_words(each)}. "
            "The first one counts.",
        )
        for each in others
    )


def doubts_in_words(doubts: Iterable[tuple[str, Doubt]]) -> list[str]:
    """Return a sentence for each doubt, of (name, doubt), and of how many more it holds."""
    names: dict[str, list[tuple[str, str]]] = defaultdict(list)
    for name, doubt in doubts:
        names[doubt.what].append((name, doubt.why))
    return [
        f"{held[0][0]}: {held[0][1]}" + (f" So it is with {len(held) - 1} more." if held[1:] else "")
        for held in names.values()
    ]
