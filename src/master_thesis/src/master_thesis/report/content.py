"""The content of a section of the page. The template decides on its look."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Sequence


@dataclass(frozen=True)
class Table:
    """Rows of text.

    emphasis, theirs: indices of our rows and of the thesis's, if one table has both. words: number of last
    columns with words. theirs_last: the last column is the thesis's.
    """

    caption: str
    header: tuple[str, ...]
    rows: Sequence[Sequence[str]]
    emphasis: tuple[int, ...] = ()
    theirs: tuple[int, ...] = ()
    words: int = 0
    theirs_last: bool = False
    note: str = ""
    kind: str = "table"


@dataclass(frozen=True)
class Picture:
    """One of our pictures, and the thesis's picture or words at that place.

    alt: description of the picture. wide: it has panels side by side and takes the page's whole width.
    """

    svg: bytes
    caption: str
    alt: str
    thesis_figure: str = ""
    thesis_words: str = ""
    wide: bool = False
    kind: str = "picture"


@dataclass(frozen=True)
class ComparedClaim:
    """A statement of the thesis beside our numbers.

    agrees: computed from the numbers. why: what is said about the verdict. basis: for example "one flight",
    if the verdict has no more data; else empty.
    """

    claim: str
    source: str
    ours: str
    agrees: bool
    why: str = ""
    basis: str = ""


Block = Table | Picture


@dataclass(frozen=True)
class Section:
    """One experiment or measurement.

    method: two sentences. blocks: in the order of the page. findings: what agrees and what does not.
    missing: titles of missing pieces, with the reason if it is known.
    """

    key: str
    title: str
    reference: str
    method: str
    blocks: Sequence[Block]
    findings: Sequence[ComparedClaim]
    parameters: str = ""
    missing: Sequence[str] = field(default_factory=tuple)

    @property
    def is_computed(self) -> bool:
        """Whether any part of it was computed."""
        return bool(self.blocks or self.findings)

    @property
    def agreeing(self) -> int:
        """Number of the thesis's statements that agree with our numbers."""
        return sum(finding.agrees for finding in self.findings)


def number(value: float | None, digits: int) -> str:
    """Return a number with this many decimals, or a dash."""
    return "-" if value is None else f"{value:.{digits}f}"


def spread(values: Sequence[float], digits: int) -> str:
    """Return the mean of values with their standard deviation; of a single value without."""
    known = [value for value in values if value is not None]
    if not known:
        return "-"
    mean = sum(known) / len(known)
    if len(known) == 1:
        return number(mean, digits)
    deviation = (sum((value - mean) ** 2 for value in known) / len(known)) ** 0.5
    return f"{mean:.{digits}f} ± {deviation:.{digits}f}"


def counted(count: int, what: str) -> str:
    """Return "1 flight" or "3 flights"."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def seeds_of(seeds: Sequence[int]) -> str:
    """Return "seed 1" or "seeds 1 and 2"."""
    return f"seed{'s' if len(seeds) > 1 else ''} {listed(list(map(str, seeds)))}"


def listed(words: Sequence[str]) -> str:
    """Return "a, b and c"."""
    words = list(words)
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)
