"""The thesis's claims as a table (`claims.yaml`), and their verdicts from our metrics."""

from __future__ import annotations

import operator
import re
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Callable, Mapping, Sequence

import yaml

from flights.errors import ResultsError
from master_thesis.report.content import ComparedClaim

TABLE = Path(__file__).with_name("claims.yaml")

_RELATIONS: Mapping[str, Callable[[float, float], bool]] = MappingProxyType(
    {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq}
)
_CONDITION = re.compile(r"(\w+) (<=|>=|==|<|>) (-?\d+(?:\.\d+)?)")

Value = int | float | str | None
Metrics = Mapping[str, Value]
"""Numbers and words by name. None counts as not there."""


@dataclass(frozen=True)
class Condition:
    """A metric, a relation and a threshold. Without the metric it does not hold."""

    metric: str
    relation: str
    threshold: float

    def holds(self, metrics: Metrics) -> bool:
        """Return whether the metric is there and keeps the threshold."""
        value = metrics.get(self.metric)
        return isinstance(value, (int, float)) and _RELATIONS[self.relation](value, self.threshold)


@dataclass(frozen=True)
class Case:
    """Words that are said if all conditions hold. {METRIC} in them stands for its value."""

    say: str
    conditions: tuple[Condition, ...] = ()


@dataclass(frozen=True)
class Claim:
    """A row of the table; its columns are described in `claims.yaml`."""

    claim: str
    source: str
    holds_if: tuple[Condition, ...]
    ours: tuple[Case, ...]
    otherwise: tuple[Case, ...]
    remark: tuple[Case, ...] = ()
    rests_on: tuple[str, str] | None = None

    def is_measured(self, metrics: Metrics) -> bool:
        """Return whether every metric that decides is there."""
        return all(metrics.get(condition.metric) is not None for condition in self.holds_if)

    def judged(self, metrics: Metrics) -> ComparedClaim:
        """Return the claim beside our metrics."""
        agrees = all(condition.holds(metrics) for condition in self.holds_if)
        why = _said(self.remark, metrics) + ("" if agrees else _said(self.otherwise, metrics))
        lone = self.rests_on is not None and metrics.get(self.rests_on[0]) == 1
        return ComparedClaim(
            claim=self.claim.format_map(metrics),
            source=self.source,
            ours=_said(self.ours, metrics),
            agrees=agrees,
            why=why,
            basis=f"one {self.rests_on[1]}" if self.rests_on and lone else "",
        )


def judged(section: str, metrics: Metrics) -> list[ComparedClaim]:
    """Return the claims of a section whose metrics are there, in the order of the table."""
    return [claim.judged(metrics) for claim in read_claims()[section] if claim.is_measured(metrics)]


def threshold_of(section: str, metric: str) -> float:
    """Return the threshold that decides on a claim."""
    conditions = (condition for claim in read_claims()[section] for condition in claim.holds_if)
    return next(condition.threshold for condition in conditions if condition.metric == metric)


def read_claims(path: Path = TABLE) -> dict[str, tuple[Claim, ...]]:
    """Return the table, by section.

    Raises:
        ResultsError: a row is not as described in `claims.yaml`.
    """
    found = {}
    for section, rows in yaml.safe_load(path.read_text(encoding="utf-8")).items():
        try:
            found[section] = tuple(map(_claim, rows))
        except (TypeError, ValueError, KeyError) as error:
            raise ResultsError(f"{path.name}: a claim of {section} cannot be read: {error}.") from None
    return found


def _claim(row: Mapping[str, Any]) -> Claim:
    given = dict(row)
    texts: dict[str, Any] = {name: _cases(given.pop(name, [])) for name in ("ours", "otherwise", "remark")}
    conditions = _conditions(given.pop("holds_if"))
    metric, what = given.pop("rests_on", (None, None))
    return Claim(holds_if=conditions, rests_on=(metric, what) if metric else None, **texts, **given)


def _conditions(written: str | Sequence[str]) -> tuple[Condition, ...]:
    found = []
    for words in [written] if isinstance(written, str) else written:
        match = _CONDITION.fullmatch(words)
        if match is None:
            raise ValueError(f"'{words}' is not METRIC RELATION THRESHOLD")
        found.append(Condition(match[1], match[2], float(match[3])))
    return tuple(found)


def _cases(written: str | Sequence[Mapping[str, Any]]) -> tuple[Case, ...]:
    if isinstance(written, str):
        return (Case(written),)
    return tuple(Case(case["say"], _conditions(case.get("if", ()))) for case in written)


def _said(cases: Sequence[Case], metrics: Metrics) -> str:
    """Return the words of the first case that holds; empty: there is none."""
    for case in cases:
        if all(condition.holds(metrics) for condition in case.conditions):
            return case.say.format_map(metrics)
    return ""
